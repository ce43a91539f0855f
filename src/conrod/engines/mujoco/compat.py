"""Compatibility with older releases of MuJoCo: models and rollouts with the same meaning. All of it is here.

A feature that a release lacks is refused with the reason; what a release computes wrongly is left to be measured.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from conrod.engines.engine import DeferredLibrary
from conrod.engines.mujoco import MuJoCoSettings
from conrod.exact.motion import Array

if TYPE_CHECKING:
    import mujoco
    from mujoco import rollout
else:
    mujoco = DeferredLibrary("mujoco")
    rollout = DeferredLibrary("mujoco.rollout")

MUJOCO_VERSION = version("mujoco")
RELEASE = tuple(map(int, re.findall(r"\d+", MUJOCO_VERSION)))
# First releases with the flag `autoreset`, with equalities between sites, and with rollouts of several MjData.
# (3.2.3 and 3.2.4, which had site equalities first, have errors in their connects: on 3.2.3 six-bar ends by a signal.)
AUTORESET_FLAG, SITE_EQUALITIES, ROLLOUT_DATA_LISTS = (3, 2, 1), (3, 2, 5), (3, 2, 7)
# First release whose `connect` has the term dJ/dt v, without which loops do not keep their error law.
CONNECT_JACOBIAN_RATE = (3, 7, 0)
# Whether this release keeps loops within the error law; else loops are measured, not judged.
CLOSURES_ARE_BOUNDED = RELEASE >= CONNECT_JACOBIAN_RATE
UNBOUNDED_REASON = (
    "MuJoCo before 3.7.0 leaves the rate of the Jacobian out of `connect`: errors of a loop have no bound"
)
# First releases that have an integrator.
FIRST_RELEASE = {"discrete": (3, 13, 0)}


def missing_feature(settings: MuJoCoSettings) -> str | None:
    """Return which feature of the settings this release lacks, or None."""
    first = FIRST_RELEASE.get(settings.integrator, RELEASE)
    if first > RELEASE:
        return f"the integrator {settings.integrator} is there from MuJoCo {'.'.join(map(str, first))} on"
    return None


def resets_by_itself(settings: MuJoCoSettings) -> bool:
    """Return True if MuJoCo resets a state with bad numbers, as set or because this release always does."""
    return settings.autoreset or RELEASE < AUTORESET_FLAG


def adapt_model(root: ET.Element, release: tuple[int, ...] | None = None) -> bool:
    """Change a model's XML to the same meaning in a release (default: this one); return whether it may have changed."""
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


def equality_bodies(model: mujoco.MjModel, equality: int) -> list[int]:
    """Indices of the two bodies that a connect or weld ties together."""
    ends = [int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])]
    return [int(body) for body in model.site_bodyid[ends]] if site_equalities(model)[equality] else ends


def site_equalities(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Mask (neq,) of a model's equalities between sites; all False in the first releases."""
    kinds = getattr(model, "eq_objtype", np.zeros(model.neq))
    return np.asarray(kinds == int(mujoco.mjtObj.mjOBJ_SITE), dtype=bool)


def disable_bit(name: str) -> int:
    """The bit mjDSBL_NAME of the disable flags; 0 if this release has none."""
    found = mujoco.mjtDisableBit.__members__.get(f"mjDSBL_{name}")
    return 0 if found is None else int(found)


def enable_bit(name: str) -> int:
    """The bit mjENBL_NAME of the enable flags; 0 if this release has none."""
    found = mujoco.mjtEnableBit.__members__.get(f"mjENBL_{name}")
    return 0 if found is None else int(found)


def roll_out(
    model: mujoco.MjModel, data: mujoco.MjData, begin: Array, guess: Array, states: Array, sensors: Array
) -> None:
    """Step from a state (1, nstate) with a warm start (1, nv), filling states and sensor data (1, steps, ..)."""
    rollout.rollout(
        model,
        data if RELEASE < ROLLOUT_DATA_LISTS else [data],
        begin,
        nstep=sensors.shape[1],
        initial_warmstart=guess,
        state=states,
        sensordata=sensors,
    )
