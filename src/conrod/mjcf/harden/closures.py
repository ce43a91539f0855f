"""Closed loops of a compiled model: the equality constraints that can be hardened, and how soft they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from conrod.engines.mujoco.settings import LEAST_IMPEDANCE, MOST_IMPEDANCE, STOCK_SOLIMP, STOCK_SOLREF
from conrod.exact.motion import Array
from conrod.mjcf.equalities import bodies_of, kind_of, ties_bodies
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
        return Closure(index, name, kind, "body", bodies_of(model, index))
    ends = tuple(int(end) for end in (model.eq_obj1id[index], model.eq_obj2id[index]) if end >= 0)
    bent = len(ends) > 1 and bool(np.any(model.eq_data[index, 2:5]))
    if kind == "joint":
        return Closure(index, name, kind, "dof", tuple(int(model.jnt_dofadr[joint]) for joint in ends), bent)
    # The length of a fixed tendon is linear in joint coordinates.
    first = [int(model.tendon_adr[tendon]) for tendon in ends]
    fixed = all(model.wrap_type[first] == mujoco.mjtWrap.mjWRAP_JOINT)
    return Closure(index, name, kind, "tendon", ends, bent or not fixed)


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
