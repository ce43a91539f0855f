"""A result with what every one has; the rest is filled in by whoever measured it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from conrod.comparison import size_of
from conrod.engines import Engine
from conrod.motion import Array
from conrod.scenes import Scene
from conrod.studies.results import Mode, Result, Tolerance
from conrod.trajectory import Outcome


def sizes_of(errors: Array) -> dict[str, float]:
    """Max, rms and final value of a non-negative series, by name."""
    return vars(size_of(errors))


def result_of(
    name: str,
    scene: Scene,
    engine: Engine[Any],
    mode: Mode,
    *,
    preset: str | None = None,
    settings: Mapping[str, Any] | None = None,
    steps: int | None = None,
    revolutions: float,
    outcome: Outcome = Outcome.COMPLETED,
    reason: str = "",
    errors: Mapping[str, Mapping[str, Mapping[str, float] | None]] | None = None,
    tolerance: Tolerance | None = None,
) -> Result:
    """A result of one scene, engine and mode; no figures but those given."""
    return Result(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        settings=settings, mode=mode, steps_per_revolution=steps, revolutions=revolutions, outcome=outcome.slug,
        reason=reason, errors=errors, peak=None, closure=None, phase=None, drive=None, order=None,
        tolerance=tolerance or Tolerance(), passed=None,
    )  # fmt: skip
