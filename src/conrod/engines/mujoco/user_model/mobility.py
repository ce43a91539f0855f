"""Degrees of freedom that a compiled model really has: those of its joints minus the rank of its closures."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mobility_count import jacobian_rank
from conrod.motion import Array


@dataclass(frozen=True)
class Mobility:
    """Count of a model at one pose.

    Attributes:
        coordinates: degrees of freedom that the joints give (nv).
        rows: scalar equations of the active equality constraints.
        rank: of their Jacobian; rows beyond it are redundant.
    """

    coordinates: int
    rows: int
    rank: int

    @property
    def freedom(self) -> int:
        """Degrees of freedom that are left."""
        return self.coordinates - self.rank

    @property
    def redundant(self) -> int:
        """Rows that say what others say already."""
        return self.rows - self.rank


def mobility(model: mujoco.MjModel, data: mujoco.MjData) -> Mobility:
    """The count at the pose of the data, whose constraints `mj_fwdPosition` or `mj_forward` has made."""
    jacobian = equality_jacobian(model, data)
    return Mobility(model.nv, len(jacobian), jacobian_rank(jacobian))


def equality_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Jacobian (rows, nv) of the active equality constraints, dense whatever the model uses."""
    equality = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    columns = np.empty((data.nefc, model.nv))
    for k, direction in enumerate(np.eye(model.nv)):
        column = np.empty(data.nefc)
        mujoco.mj_mulJacVec(model, data, column, direction)
        columns[:, k] = column
    return columns[equality]
