"""The exact motion: closed forms and the generic reference, position to jerk of all observed points."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.row import Row
from benchmarks.side_by_side import cpu_seconds, interleaved
from conrod import Saw, ShearPress
from conrod.scenes import catalogue_scene

CLOSED, GENERIC = 1_000_000, 100_000  # samples
TURNS = 20.0
MACHINES = (Saw(speed=52.36), ShearPress())
SIX_BAR_BAR = 40.0  # microseconds


def rows(repeats: int) -> list[Row]:
    """Time a sample, for both slider-cranks; of the generic reference also for a six-bar linkage."""
    return [*_closed_forms(repeats), *_generic_references(repeats)]


def _closed_forms(repeats: int) -> list[Row]:
    angle = np.linspace(0.0, TURNS * 2.0 * np.pi, CLOSED)
    sides = {m.kind: partial(cpu_seconds, partial(m.motion, angle, m.speed)) for m in MACHINES}
    return [
        Row(f"closed form, {kind}", "ns a sample", [1e9 * s / CLOSED for s in seconds], 120.0)
        for kind, seconds in interleaved(sides, repeats).items()
    ]


def _generic_references(repeats: int) -> list[Row]:
    angle = np.linspace(0.0, TURNS * 2.0 * np.pi, GENERIC)
    machines = (*MACHINES, catalogue_scene("six-bar"))
    bars = {m.kind: SIX_BAR_BAR if m.kind == "six-bar" else 8.0 for m in machines}
    sides = {m.kind: partial(cpu_seconds, partial(m.kinematics.motion, angle, m.speed)) for m in machines}
    return [
        Row(f"generic reference, {kind}", "µs a sample", [1e6 * s / GENERIC for s in seconds], bars[kind])
        for kind, seconds in interleaved(sides, repeats).items()
    ]
