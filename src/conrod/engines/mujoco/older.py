"""Differences of older releases of MuJoCo: models and rollouts that mean the same there. All of it is here.

What a release lacks altogether is refused with the reason; what it does wrong is left to be measured.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from conrod.engines.mujoco import MuJoCoSettings
from conrod.exact.motion import Array

RELEASE = tuple(map(int, re.findall(r"\d+", mujoco.__version__)))
# The first releases in which a bad state can be left as it is, equalities are of sites, rollouts take several data.
# (3.2.3 and 3.2.4, which had sites first, have errors in connects of them: on 3.2.3 six-bar ends by a signal.)
AUTORESET_FLAG, SITE_EQUALITIES, SEVERAL_DATA = (3, 2, 1), (3, 2, 5), (3, 2, 7)
# ... in which `connect` has the term of the changing Jacobian, without which no loop keeps the law of its errors, ...
JACOBIAN_RATE = (3, 7, 0)
UNBOUNDED = "MuJoCo before 3.7.0 leaves the rate of the Jacobian out of `connect`: errors of a loop have no bound"
# ... and in which an integrator, or an option, is there.
SINCE = {"discrete": (3, 13, 0)}


def lacking(settings: MuJoCoSettings) -> str | None:
    """None, or what this release lacks that settings ask for."""
    first = SINCE.get(settings.integrator, RELEASE)
    if first > RELEASE:
        return f"the integrator {settings.integrator} is there from MuJoCo {'.'.join(map(str, first))} on"
    return None


def closures_are_bounded() -> bool:
    """True if this release keeps loops as the law of its errors says; one that does not is measured, and not judged."""
    return RELEASE >= JACOBIAN_RATE


def resets_by_itself(settings: MuJoCoSettings) -> bool:
    """True if a state that has gone bad is put back to the start: as is asked for, or because it cannot be helped."""
    return settings.autoreset or RELEASE < AUTORESET_FLAG


def adapt(root: ET.Element, release: tuple[int, ...] | None = None) -> bool:
    """Change a model to one that means the same in a release, or this one; return whether anything had to be."""
    release = RELEASE if release is None else release
    if release < AUTORESET_FLAG:
        for flag in root.iterfind("option/flag"):
            flag.attrib.pop("autoreset", None)
    if release < SITE_EQUALITIES:
        holders = {site.get("name"): (body, site) for body in root.iter() for site in body.iterfind("site")}
        for connect in root.iterfind("equality/connect[@site1]"):
            (first, site), (second, _) = (holders[connect.attrib.pop(name)] for name in ("site1", "site2"))
            # The second anchor is where the first one is in the compiled pose, in which every loop is closed.
            ends = [body.get("name", "world") for body in (first, second)]
            connect.attrib |= {"body1": ends[0], "body2": ends[1], "anchor": site.get("pos", "0 0 0")}
    return release < max(AUTORESET_FLAG, SITE_EQUALITIES)


def bodies_of(model: mujoco.MjModel, equality: int) -> list[int]:
    """Numbers of the two bodies that a connect or weld ties together."""
    ends = [int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])]
    return [int(body) for body in model.site_bodyid[ends]] if of_sites(model)[equality] else ends


def of_sites(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Mask of which of a model's equalities (neq,) is of sites, which the first releases do not have."""
    kinds = getattr(model, "eq_objtype", np.zeros(model.neq))
    return np.asarray(kinds == int(mujoco.mjtObj.mjOBJ_SITE), dtype=bool)


def flag(name: str) -> int:
    """The bit that disables something, mjDSBL_NAME; 0 where this release has none."""
    found = mujoco.mjtDisableBit.__members__.get(f"mjDSBL_{name}")
    return 0 if found is None else int(found)


def enabling_flag(name: str) -> int:
    """The bit that enables something, mjENBL_NAME; 0 where this release has none."""
    found = mujoco.mjtEnableBit.__members__.get(f"mjENBL_{name}")
    return 0 if found is None else int(found)


def roll_out(
    model: mujoco.MjModel, data: mujoco.MjData, begin: Array, guess: Array, states: Array, sensors: Array
) -> None:
    """Step from a state (1, nstate) with a first guess (1, nv), into states and sensor data (1, steps, ..)."""
    rollout.rollout(
        model,
        data if RELEASE < SEVERAL_DATA else [data],
        begin,
        nstep=sensors.shape[1],
        initial_warmstart=guess,
        state=states,
        sensordata=sensors,
    )
