"""How MuJoCo's constraint solver ended at a step: how long it took, and what it left.

The solver is to find accelerations a of the constraints and forces f with a = J qacc_smooth + A f, A = J M^-1 J^T, and
a = aref - R f: where a constraint acts (MuJoCo documentation, Computation, 'Constraint model'). Newton and CG take f
from qacc by the second, so that a stop leaves the first unsolved; PGS takes qacc from f by the first and leaves the
second. Both are here eliminated: (A + R) f = aref - J qacc_smooth, a small system, is solved directly, and what the
solver left is how far the accelerations J qacc, which the engine steps with, are from a. So regularisation, which
is no error of the solver, does not count, and forces that a hardened model has lost digits of do not either.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.motion import Array
from conrod.trajectory import SolverState


def solver_state(model: mujoco.MjModel, data: mujoco.MjData) -> SolverState | None:
    """The solver in data that `mj_forward` has made, of which nothing is changed.

    (After a step of RK4 the data is a mixture: its accelerations are the mean of the stages.)

    Returns:
        None where no constraint is there to solve, or its numbers are not finite.
    """
    if data.nefc == 0:
        return None
    jacobian, yielding = np.empty((data.nefc, model.nv)), np.empty((data.nefc, model.nv))
    for k, direction in enumerate(np.eye(model.nv)):
        column = np.empty(data.nefc)
        mujoco.mj_mulJacVec(model, data, column, direction)
        jacobian[:, k] = column
    mujoco.mj_solveM(model, data, yielding, jacobian)  # J M^-1
    # Numbers of a run that is about to diverge may be too large to be multiplied.
    with np.errstate(all="ignore"):
        free, found = jacobian @ data.qacc_smooth, jacobian @ data.qacc
        answer = yielding @ jacobian.T
        system, missing = answer + np.diag(data.efc_R), data.efc_aref - free
    if not all(np.all(np.isfinite(values)) for values in (system, missing, found)):
        return None
    one_way = np.asarray(data.efc_type != mujoco.mjtConstraint.mjCNSTR_EQUALITY, dtype=bool)
    exact = free + answer @ constraint_forces(system, missing, one_way)
    iterations = int(data.solver_niter[: max(data.nisland, 1)].max())
    return SolverState(iterations, float(np.abs(found - exact).max()))


def constraint_forces(system: Array, missing: Array, one_way: NDArray[np.bool_]) -> Array:
    """Forces f (n,) with S f = m where a constraint acts; one that only pushes acts where f > 0, else S f >= m.

    Args:
        system: S (n, n), symmetric, its diagonal positive.
    """
    # The rows of links of very different weight are brought to one size; redundant ones share their force.
    scale = 1.0 / np.sqrt(np.diag(system))
    scaled = scale[:, None] * system * scale
    acting, force = np.ones(len(missing), dtype=bool), np.zeros(len(missing))
    # Of the sets of contacts that act, of which a machine has few, one is the right one.
    for _ in range(2 ** int(one_way.sum())):
        chosen = np.ix_(acting, acting)
        force = np.zeros(len(missing))
        force[acting] = scale[acting] * np.linalg.lstsq(scaled[chosen], (scale * missing)[acting], rcond=None)[0]
        wanted = ~one_way | np.where(acting, force > 0.0, system @ force < missing)
        if np.array_equal(wanted, acting):
            break
        acting = wanted
    return force
