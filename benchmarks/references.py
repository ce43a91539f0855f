"""The exact motion: closed forms and the generic reference to jerk, poses alone, and the free motion of a chain."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.row import Row
from benchmarks.side_by_side import cpu_seconds, interleaved
from conrod import Saw, ShearPress
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.scenes import catalogue_scene, scene_named

CLOSED, GENERIC = 1_000_000, 100_000  # samples
TURNS = 20.0
MACHINES = (Saw(speed=52.36), ShearPress())
SIX_BAR_BAR = 40.0  # microseconds
FOUR_BAR = catalogue_scene("web-cutter")
CHAIN, CHAIN_SECONDS, CHAIN_SAMPLES = "four-bar-chain-40", 2.0, 401


def rows(repeats: int) -> list[Row]:
    """Time a sample, for both slider-cranks; of the generic reference also for a six-bar linkage."""
    return [
        *_closed_forms(repeats),
        *_generic_references(repeats),
        *_poses_alone(repeats),
        _long_chain(min(repeats, 3)),
    ]


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


def _poses_alone(repeats: int) -> list[Row]:
    """Poses of all bodies of a four-bar linkage."""
    angle = np.linspace(0.0, TURNS * 2.0 * np.pi, GENERIC)
    sides = {FOUR_BAR.kind: partial(cpu_seconds, partial(FOUR_BAR.kinematics.poses, angle))}
    return [
        Row(f"generic reference, {kind}, poses alone", "µs a sample", [1e6 * s / GENERIC for s in seconds], 0.7)
        for kind, seconds in interleaved(sides, repeats).items()
    ]


def _long_chain(repeats: int) -> Row:
    """A chain of 40 four-bars that is let go, its configurations found anew each time."""
    scene = scene_named(CHAIN)
    times = np.linspace(0.0, CHAIN_SECONDS, CHAIN_SAMPLES)

    def move() -> None:
        ForwardDynamics(scene.kinematics.mechanism).motion(times, rates=scene.start_rates)

    move()
    return Row(f"exact motion of {CHAIN}, let go, first 2 s", "s", [cpu_seconds(move) for _ in range(repeats)], 2.0)
