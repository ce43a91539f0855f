"""Exudyn, as one of conrod's engines: its implicit solvers taken on by so many steps, and its static one.

Nothing is written into the engine after the start; a constraint holds the crank's rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from typing import Any

import exudyn
import numpy as np

from conrod.engines.capabilities import KinematicResult
from conrod.engines.engine import PIECE, Engine, Machine, run_of
from conrod.engines.exudyn.model import build, refusal, silent
from conrod.engines.exudyn.settings import PRESETS, TRAPEZOIDAL, ExudynSettings
from conrod.engines.numerics import StraightAhead, approached
from conrod.engines.recording import Recorded, crank_states, pieces, points_of
from conrod.engines.reference_loop import REFERENCE
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.outcome import Verdict
from conrod.runs.trajectory import BodyTracks, Outcome, Piece

# The solver begins again after so many steps, with a new Jacobian: always the same ones, however a run is cut. A power
# of two, by which a step's length is divided without rounding.
BLOCK = 1024
TOLERANCE = 1e-13  # of Newton's iteration; where it stalls on rounding before, the pose is that of its last step


class Stepper:
    """A machine in the exact state of a crank angle [rad]; calling it advances it by so many steps.

    What is left of a call of the solver, accelerations included, begins the next one. Its time begins at 0 each time:
    with the crank's rate held constant, nothing depends on it.

    Attributes:
        failure: why the solver goes no further; empty while it does.
    """

    def __init__(self, machine: Machine, settings: ExudynSettings, angle: float) -> None:
        poses, slopes = machine.kinematics.derivatives(np.array([angle]), 1)
        mechanism, speed = machine.kinematics.mechanism, machine.speed
        self.failure, self._step = "", settings.timestep
        self._settings = _simulation(settings)
        self._solver = exudyn.MainSolverImplicitSecondOrder()
        with silent():
            self._made = build(mechanism, poses[0], slopes[0] * speed, mechanism.driver.sense * speed)
            self._try("the initial accelerations", self._solver.InitializeSolver)

    def __call__(self, steps: int) -> None:
        self._solver.it.endTime = steps * self._step
        if not self.failure:
            with silent():
                self._try("a step", self._solver.SolveSteps)

    def states(self, steps: int) -> Iterator[Array]:
        """Poses, rates and accelerations (3, 3 n) of one instant each, at the start and after each of so many steps.

        Both solvers fulfil constraints and equations of motion at the end of a step, so all that is read there belongs
        to it: the accelerations are not those, at other instants, that generalised alpha carries along beside them.
        """
        steps = max(steps, 1)
        for done in range(0, steps, BLOCK):
            yield from self._recorded(min(BLOCK, steps - done))[1 if done else 0 :]

    def _recorded(self, steps: int) -> Array:
        """States (steps + 1, 3, 3 n) before so many steps and after each; no numbers where it does not get to."""
        data, found = self._made.system.systemData, list[list[Array]]()

        def record(*_: object) -> bool:
            found.append([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])
            return True

        self._made.system.SetPostStepUserFunction(record)
        self(steps)
        states = np.full((steps + 1, 3, data.ODE2Size()), math.nan)
        if found:
            states[: len(found)] = found
        return states

    def _try(self, what: str, call: Callable[[Any, Any], bool]) -> None:
        try:
            done = call(self._made.system, self._settings)
        except (RuntimeError, ValueError):  # a singular Jacobian, and the like
            done = False
        if not done:
            singular = self._solver.conv.linearSolverFailed
            why = "its Jacobian is singular" if singular else "Newton's iteration did not converge"
            self.failure = f"Exudyn could not solve for {what}: {why}"


def _simulation(settings: ExudynSettings) -> Any:
    """Exudyn's settings: its defaults but for ours, in steps of one length, with no files written."""
    made = exudyn.SimulationSettings()
    made.solution.file.write = False
    integration = made.timeIntegration
    integration.adaptiveStep = False
    integration.numberOfSteps, integration.endTime = BLOCK, BLOCK * settings.timestep
    integration.newton.relativeTolerance = settings.relative_tolerance
    integration.newton.absoluteTolerance = settings.absolute_tolerance
    alpha = integration.generalizedAlpha
    alpha.spectralRadius = settings.spectral_radius
    # As Exudyn's SolveDynamic does it for this solver, which is the same one with other settings.
    alpha.useIndex2Constraints = alpha.useNewmark = settings.solver == TRAPEZOIDAL
    return made


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


class Exudyn(Engine[ExudynSettings]):
    """Exudyn by way of its `MainSystem` of planar bodies, with hard constraints and implicit integrators."""

    name = "exudyn"
    version = exudyn.__version__
    presets = PRESETS
    refusal = staticmethod(refusal)
    solve_kinematics = staticmethod(solve_kinematics)

    def run(
        self,
        machine: Machine,
        settings: ExudynSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE,
    ) -> Iterator[Piece]:
        kinematics, stepper = machine.kinematics, Stepper(machine, settings, start_angle)
        states = stepper.states(round(settings.steps_per_revolution * revolutions))

        def ended(judged: Verdict) -> Verdict:
            failed = judged.outcome is Outcome.DIVERGED and stepper.failure
            return replace(judged, reason=f"{stepper.failure}; {judged.reason}") if failed else judged

        def record(first: int, times: Array) -> Recorded:
            read = np.array(list(islice(states, len(times)))).swapaxes(0, 1)
            bodies = crank_states(kinematics.mechanism, times, *read)
            # Exudyn too has it from the step index.
            clock = settings.timestep * np.arange(first, first + len(times), dtype=float)
            tracks = BodyTracks(bodies, bodies, bodies)
            return Recorded(tracks, points_of(kinematics, bodies), clock, ended=ended)

        return pieces(machine, settings, self.version, revolutions, start_angle, steps, record)

    def stepper(self, machine: Machine, settings: ExudynSettings) -> Stepper:
        return Stepper(machine, settings, run_of(machine, 1, 1.0)[0])

    def reference_loop(self) -> Stepper:
        """The slider-crank at its start, 1000 steps a turn."""
        return Stepper(REFERENCE, ExudynSettings.stock(REFERENCE, 1000), 0.0)


ENGINE = Exudyn()
