"""MuJoCo's other solvers against Newton's method: the same accelerations, within what their residuals allow.

The accelerations a minimise f(a) = 1/2 (a - a0)' M (a - a0) + s(J a - a_ref), s convex (MuJoCo documentation,
Computation, Primal problem). With g the gradient of f at a, and a* the minimum,

    |a - a*|_M^2 <= g' (a - a*) <= |g|_{M^-1} |a - a*|_M, so |a - a*|_M <= |g|_{M^-1} = sqrt(g' M^-1 g),

whatever solver found a, and wherever it stopped (Boyd and Vandenberghe, Convex Optimization, 9.1.2, with M for the
Hessian's bound). Two solvers may differ by the sum of their residuals |g|_{M^-1}, beside rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.models.invariances.accelerations import forward, with_converged_solver
from conrod.models.invariances.changes import InvarianceBench
from conrod.models.invariances.results import Invariance, InvarianceOutcome

SOLVERS = {"CG": mujoco.mjtSolver.mjSOL_CG, "PGS": mujoco.mjtSolver.mjSOL_PGS}
MAX_ITERATIONS = 3_000  # with tolerance 0; nearly all shipped models need fewer
# Beyond this share of the largest acceleration a residual says that a solver has not converged, and allows anything.
MAX_RESIDUAL_SHARE = 1e-6


def other_solvers(bench: InvarianceBench) -> Iterator[Invariance]:
    """Check the conjugate gradient method and projected Gauss-Seidel against Newton's method."""
    for name, solver in SOLVERS.items():
        change = f"{name} for Newton's method"
        if bench.model.opt.noslip_iterations:
            reason = "noslip iterations change the forces that a solver has found"
            yield Invariance(change, "residual", InvarianceOutcome.UNSUPPORTED, reason=reason)
            continue
        edited = with_converged_solver(bench.model)
        edited.opt.solver, edited.opt.iterations = solver, MAX_ITERATIONS
        solved = [forward(edited, state) for state in bench.states]
        found = [np.array(data.qacc) for data in solved]
        own = [solver_residual(edited, data) for data in solved]
        if max(own) > MAX_RESIDUAL_SHARE * bench.size:
            reason = f"{name} has not converged in {MAX_ITERATIONS} iterations"
            yield Invariance(change, "residual", InvarianceOutcome.UNSUPPORTED, reason=reason)
            continue
        newton = [
            solver_residual(one.model, forward(one.model, state))
            for one, state in zip(bench.reference, bench.states, strict=True)
        ]
        yield bench.judge_accelerations(change, "residual", found, [a + b for a, b in zip(own, newton, strict=True)])


def solver_residual(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Compute sqrt(g' M^-1 g), with g (nv,) the gradient at the accelerations of data; its forces are made anew."""
    if data.nefc:
        violation = np.empty(data.nefc)
        mujoco.mj_mulJacVec(model, data, violation, data.qacc)
        mujoco.mj_constraintUpdate(model, data, violation - data.efc_aref, None, 0)
    else:
        data.qfrc_constraint[:] = 0.0
    inertial, solved = np.empty(model.nv), np.empty((1, model.nv))
    mujoco.mj_mulM(model, data, inertial, data.qacc)
    gradient = inertial - data.qfrc_smooth - data.qfrc_constraint
    mujoco.mj_solveM(model, data, solved, gradient[None])
    return math.sqrt(max(float(gradient @ solved[0]), 0.0))
