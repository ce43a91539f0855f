"""Measurements made up for tests: signed errors by a formula, in the shape that a run delivers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from conrod.exact.motion import Array
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES, Measurement

FAILED = Measurement("exploded", "made up")


def shape_of(scene: Scene, angles: int = 20, seed: int = 0) -> dict[str, Array]:
    """A vector (K, 2) for each observed point, with components of either sign and none near zero."""
    generator = np.random.default_rng(seed)
    sign = generator.choice([-1.0, 1.0], (len(scene.lengths), angles, 2))
    size = generator.uniform(0.2, 1.0, (len(scene.lengths), angles, 2))
    return dict(zip(scene.lengths, sign * size, strict=True))


def measured(signed: Mapping[str, Array]) -> Measurement:
    """A completed run with these signed errors in all three quantities; whole-run errors are their lengths."""
    lengths = {name: np.linalg.norm(values, axis=1) for name, values in signed.items()}
    sizes = {
        name: {"max": float(x.max()), "rms": float(np.sqrt(np.mean(x**2))), "final": float(x[-1])}
        for name, x in lengths.items()
    }
    return Measurement(
        "completed",
        errors={name: dict.fromkeys((*QUANTITIES, "total"), size) for name, size in sizes.items()},
        drive={"speed": 0.0, "acceleration": 0.0},
        signed={name: dict.fromkeys(QUANTITIES, values.tolist()) for name, values in signed.items()},
    )


def errors_by_step(scene: Scene, size: Callable[[float], float], steps: int) -> Measurement:
    """A run whose error at every angle is a fixed vector times a function of the step h = 20 / steps."""
    factor = size(20.0 / steps)
    return measured({name: factor * values for name, values in shape_of(scene).items()})
