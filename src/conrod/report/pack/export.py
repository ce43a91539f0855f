"""The model or the exact trajectory of a scene, as a file for others."""

from __future__ import annotations

import csv
import io

import numpy as np

from conrod.exact.motion import Array
from conrod.scenes import Scene

# Column suffix, attribute of the motion, SI unit.
QUANTITIES = (("", "position", "m"), ("v", "velocity", "m/s"), ("a", "acceleration", "m/s^2"), ("j", "jerk", "m/s^3"))

ROUNDING = 1e-12  # of a pass, by which its last sample may seem to lie beyond its end


def exact_columns(scene: Scene, samples: int, revolutions: float) -> dict[str, tuple[str, Array]]:
    """Columns of the exact trajectory: name -> (unit, values (T,)).

    Args:
        samples: instants in a revolution, equally spaced; the last instant of the run is included.
        revolutions: turns of the crank from angle 0; an input that makes one pass makes that, from its start, whose
            time is before that of crank angle 0, which is 0 everywhere.
    """
    times, angle = _instants(scene, samples, revolutions)
    makes_a_pass = scene.mechanism().driver.span is not None
    motion = scene.motion(angle, scene.speed) if makes_a_pass else scene.reference(times)
    columns: dict[str, tuple[str, Array]] = {"time": ("s", times), "crank_angle": ("rad", angle)}
    for name, point in motion.points.items():
        for prefix, quantity, unit in QUANTITIES:
            values: Array = getattr(point, quantity)
            for k, axis in enumerate("xy"):
                columns[f"{name}.{prefix}{axis}"] = (unit, values[:, k])
    return columns


def _instants(scene: Scene, samples: int, revolutions: float) -> tuple[Array, Array]:
    """Times [s] and crank angles [rad], each (T,)."""
    step, span = scene.period / samples, scene.mechanism().driver.span
    if span is None:
        times = np.asarray(np.arange(round(samples * revolutions) + 1) * step, dtype=float)
        return times, scene.speed * times
    duration = (span[1] - span[0]) / abs(scene.speed)
    begin = (span[0] if scene.speed > 0.0 else span[1]) / scene.speed
    times = begin + np.asarray(np.arange(int(duration / step * (1.0 + ROUNDING)) + 1) * step, dtype=float)
    return times, np.clip(scene.speed * times, *span)


def as_csv(columns: dict[str, tuple[str, Array]]) -> str:
    """Columns as CSV with the unit in each heading; numbers in full precision."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(f"{name} [{unit}]" for name, (unit, _) in columns.items())
    writer.writerows(zip(*(map(repr, values.tolist()) for _, values in columns.values()), strict=True))
    return stream.getvalue()


def as_npz(columns: dict[str, tuple[str, Array]]) -> bytes:
    """Columns as a compressed numpy archive; entry `units` holds name and unit of each column."""
    stream = io.BytesIO()
    arrays: dict[str, Array] = {name: values for name, (_, values) in columns.items()}
    units = np.array([[name, unit] for name, (unit, _) in columns.items()])
    np.savez_compressed(stream, units=units, **arrays)  # type: ignore[arg-type]  # numpy's stub takes **bool last
    return stream.getvalue()
