"""Closures of a compiled model that can be hardened, and the inverse weights that soften them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.mjcf.edits import Edit
from conrod.mjcf.equalities import equality_kind, is_handle, ties_bodies
from conrod.mjcf.loading import name_or_number

Holder = Literal["body", "dof", "tendon"]


@dataclass(frozen=True)
class Closure:
    """An equality constraint that can be hardened.

    Attributes:
        holder, ends: kind and indices of the elements whose inverse weights regularise the closure.
        curved: whether the closure is nonlinear, so that MuJoCo's acceleration lacks a term in the velocity; its gap
            then goes with the square of its time constant, hardened or not.
    """

    index: int  # index of the equality
    name: str
    kind: str
    holder: Holder
    ends: tuple[int, ...]
    curved: bool = False


def active_closures(model: mujoco.MjModel) -> tuple[Closure, ...]:
    """Equality constraints that act from the start and can be hardened, without handles."""
    return tuple(one for one in hardenable_closures(model) if not is_handle(model, one.index))


def hardenable_closures(model: mujoco.MjModel) -> tuple[Closure, ...]:
    """Equality constraints that act from the start and can be hardened, mocap welds included."""
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_EQUALITY):
        return ()
    return tuple(
        _closure(model, index) for index in np.flatnonzero(model.eq_active0).tolist() if equality_kind(model, index)
    )


def _closure(model: mujoco.MjModel, index: int) -> Closure:
    """Describe an equality constraint by its index: its bodies or joints, and whether it is nonlinear."""
    name, kind = name_or_number(model, "equality", index), equality_kind(model, index)
    if ties_bodies(model, index):
        return Closure(index, name, kind, "body", tuple(compat.equality_bodies(model, index)))
    ends = tuple(int(end) for end in (model.eq_obj1id[index], model.eq_obj2id[index]) if end >= 0)
    bent = len(ends) > 1 and bool(np.any(model.eq_data[index, 2:5]))
    if kind == "joint":
        return Closure(index, name, kind, "dof", tuple(int(model.jnt_dofadr[joint]) for joint in ends), bent)
    # The length of a fixed tendon is linear in joint coordinates.
    fixed = all(model.wrap_type[model.tendon_adr[list(ends)]] == mujoco.mjtWrap.mjWRAP_JOINT)
    return Closure(index, name, kind, "tendon", ends, bent or not fixed)


def weight_rows(closures: Sequence[Closure]) -> dict[Holder, list[int]]:
    """Rows of the inverse weights that soften closures, by array; the world, body 0, has none."""
    ends: dict[Holder, set[int]] = {"body": set(), "dof": set(), "tendon": set()}
    for one in closures:
        ends[one.holder].update(one.ends)
    ends["body"].discard(0)
    return {holder: sorted(found) for holder, found in ends.items() if found}


def weight_edits(model: mujoco.MjModel, closures: Sequence[Closure], factor: float) -> list[Edit]:
    """Edits that multiply the inverse weights of what closures tie together, and so their regularisation.

    MuJoCo softens contacts by the weights of bodies, too, and limits and dry friction by those of degrees of freedom:
    such of the same bodies and joints harden with them.
    """
    edits = []
    for holder, rows in weight_rows(closures).items():
        kind, owners = ("joint", model.dof_jntid[rows].tolist()) if holder == "dof" else (holder, rows)
        named = [name_or_number(model, kind, owner) for owner in owners]
        edits.append(Edit(f"{holder}_invweight0", factor, rows, named))
    return edits
