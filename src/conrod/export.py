"""The model or the exact trajectory of a scene, as a file for others."""

from __future__ import annotations

import csv
import io

import numpy as np

from conrod.motion import Array
from conrod.scenes import Scene

# Column suffix, attribute of the motion, SI unit.
QUANTITIES = (("", "position", "m"), ("v", "velocity", "m/s"), ("a", "acceleration", "m/s^2"), ("j", "jerk", "m/s^3"))


def exact_columns(scene: Scene, samples: int, revolutions: float) -> dict[str, tuple[str, Array]]:
    """Columns of the exact trajectory: name -> (unit, values (T,)).

    Args:
        samples: instants in a revolution, equally spaced; the last instant of the run is included.
        revolutions: turns of the crank from angle 0.
    """
    times = np.asarray(np.arange(round(samples * revolutions) + 1) * (scene.period / samples), dtype=float)
    motion = scene.reference(times)
    columns: dict[str, tuple[str, Array]] = {"time": ("s", times), "crank_angle": ("rad", scene.speed * times)}
    for name, point in motion.points.items():
        for prefix, quantity, unit in QUANTITIES:
            values: Array = getattr(point, quantity)
            for k, axis in enumerate("xy"):
                columns[f"{name}.{prefix}{axis}"] = (unit, values[:, k])
    return columns


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
