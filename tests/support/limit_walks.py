"""Walks made by hand, with known ends, among those of the committed report, to see what is told and drawn of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

from conrod.report.saved import restored
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Scale, spaced
from conrod.studies.limits.plan import CRITERIA, boundary_of
from conrod.studies.limits.results import LimitStudy, Probe, Walk

SCENE = "saw-500rpm"
REPORT = Path(__file__).parents[2] / "reports" / "limits"
# Up to which value, what a run shows there: (value, level, outcome, undetected, largest position error).
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


def probe(value: float, level: str, outcome: str, undetected: bool, error: float | None, **others: object) -> Probe:
    """A run on an axis."""
    made = Probe(
        value=value,
        text=f"{value:.4g}",
        level=level,
        outcome=outcome,
        undetected=undetected,
        reason="" if outcome == "completed" else f"made to be {outcome}",
        errors=None if error is None else {"position": error, "velocity": 3.0 * error, "acceleration": 9.0 * error},
        torque=None,
    )
    return replace(made, **others)  # type: ignore[arg-type]  # names of fields are a test's own


def walked(
    axis: str,
    engine: str,
    preset: str,
    first: float,
    parts: Sequence[Part],
    scale: Scale = Scale.LOG,
    text: str = "{:.4g}",
) -> Walk:
    """A walk from a first value, whose runs are what the parts say; both sides of each change are run."""
    last = parts[-1][0]
    values = set(spaced(scale, first, last, 13))
    for end, *_ in parts[:-1]:
        values |= {end, _a_little_further(scale, end, first, last)}
    ordered = sorted(values, reverse=last < first)
    probes = tuple(replace(_of_part(v, first, parts), text=text.format(v)) for v in ordered)
    boundaries = tuple(boundary_of(probes, criterion) for criterion in CRITERIA)
    return Walk(axis, SCENE, engine, preset, "", probes, boundaries)


def listed(axis: str, engine: str, preset: str, probes: Sequence[Probe]) -> Walk:
    """A walk over a list of values."""
    return Walk(axis, SCENE, engine, preset, "", tuple(probes), ())


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


def steps_walks() -> tuple[Walk, ...]:
    """Steps per revolution of all presets; two of them pass through undetected runs."""
    ends = (
        ("mujoco", "stock", STOCK),
        ("mujoco", "tuned", TUNED),
        ("mujoco", "hardened", HARDENED),
        ("pymunk", "stock", PYMUNK),
        ("pymunk", "tuned", TUNED),
    )
    return tuple(
        walked("steps", engine, preset, 20000.0, parts, Scale.COUNT, "{:.0f} steps") for engine, preset, parts in ends
    )


def mass_walks() -> tuple[Walk, ...]:
    """The mass ratio, which is walked both ways from one."""
    walks = []
    for engine, preset, up, down in (("mujoco", "stock", 30.0, 1e-2), ("pymunk", "stock", 8.0, 1e-5)):
        heavy: tuple[Part, ...] = (
            (up, "safe", "completed", False, 1e-4),
            (50.0 * up, "rough", "completed", False, 0.05),
            (1e6, "unbounded", "exploded", False, None),
        )
        light: tuple[Part, ...] = ((down, "safe", "completed", False, 1e-4), (1e-6, "wrong", "completed", True, 0.5))
        walks += [walked("mass-ratio", engine, preset, 1.0, parts) for parts in (heavy, light)]
    return tuple(walks)


def pose_walks() -> tuple[Walk, ...]:
    """Start poses, some of which are wrong and undetected with one preset."""

    def shown(k: int, error: float) -> Probe:
        if k % 25 == 0 and error > 1e-3:
            return probe(5.0 * k, "broken", "flipped", True, None)
        return probe(5.0 * k, "safe", "completed", False, error * (1 + k % 7))

    ends = (("mujoco", "stock", 1.4e-3), ("mujoco", "tuned", 1e-5), ("pymunk", "stock", 1e-4))
    return tuple(listed("start-pose", e, preset, [shown(k, error) for k in range(72)]) for e, preset, error in ends)


def detected(walks: Sequence[Walk]) -> list[Walk]:
    """The same walks, had every engine warned."""
    return [
        replace(
            walk,
            probes=tuple(replace(p, undetected=False) for p in walk.probes),
            boundaries=tuple(replace(b, undetected=False) for b in walk.boundaries),
        )
        for walk in walks
    ]


@cache
def saved(scene: str = SCENE) -> LimitStudy:
    """The study in the committed report."""
    return restored(LimitStudy, json.loads((REPORT / "data" / f"{scene}.json").read_text()))


@cache
def limit_study() -> LimitStudy:
    """A study with known walks, few of others, and two of every other part."""
    study = saved()
    kept = [walk for walk in study.walks if walk.axis in ("nearness", "regularisation", "float")]
    walks = sorted((*steps_walks(), *mass_walks(), *kept, *pose_walks()), key=lambda walk: list(AXES).index(walk.axis))
    return replace(
        study,
        walks=tuple(walks),
        maps=study.maps[:1],
        determinism=study.determinism[:2],
    )


def of_axis(study: LimitStudy, axis: str) -> LimitStudy:
    """What asking for one axis alone would have given."""
    walks = tuple(walk for walk in study.walks if walk.axis == axis)
    return replace(study, walks=walks, maps=(), determinism=(), floats=())
