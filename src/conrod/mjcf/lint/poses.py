"""Equality constraints that close loops.

The constraints of a model at some of the poses of a run: their rows, openings and rank.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.mobility import jacobian_rank
from conrod.exact.motion import Array
from conrod.mjcf.lint.motion import Run, Start, State
from conrod.own.models.loading import name_or_number

CLOSING = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))


def closing(model: mujoco.MjModel, index: int) -> bool:
    """Whether an equality holds two bodies together."""
    return int(model.eq_type[index]) in CLOSING


def equality_bodies(model: mujoco.MjModel, index: int) -> tuple[int, int]:
    """The bodies that a connect or weld ties together."""
    ends = (int(model.eq_obj1id[index]), int(model.eq_obj2id[index]))
    if model.eq_objtype[index] == mujoco.mjtObj.mjOBJ_SITE:
        return int(model.site_bodyid[ends[0]]), int(model.site_bodyid[ends[1]])
    return ends


def closure_name(model: mujoco.MjModel, index: int) -> str:
    """How to speak of an equality: by its name, or by its number and what it ties together."""
    name = name_or_number(model, "equality", index)
    if mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_EQUALITY, index) or not closing(model, index):
        return name
    one, other = (name_or_number(model, "body", body) for body in equality_bodies(model, index))
    return f"{name} ({one} to {other})"


LOOKS = 40
# Of a model of many coordinates fewer, or their ranks would take longer than its run.
FEWEST, COORDINATES = 3, 100
# A row whose entries are all below this share of the largest entry of all rows says nothing: rounding is 1e-16 of it.
EMPTY = 1e-12


@dataclass(frozen=True)
class Rows:
    """Equality constraints at one pose.

    Attributes:
        ids: (r,) the equality that each row belongs to.
        jacobian: (r, nv).
    """

    ids: NDArray[np.int_]
    jacobian: Array

    @cached_property
    def said(self) -> NDArray[np.bool_]:
        """(r,) which rows say anything."""
        sizes = np.abs(self.jacobian).max(axis=1, initial=0.0)
        return np.asarray(sizes > EMPTY * sizes.max(initial=0.0))

    @property
    def rank(self) -> int:
        """Of all rows."""
        return jacobian_rank(self.jacobian)


class Poses:
    """A look at a run that was made."""

    def __init__(self, model: mujoco.MjModel, start: Start, run: Run) -> None:
        self.model, self._start, self._run = model, start, run

    def each(self, every: int = 0) -> Iterator[mujoco.MjData]:
        """Data of poses along the run, with all that `mj_forward` makes; one object, used again and again.

        Args:
            every: take every so manieth sample, 0 for some `LOOKS` poses.
        """
        data = self._start.data(self.model)
        looks = min(LOOKS, max(FEWEST, LOOKS * COORDINATES**2 // self.model.nv**2))
        states = self._run.states
        for state in states[:: every or max(1, len(states) // looks)]:
            load(data, state)
            mujoco.mj_forward(self.model, data)
            yield data

    @cached_property
    def rows(self) -> list[Rows]:
        """Equality constraints at each look."""
        return [equality_rows(self.model, data) for data in self.each()]

    @cached_property
    def openings(self) -> Array:
        """(samples, neq) how far each connect or weld is open [m]; 0 for other equalities and those that are off."""
        found = [openings(self.model, data) for data in self.each(1)]
        return np.array(found).reshape(len(found), self.model.neq)

    @cached_property
    def freedom(self) -> int:
        """Degrees of freedom that the closures leave, at the pose where they leave the fewest."""
        coordinates = int(self.model.nv)
        return min((coordinates - rows.rank for rows in self.rows), default=coordinates)


def load(data: mujoco.MjData, state: State) -> None:
    """Put a sample into data."""
    data.qpos[:], data.qvel[:], data.act[:], data.qacc_warmstart[:] = state.qpos, state.qvel, state.act, state.guess


def equality_rows(model: mujoco.MjModel, data: mujoco.MjData) -> Rows:
    """The rows of equality constraints in data that `mj_forward` has made."""
    chosen = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    jacobian = np.empty((len(chosen), model.nv))
    column = np.empty(data.nefc)
    if len(chosen):
        for k, direction in enumerate(np.eye(model.nv)):
            mujoco.mj_mulJacVec(model, data, column, direction)
            jacobian[:, k] = column[chosen]
    return Rows(data.efc_id[chosen].astype(int), jacobian)


def openings(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """(neq,) how far each connect or weld is open [m] in data that `mj_forward` has made."""
    found = np.zeros(model.neq)
    for index in range(model.neq):
        if closing(model, index):
            found[index] = np.linalg.norm(violation(data, index)[:3])
    return found


def violation(data: mujoco.MjData, index: int) -> Array:
    """(rows,) of an equality, translations first [m]."""
    mine = (data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY) & (data.efc_id[: data.nefc] == index)
    return np.array(data.efc_pos[: data.nefc][mine])
