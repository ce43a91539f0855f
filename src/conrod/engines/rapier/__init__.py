"""Rapier, an optional engine: settings of a run, and the presets. Does not import the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from conrod.engines.engine import DASHED, DOTTED, STOCK, EngineSettings, LineStyle, Machine, Preset, step_length
from conrod.mechanism.units import check_count


@dataclass(frozen=True)
class RapierSettings(EngineSettings):
    """Settings of a Rapier run, named as in its `IntegrationParameters`."""

    engine: ClassVar[str] = "rapier"

    num_solver_iterations: int = 4
    num_internal_pgs_iterations: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        check_count("num_solver_iterations", self.num_solver_iterations, 1, 10_000)
        check_count("num_internal_pgs_iterations", self.num_internal_pgs_iterations, 1, 10_000)

    def time_constant(self, contact: bool) -> float:
        """Time constant [s]: 0, as joints are closed within a step."""
        return 0.0


def _preset(name: str, iterations: tuple[int, int], meaning: str, style: LineStyle) -> Preset[RapierSettings]:
    """A preset that is not judged, as Rapier's documentation states no size of its errors."""

    def rule(machine: Machine, steps_per_revolution: int, /) -> RapierSettings:
        return RapierSettings(name, steps_per_revolution, step_length(machine, steps_per_revolution), *iterations)

    return Preset(rule, meaning, judged=False, style=style)


RAPIER_PRESETS: Mapping[str, Preset[RapierSettings]] = {
    STOCK: _preset(STOCK, (4, 1), "Rapier as it comes", DOTTED),
    "tuned": _preset("tuned", (20, 4), "20 iterations of 4", DASHED),
}
