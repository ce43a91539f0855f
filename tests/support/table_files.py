"""Tables as other tools write them, made from the exact motion, to plant slips in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from conrod.cli.options import columns_in
from conrod.exact.motion import Array
from conrod.models.tables.columns import column_request
from conrod.models.tables.reading import Reading, read_table
from conrod.models.tables.study import TableStudy, study_table
from conrod.scenes import Scene

ROWS = 120  # a revolution
LETTERS = {"position": "", "velocity": "v", "acceleration": "a"}
Columns = dict[str, Array]


def exact_table(
    scene: Scene,
    quantities: Sequence[str] = ("position",),
    *,
    crank: bool = False,
    times: Array | None = None,
    phase: float = 0.0,
    rows: int = ROWS,
) -> Columns:
    """Columns of two exact revolutions, SI, named as conrod names them.

    Args:
        crank: whether the crank angle is among them.
        times: at other instants.
        phase: crank angle at time 0 [rad].
    """
    at = np.arange(2 * rows + 1) * (scene.period / rows) if times is None else times
    columns = {"time": at}
    if crank:
        columns["crank_angle"] = scene.speed * at
    for point, motion in scene.reference(at + phase / scene.speed).points.items():
        for quantity in quantities:
            values = getattr(motion, quantity)
            columns |= {f"{point}.{LETTERS[quantity]}{axis}": values[:, k].copy() for k, axis in enumerate("xy")}
    return columns


def csv_text(columns: Mapping[str, Array], separator: str = ",", decimal: str = ".") -> str:
    """The columns as text, numbers in full precision."""
    rows = zip(*(map(repr, values.tolist()) for values in columns.values()), strict=True)
    lines = [separator.join(columns), *(separator.join(row).replace(".", decimal) for row in rows)]
    return "\n".join(lines) + "\n"


def read_file(
    path: Path, scene: Scene, columns: Sequence[str] = (), units: Sequence[str] = (), links: Sequence[str] = ()
) -> Reading:
    """Read a table as the command line does, in this process."""
    points = tuple(scene.lengths)
    return read_table(path, points, column_request(columns_in(columns, points, links), units, points, links))


def judge_columns(
    columns: Mapping[str, Array],
    scene: Scene,
    folder: Path,
    estimate: Sequence[str] = (),
    tolerance: Mapping[str, float] | None = None,
) -> TableStudy:
    """Write columns to a CSV file, and judge it."""
    reading = read_file(write_file(folder, csv_text(columns), "table.csv"), scene)
    return study_table("table.csv", scene.kind, scene, reading, estimate, tolerance)


def write_file(folder: Path, text: str, name: str = "t.csv", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_text(text, encoding=encoding)
    return path
