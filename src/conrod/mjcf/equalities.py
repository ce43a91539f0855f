"""Equality constraints of a compiled MuJoCo model: what they tie together, how far they are open, and a closed pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.mobility import jacobian_rank
from conrod.engines.mujoco import older
from conrod.engines.mujoco.model import equality_jacobian
from conrod.exact.motion import Array
from conrod.own.models.loading import name_or_number

KINDS = {
    mujoco.mjtEq.mjEQ_CONNECT: "connect",
    mujoco.mjtEq.mjEQ_WELD: "weld",
    mujoco.mjtEq.mjEQ_JOINT: "joint",
    mujoco.mjtEq.mjEQ_TENDON: "tendon",
}
# A row whose entries are all below this share of the largest entry of all rows says nothing: rounding is 1e-16 of it.
EMPTY = 1e-12
PASSES = 50
REDUNDANT = 1e-9  # singular values below this share of the largest are redundant rows


@dataclass(frozen=True)
class Rows:
    """Rows of the active equality constraints at one pose."""

    ids: NDArray[np.int_]  # (r,) the equality that each row belongs to
    jacobian: Array  # (r, nv)
    gaps: Array  # (r,) how far each is violated [m or rad]
    rates: Array  # (r,) of the gaps

    @cached_property
    def effective(self) -> NDArray[np.bool_]:
        """(r,) rows that hold anything."""
        sizes = np.abs(self.jacobian).max(axis=1, initial=0.0)
        return np.asarray(sizes > EMPTY * sizes.max(initial=0.0))

    @cached_property
    def rank(self) -> int:
        """Rank of all rows."""
        return jacobian_rank(self.jacobian)

    def rank_without(self, gone: list[int]) -> int:
        """Rank of the rows of all but some equalities."""
        return jacobian_rank(self.jacobian[~np.isin(self.ids, gone)])


def rows_at(model: mujoco.MjModel, data: mujoco.MjData) -> Rows:
    """Equality constraints in data that `mj_forward` has made."""
    gaps, rates = np.array(data.efc_pos[: data.ne]), np.array(data.efc_vel[: data.ne])
    return Rows(owners(data), equality_jacobian(model, data), gaps, rates)


def owners(data: mujoco.MjData) -> NDArray[np.int_]:
    """Equality (r,) that each row belongs to; they come first among the constraints."""
    return np.array(data.efc_id[: data.ne], dtype=int)


def openings(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Opening (neq,) [m] of each connect or weld, 0 for others and those that are off."""
    return lengths(model, owners(data), data.efc_pos[: data.ne])


def lengths(model: mujoco.MjModel, ids: NDArray[np.int_], values: Array) -> Array:
    """Length (neq,) of the translational part, the first three, of each connect's or weld's values (r,)."""
    tied = [ties_bodies(model, index) for index in range(model.neq)]
    return np.array([tied[i] * np.linalg.norm(values[ids == i][:3]) for i in range(model.neq)], dtype=float)


def close_loops(model: mujoco.MjModel, data: mujoco.MjData, closed: float) -> bool:
    """Move data to the nearest pose in which no equality is open by more, by Newton iteration; False for none."""
    for _ in range(PASSES):
        mujoco.mj_fwdPosition(model, data)
        rows = rows_at(model, data)
        if not (np.isfinite(rows.gaps).all() and np.isfinite(rows.jacobian).all()):
            return False
        if np.abs(rows.gaps).max(initial=0.0) <= closed:
            return True
        step = -np.linalg.lstsq(rows.jacobian, rows.gaps, rcond=REDUNDANT)[0]
        mujoco.mj_integratePos(model, data.qpos, step, 1.0)
    return False


def kind_of(model: mujoco.MjModel, index: int) -> str:
    """Kind of an equality; empty for that of a flex."""
    return KINDS.get(mujoco.mjtEq(model.eq_type[index]), "")


def ties_bodies(model: mujoco.MjModel, index: int) -> bool:
    """Return True for a connect or a weld."""
    return kind_of(model, index) in ("connect", "weld")


def bodies_of(model: mujoco.MjModel, index: int) -> tuple[int, int]:
    """The bodies that a connect or weld ties together."""
    one, other = older.bodies_of(model, index)
    return one, other


def ties(model: mujoco.MjModel) -> list[tuple[int, tuple[int, int]]]:
    """Active connects and welds, with the moving parts that they tie together: bodies, those without joints apart."""
    found = []
    for index in range(model.neq):
        if ties_bodies(model, index) and model.eq_active0[index]:
            one, other = bodies_of(model, index)
            found.append((index, (int(model.body_weldid[one]), int(model.body_weldid[other]))))
    return found


def closure_name(model: mujoco.MjModel, index: int) -> str:
    """Name of an equality, or its number and what it ties together."""
    name, kind = name_or_number(model, "equality", index), kind_of(model, index)
    if mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_EQUALITY, index) or not kind:
        return name
    bodies = ties_bodies(model, index)
    ends = bodies_of(model, index) if bodies else (int(model.eq_obj1id[index]), int(model.eq_obj2id[index]))
    named = [name_or_number(model, "body" if bodies else kind, end) for end in ends if end >= 0]
    return f"{name} ({' to '.join(named)})"
