"""Exudyn's implicit solvers, called block by block of steps on a system that is built."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import exudyn

from conrod.engines.exudyn import TRAPEZOIDAL, ExudynSettings

# The solver restarts with a new Jacobian after this number of steps, however a run is cut into pieces. A power of two,
# by which the length of a step is divided without rounding.
BLOCK_STEPS = 1024


@dataclass(frozen=True)
class ExudynSystem:
    """A system that Exudyn steps.

    Attributes:
        container: the system's container, which must outlive it.
        system: the `MainSystem`.
        drive: object number of the constraint on the crank's angle; -1 where laws drive several joints.
    """

    container: Any
    system: Any
    drive: int


@contextmanager
def silence_output() -> Iterator[None]:
    """Keep Exudyn from printing why a solver has failed."""
    printing = exudyn.config.printToConsole
    exudyn.config.printToConsole = False
    try:
        yield
    finally:
        exudyn.config.printToConsole = printing


def simulation_settings(settings: ExudynSettings) -> Any:
    """Exudyn's simulation settings: its defaults with ours, steps of constant length, no files."""
    made = exudyn.SimulationSettings()
    made.solution.file.write = False
    integration = made.timeIntegration
    integration.adaptiveStep = False
    integration.numberOfSteps, integration.endTime = BLOCK_STEPS, BLOCK_STEPS * settings.timestep
    integration.newton.relativeTolerance = settings.relative_tolerance
    integration.newton.absoluteTolerance = settings.absolute_tolerance
    alpha = integration.generalizedAlpha
    alpha.spectralRadius = settings.spectral_radius
    # As Exudyn's SolveDynamic does it for this solver, which is the same one with other settings.
    alpha.useIndex2Constraints = alpha.useNewmark = settings.solver == TRAPEZOIDAL
    return made


class SolverStepper:
    """A system in Exudyn that starts in an exact state; a call advances it by some steps.

    Each call of the solver starts from the state that the last one left, accelerations included. Its time starts at 0
    each time.

    Attributes:
        failure: reason why the solver failed; empty while it works.
    """

    _made: ExudynSystem

    def __init__(self, settings: ExudynSettings) -> None:
        self.failure, self._step = "", settings.timestep
        self._settings = simulation_settings(settings)
        self._solver = exudyn.MainSolverImplicitSecondOrder()

    def __call__(self, steps: int) -> None:
        self._solver.it.endTime = steps * self._step
        if not self.failure:
            with silence_output():
                self._call_solver("a step", self._solver.SolveSteps)

    def _call_solver(self, what: str, call: Callable[[Any, Any], bool]) -> None:
        """Call the solver, and keep the reason if it fails."""
        try:
            done = call(self._made.system, self._settings)
        except (RuntimeError, ValueError):  # a singular Jacobian, and the like
            done = False
        if not done:
            singular = self._solver.conv.linearSolverFailed
            why = "its Jacobian is singular" if singular else "Newton's iteration did not converge"
            self.failure = f"Exudyn could not solve for {what}: {why}"
