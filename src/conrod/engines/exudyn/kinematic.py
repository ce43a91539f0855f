"""Kinematic mode: Exudyn's static solver, which closes the joints at prescribed crank angles."""

from __future__ import annotations

import exudyn
import numpy as np

from conrod.engines.capabilities import KinematicResult
from conrod.engines.engine import Machine
from conrod.engines.exudyn.model import build, silent
from conrod.engines.numerics import StraightAhead, approached
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

TOLERANCE = 1e-13  # of Newton's iteration; where it stalls on rounding before, the pose is that of its last step


def solve_kinematics(machine: Machine, angle: Array) -> KinematicResult:
    """The crank held at each angle, the rest placed by the joints."""
    mechanism = machine.kinematics.mechanism
    start = machine.kinematics.start[0]
    made = build(mechanism, start, np.zeros_like(start), rate=None)
    data, solver, settings = made.system.systemData, exudyn.MainSolverStatic(), exudyn.SimulationSettings()
    settings.solution.file.write, settings.staticSolver.verboseMode = False, 0
    newton = settings.staticSolver.newton
    newton.relativeTolerance = newton.absoluteTolerance = TOLERANCE
    poses, rates, course = list[Array](), list[Array](), StraightAhead()
    for theta, asked in approached(machine.kinematics, angle):
        ahead = course.at(theta)
        if ahead is not None:
            data.SetODE2Coordinates(ahead, exudyn.ConfigurationType.Initial)
        made.system.SetObjectParameter(made.drive, "offset", mechanism.crank_turn(theta))
        with silent():
            solver.SolveSystem(made.system, settings)
        course.found(theta, data.GetODE2Coordinates())
        if asked:
            solver.ComputeNewtonJacobian(made.system, settings)
            poses.append(data.GetODE2Coordinates())
            rates.append(closing_rates(solver.GetSystemJacobian(), mechanism, machine.speed))
    observed = machine.kinematics.point_derivatives([np.array(poses), np.array(rates)])
    return KinematicResult(angle, np.array(poses), {name: (place, rate) for name, (place, rate) in observed.items()})


def closing_rates(jacobian: Array, mechanism: Mechanism, speed: float) -> Array:
    """Rates (3 n,) that fit the engine's own constraints at the crank's speed [rad/s]: the static solver has none.

    Args:
        jacobian: [[K, C'], [C, 0]] of the static equations (6 n, 6 n), with the constraint on the crank's turn last.
    """
    count = 3 * len(mechanism.bodies)
    constraints, asked = jacobian[count:, :count], np.zeros(count)
    asked[-1] = constraints[-1, 3 * mechanism.body_index[mechanism.crank] + 2] * mechanism.driver.sense * speed
    # At a pose where the constraints depend on each other there are many, of which this takes the least.
    return np.asarray(np.linalg.lstsq(constraints, asked)[0])
