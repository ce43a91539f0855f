"""What moves a model: its degrees of freedom, redundant equations, and the actuators that drive each freedom."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.engines.mujoco.model import equality_jacobian
from conrod.exact.motion import Array
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.mjcf.equalities import close_loops, closure_name, handle_indices, handle_words, row_equalities
from conrod.mjcf.loading import list_names, name_or_number
from conrod.models.inspection.actuator_kinds import read_actuators
from conrod.models.inspection.actuator_runs import free_motions, moment

CLOSED = 1e-10  # of the model's extent, that closures are closed to before their rank is counted
MIN_SHARE = 1e-6  # of a motion, from which on a joint takes part in it
MAX_DOFS = 400  # degrees of freedom up to which ranks are counted


@dataclass(frozen=True)
class ModelMobility:
    """Degrees of freedom of a model at a closed pose, and what drives them.

    Attributes:
        joints: degrees of freedom of all joints.
        rows, rank: scalar equations of the closures, and how many are independent.
        redundant: number of equations of each closure that those before it imply.
        actuators: number of actuators that move something.
        driven: degrees of freedom that actuators can push independently.
        undriven: joints that move where all that is driven is held.
        handles: connects and welds that drag a body after a mocap body, in words; they close no loop.
        closed: whether the pose could be closed; the rank is of the open pose otherwise.
    """

    joints: int
    rows: int
    rank: int
    redundant: dict[str, int]
    actuators: int
    driven: int
    undriven: tuple[str, ...]
    handles: str = ""
    closed: bool = True

    @property
    def freedom(self) -> int:
        """Degrees of freedom that the closures leave."""
        return self.joints - self.rank

    @property
    def is_stuck(self) -> bool:
        """True if the closures leave joints that nothing can move."""
        return self.joints > 0 and self.freedom == 0

    @property
    def words(self) -> str:
        """The mobility and what drives it, in a sentence."""
        return "; ".join(self._said())

    def _said(self) -> Iterator[str]:
        many = "degree of freedom" if self.freedom == 1 else "degrees of freedom"
        of = (
            f" ({self.joints} of the joints less {self.rank} of {self.rows} equations of closures)" if self.rows else ""
        )
        driven = f"{self.driven} driven by {self.actuators} actuator{'s' if self.actuators != 1 else ''}"
        if not self.actuators:
            driven = "no actuator drives it" if self.freedom == 1 else "no actuator drives them"
        elif self.driven == self.freedom:
            driven = f"driven by {self.actuators} actuator{'s' if self.actuators != 1 else ''}"
        yield f"{self.freedom} {many}{of}, {driven}" if self.freedom else f"nothing: no degree of freedom is left{of}"
        if self.actuators and self.undriven:
            yield f"{self.freedom - self.driven} undriven: {list_names(self.undriven)}"
        if self.redundant:
            spare = list_names(f"{number} of {name}" for name, number in self.redundant.items())
            yield f"redundant equations: {spare}"
        if self.handles:
            yield self.handles
        if not self.closed:
            yield "counted at a pose that is not closed"


def count_model_mobility(model: mujoco.MjModel, start: mujoco.MjData) -> ModelMobility | None:
    """Count the degrees of freedom of a model at the closed pose nearest to a start; None if it has too many.

    Args:
        start: data at the start; it is not changed.
    """
    if model.nv > MAX_DOFS:
        return None
    data = copy.copy(start)
    with silence_warnings():
        closed = close_loops(model, data, CLOSED * float(model.stat.extent))
        if not closed:
            data = copy.copy(start)
        mujoco.mj_forward(model, data)
    jacobian, owners = equality_jacobian(model, data), row_equalities(data)
    closing = ~np.isin(owners, handle_indices(model))
    jacobian, owners = jacobian[closing], owners[closing]
    basis, redundant, before = free_motions(model, jacobian), dict[str, int](), 0
    for k in dict.fromkeys(owners.tolist()):
        rows = np.flatnonzero(owners == k)
        after = _rank(jacobian[: rows[-1] + 1])
        if spare := len(rows) - (after - before):
            redundant[closure_name(model, k)] = spare
        before = after
    tried = [one for one in read_actuators(model) if not one.untried]
    pushes = np.array([moment(model, data, one) @ basis for one in tried]).reshape(len(tried), basis.shape[1])
    scale = np.abs(pushes).max(axis=1, initial=0.0)
    pushes = pushes[scale > MIN_SHARE] / scale[scale > MIN_SHARE, None]
    driven = _rank(pushes)
    left = basis @ np.linalg.svd(pushes)[2][driven:].T if len(pushes) else basis
    moved = np.abs(left).max(axis=1, initial=0.0)
    names = [name_or_number(model, "joint", int(j)) for j in model.dof_jntid]
    undriven = dict.fromkeys(n for n, size in zip(names, moved.tolist(), strict=True) if size > MIN_SHARE)
    return ModelMobility(
        model.nv, len(owners), before, redundant, int(np.sum(scale > MIN_SHARE)), driven, tuple(undriven),
        handle_words(model, handle_indices(model)), closed,
    )  # fmt: skip


def _rank(matrix: Array) -> int:
    """Numerical rank: singular values above `RANK_TOLERANCE` times the largest."""
    values = np.linalg.svd(matrix, compute_uv=False) if matrix.size else np.zeros(1)
    return int(np.sum(values > RANK_TOLERANCE * values[0]))
