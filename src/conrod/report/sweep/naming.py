"""How the report of a sweep names its settings and numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.studies.sweep.results import SweepStudy, SweptPoint

# What errors are divided by, in words that follow a number.
UNITS: Mapping[str, str] = {"position": "L", "velocity": "ω L", "acceleration": "ω² L"}


def with_unit(value: float | None, quantity: str) -> str:
    """A normalised error and what it is a share of: `0.043 L`."""
    return f"{numbers.measured(value)} {UNITS[quantity]}"


def tolerance(value: float) -> str:
    """A given tolerance: `1e-6`."""
    return numbers.quantity(value) if value >= 1.0 else f"{value:.0e}".replace("e-0", "e-")


def setting_of(point: SweptPoint) -> str:
    """The rule, the preset that it is if it is one, and the steps: what identifies a setting."""
    named = f"`{point.preset}`, that is {point.rule}" if point.preset else point.rule
    return f"{named}, at {point.steps_per_revolution} steps per revolution ({point.label})"


def rule_of(point: SweptPoint) -> str:
    """The rule, marked where it is a preset."""
    return f"{point.rule} (`{point.preset}`)" if point.preset else point.rule


def costs_of(point: SweptPoint) -> list[str]:
    """Two cells: CPU time of a revolution, and the same in steps of the engine's reference loop."""
    if point.timing is None:
        return [numbers.MISSING, numbers.MISSING]
    return [numbers.duration(point.timing.seconds_per_revolution), numbers.measured(point.timing.ratio)]


def times(factor: float) -> str:
    """A factor: `23 times`, `0.050 times`."""
    return f"{numbers.measured(factor)} times"


def versions_of(study: SweepStudy) -> str:
    """Engines and their versions."""
    return ", ".join(f"{engine_title(name)} {version}" for name, version in study.engines.items())


def setting_value(value: Any) -> str:
    """A setting's value, short."""
    match value:
        case None:
            return "none"
        case bool():
            return "yes" if value else "no"
        case float():
            return numbers.quantity(value, 3)
        case list() | tuple():
            return "(" + ", ".join(setting_value(part) for part in value) + ")"
        case _:
            return str(value)


def listed(words: list[str]) -> str:
    """Words as a list in a sentence: `a, b and c`."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]
