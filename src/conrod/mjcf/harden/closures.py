"""Closed loops of a compiled model: the equality constraints that can be hardened, how soft and how open they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from conrod.engines.mujoco.settings import LEAST_IMPEDANCE, MOST_IMPEDANCE, STOCK_SOLIMP, STOCK_SOLREF
from conrod.exact.motion import Array
from conrod.mjcf.equalities import bodies_of, kind_of, owners, ties_bodies
from conrod.mjcf.harden.results import Loop
from conrod.own.models.loading import name_or_number

Holder = Literal["body", "dof", "tendon"]


@dataclass(frozen=True)
class Closure:
    """One equality constraint that can be hardened.

    Attributes:
        holder, ends: whose inverse weights its regularisation is taken from, by index.
        curved: MuJoCo's acceleration of it lacks the part of the velocity: it opens with the square of its time
            constant, hardened or not.
    """

    index: int  # of the equality
    name: str
    kind: str
    units: tuple[str, ...]  # of its measures, "m" or "rad": a weld's place and its turn are two
    holder: Holder
    ends: tuple[int, ...]
    curved: bool = False


def active_closures(model: mujoco.MjModel) -> tuple[Closure, ...]:
    """The equality constraints that act from the start, of the kinds that can be hardened."""
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_EQUALITY):
        return ()
    return tuple(
        closure(model, index) for index in range(model.neq) if model.eq_active0[index] and kind_of(model, index)
    )


def closure(model: mujoco.MjModel, index: int) -> Closure:
    """An equality as a closure."""
    name, kind = name_or_number(model, "equality", index), kind_of(model, index)
    if ties_bodies(model, index):
        return Closure(index, name, kind, ("m", "rad")[: 1 + (kind == "weld")], "body", bodies_of(model, index))
    ends = tuple(int(end) for end in (model.eq_obj1id[index], model.eq_obj2id[index]) if end >= 0)
    bent = len(ends) > 1 and bool(np.any(model.eq_data[index, 2:5]))
    if kind == "joint":
        rates = tuple(int(model.jnt_dofadr[joint]) for joint in ends)
        return Closure(index, name, kind, _unit(model, ends[0]), "dof", rates, bent)
    # The length of a fixed tendon is linear in joint coordinates.
    first = [int(model.tendon_adr[tendon]) for tendon in ends]
    fixed = [mujoco.mjtWrap(model.wrap_type[wrap]) == mujoco.mjtWrap.mjWRAP_JOINT for wrap in first]
    units = _unit(model, int(model.wrap_objid[first[0]])) if fixed[0] else ("m",)
    return Closure(index, name, kind, units, "tendon", ends, bent or not all(fixed))


def _unit(model: mujoco.MjModel, joint: int) -> tuple[str, ...]:
    return ("rad",) if mujoco.mjtJoint(model.jnt_type[joint]) == mujoco.mjtJoint.mjJNT_HINGE else ("m",)


# -- softness --------------------------------------------------------------------------------------------------------


def impedance(solimp: Array) -> float:
    """MuJoCo's impedance d of a closed constraint: solimp's first number, or the mean where there is no width."""
    first, last = np.clip(solimp[:2], LEAST_IMPEDANCE, MOST_IMPEDANCE)
    return float(first if solimp[2] > 0.0 else 0.5 * (first + last))


def compliance(solref: Array, solimp: Array, least_time: float) -> float:
    """Opening of a constraint [m] under a force, over the acceleration that this gives its inverse weight [s^2].

    A constraint at rest under a force f is open by f R / (k d), R = (1 - d) / d x (inverse weight),
    k = 1 / (d_max^2 x time constant^2 x damping ratio^2) (MuJoCo's documentation, "Computation", solver parameters).
    """
    d, widest = impedance(solimp), float(np.clip(solimp[1], LEAST_IMPEDANCE, MOST_IMPEDANCE))
    constant = max(float(solref[0]), least_time)
    return (1.0 - d) / d**2 * (widest * constant * float(solref[1])) ** 2


def softer_than_stock(model: mujoco.MjModel, index: int) -> bool:
    """Return True where an equality gives way more than a stock one."""
    unsafe = int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    least = 0.0 if unsafe else 2.0 * float(model.opt.timestep)  # the least time constant that MuJoCo admits [s]
    stock = compliance(np.array(STOCK_SOLREF), np.array(STOCK_SOLIMP), least)
    # Twelve digits: what was written as stock is stock.
    return compliance(model.eq_solref[index], model.eq_solimp[index], least) > stock * (1.0 + 1e-12)


# -- how far they are open -------------------------------------------------------------------------------------------


def loops_of(closures: Sequence[Closure]) -> tuple[Loop, ...]:
    """Measures of closures."""
    return tuple(Loop(one.name, one.kind, unit) for one in closures for unit in one.units)


def openings(model: mujoco.MjModel, data: mujoco.MjData, closures: Sequence[Closure]) -> Array:
    """(loops,) how far each is open, in data whose constraints were made; 0 for one that is switched off."""
    found: list[float] = []
    gaps, ids = data.efc_pos[: data.ne], owners(data)
    for one in closures:
        gap = gaps[ids == one.index]
        if one.kind == "weld":
            scale = float(model.eq_data[one.index, 10])  # the row of the turn is torquescale x sin(angle / 2)
            half = min(1.0, float(np.linalg.norm(gap[3:])) / scale) if scale > 0.0 else 0.0
            found += [float(np.linalg.norm(gap[:3])), 2.0 * float(np.arcsin(half))]
        else:
            found.append(float(np.linalg.norm(gap)))
    return np.array(found)
