"""Exudyn's implicit solvers, taken on by so many steps at a time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import exudyn
import numpy as np

from conrod.engines.engine import Machine, run_of
from conrod.engines.exudyn.model import build, silent
from conrod.engines.exudyn.settings import TRAPEZOIDAL, ExudynSettings
from conrod.engines.reference_loop import REFERENCE
from conrod.exact.motion import Array

# The solver begins again after so many steps, with a new Jacobian: always the same ones, however a run is cut. A power
# of two, by which a step's length is divided without rounding.
BLOCK = 1024


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

    def recorded(self, steps: int) -> Array:
        """Poses, rates and accelerations (steps + 1, 3, 3 n), before so many steps and after each.

        They are not numbers where the solver did not get to.
        """
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


def stepper(machine: Machine, settings: ExudynSettings) -> Stepper:
    """A machine in the exact state of its start, with nothing recorded."""
    return Stepper(machine, settings, run_of(machine, 1, 1.0)[0])


def reference_loop() -> Stepper:
    """The slider-crank at its start, 1000 steps a turn."""
    return Stepper(REFERENCE, ExudynSettings.stock(REFERENCE, 1000), 0.0)


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
