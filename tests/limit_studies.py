"""Studies of limits made by hand: walks with known ends, to see what is told and drawn of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from conrod.studies.limits.axis import Scale
from conrod.studies.limits.extremes import Mark
from conrod.studies.limits.grade import Level
from conrod.studies.limits.results import LongRun, Probe, Walk
from conrod.studies.limits.spacing import measure_of, spaced
from conrod.studies.limits.walk import CRITERIA, boundary_of

SCENE = "saw-500rpm"
# Up to which value, what a run shows there: (value, level, outcome, quiet, largest position error).
Part = tuple[float, str, str, bool, float | None]

STOCK: tuple[Part, ...] = (
    (200.0, "rough", "completed", False, 0.05),
    (31.0, "wrong", "completed", True, 0.4),
    (12.0, "broken", "opened", True, None),
    (2.0, "unbounded", "diverged", False, None),
)
TUNED: tuple[Part, ...] = (
    (60.0, "safe", "completed", False, 1e-4),
    (25.0, "rough", "completed", False, 0.03),
    (2.0, "unbounded", "exploded", False, None),
)
HARDENED: tuple[Part, ...] = (
    (9.0, "safe", "completed", False, 1e-8),
    (5.0, "rough", "completed", False, 0.03),
    (2.0, "unbounded", "exploded", False, None),
)
PYMUNK: tuple[Part, ...] = (
    (400.0, "safe", "completed", False, 1e-4),
    (80.0, "rough", "completed", False, 0.03),
    (20.0, "wrong", "completed", True, 0.7),
    (10.0, "broken", "flipped", True, None),
    (2.0, "broken", "opened", True, None),
)


def probe(value: float, level: str, outcome: str, quiet: bool, error: float | None, **others: object) -> Probe:
    """A run on an axis."""
    made = Probe(
        value=value,
        text=f"{value:.4g}",
        level=level,
        outcome=outcome,
        quiet=quiet,
        reason="" if outcome == "completed" else f"made to be {outcome}",
        errors=None if error is None else {"position": error, "velocity": 3.0 * error, "acceleration": 9.0 * error},
        torque=None,
        solver="",
        ruler=None,
        key=f"{outcome}-{value:g}",
    )
    return replace(made, **others)  # type: ignore[arg-type]  # names of fields are a test's own


def walked(axis: str, engine: str, preset: str, first: float, parts: Sequence[Part], scale: Scale = Scale.LOG) -> Walk:
    """A walk from a first value, whose runs are what the parts say; both sides of each change are run."""
    last = parts[-1][0]
    values = set(spaced(scale, first, last, 13))
    for end, *_ in parts[:-1]:
        values |= {end, _a_little_further(scale, end, first, last)}
    ordered = sorted(values, reverse=last < first)
    probes = tuple(_of_part(value, first, parts) for value in ordered)
    boundaries = tuple(boundary_of(probes, criterion) for criterion in CRITERIA)
    return Walk(axis, SCENE, engine, preset, "", probes, boundaries)


def listed(axis: str, engine: str, preset: str, probes: Sequence[Probe]) -> Walk:
    """A walk over a list of values."""
    return Walk(axis, SCENE, engine, preset, "", tuple(probes), ())


def refused(axis: str, engine: str, preset: str, why: str) -> Walk:
    """An axis that was not walked."""
    return Walk(axis, SCENE, engine, preset, why, (), ())


def long_run(engine: str, preset: str, growth: float = 0.0, revolutions: float = 1000.0) -> LongRun:
    """A long run whose phase drifts in proportion to its length, and whose loop error grows by a power of it."""
    counts = [m * 10**k for k in range(7) for m in (1, 2, 5) if m * 10**k <= revolutions]
    marks = tuple(Mark(n, 1e-6 * n**growth, 2e-6 * n**growth, 1e-12 * n, 3e-14 * n**1.5) for n in counts)
    return LongRun(SCENE, engine, preset, 1000, revolutions, "completed", "", marks)


def _a_little_further(scale: Scale, value: float, first: float, last: float) -> float:
    if scale is Scale.COUNT:
        return value + (1.0 if last > first else -1.0)
    if scale is Scale.NEARNESS:
        return 1.0 - (1.0 - value) * (0.985 if last > first else 1.015)
    return value * (1.015 if last > first else 0.985)


def _of_part(value: float, first: float, parts: Sequence[Part]) -> Probe:
    rising = parts[-1][0] > first
    for end, *shown in parts:
        if (value <= end) if rising else (value >= end):
            return probe(value, *shown)  # type: ignore[arg-type]  # the rest of a part
    raise ValueError(f"{value} is beyond the last part")


LEVELS = tuple(level.slug for level in Level)
__all__ = ["LEVELS", "listed", "long_run", "measure_of", "probe", "refused", "walked"]
