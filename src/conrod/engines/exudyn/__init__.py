"""Exudyn, an optional engine: settings of a run, and the presets. Does not import the engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from conrod.engines.engine import DASHED, DOTTED, STOCK, EngineSettings, Machine, Preset, step_length
from conrod.errors import unknown_choice
from conrod.mechanism.units import check_number

# Exudyn's own names: constraints on positions (index 3), or on velocities (index 2).
GENERALIZED_ALPHA, TRAPEZOIDAL = "GeneralizedAlpha", "TrapezoidalIndex2"
SOLVERS = (GENERALIZED_ALPHA, TRAPEZOIDAL)
# Exudyn ends a run within 1e-10 s of its end (CSolverBase::SolveSteps): shorter steps would be left out.
MIN_STEP = 1e-9  # [s]


@dataclass(frozen=True)
class ExudynSettings(EngineSettings):
    """Settings of an Exudyn run, in SI, named as in Exudyn."""

    engine: ClassVar[str] = "exudyn"

    solver: str = GENERALIZED_ALPHA
    spectral_radius: float = 0.9  # at infinite frequency; unused by the trapezoidal rule
    relative_tolerance: float = 1e-8  # of Newton's iteration, on the residual
    absolute_tolerance: float = 1e-10

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.solver not in SOLVERS:
            raise unknown_choice("solver", self.solver, SOLVERS)
        check_number("timestep", self.timestep, MIN_STEP, 1e8, "s")
        check_number("spectral_radius", self.spectral_radius, 0.0, 1.0)
        check_number("relative_tolerance", self.relative_tolerance, 1e-15, 1.0)
        check_number("absolute_tolerance", self.absolute_tolerance, 1e-15, 1.0)

    def time_constant(self, contact: bool) -> float:
        """Time constant [s]: infinite with constraints on velocities, which correct no gap; else 0, within a step."""
        return math.inf if self.solver == TRAPEZOIDAL else 0.0

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> ExudynSettings:
        """The trapezoidal rule with velocity constraints (index 2), without numerical damping."""
        return cls("tuned", steps_per_revolution, step_length(machine, steps_per_revolution), TRAPEZOIDAL)


# Exudyn's documentation states no size of their errors: they are measured, and not judged.
EXUDYN_PRESETS: Mapping[str, Preset[ExudynSettings]] = {
    STOCK: Preset(ExudynSettings.stock, "Exudyn's defaults: generalised alpha, index 3", judged=False, style=DOTTED),
    "tuned": Preset(ExudynSettings.tuned, "trapezoidal rule, index 2", judged=False, style=DASHED),
}
