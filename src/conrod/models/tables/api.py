"""A table of a trajectory, judged by the exact motion of the scene that it is to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from conrod.errors import as_names
from conrod.exact.link_rotations import rotating_links
from conrod.execution.baseline_check import BaselineCheck
from conrod.execution.local import call_on_file
from conrod.execution.resolve_arguments import OneScene, scene_by_name
from conrod.execution.tolerances import ALL_TOLERANCE_NAMES, check_tolerance
from conrod.models.tables import report as trajectory
from conrod.models.tables.baseline_lines import table_lines
from conrod.models.tables.columns import column_request
from conrod.models.tables.estimation import check_estimated
from conrod.models.tables.study import TableStudy, study_table
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.user_files.files import check_readable, name_file_in_errors
from conrod.user_files.in_memory import file_of_table

READING_TIMEOUT = 300.0  # [s]; a table of the most rows that are kept is read in a tenth of it


def check_table(
    table: str | Path | Mapping[str, Any] | Any,
    scene: OneScene,
    *,
    columns: Mapping[str, str] | None = None,
    units: str | Sequence[str] = (),
    estimate: str | Sequence[str] = (),
    tolerance: Mapping[str, float | str] | None = None,
    baseline: str | Path | None = None,
    accept: bool = False,
) -> Findings[TableStudy]:
    """Judge a trajectory, measured or simulated by any tool, by the exact motion of a scene.

    Args:
        table: path of a file, a data frame (pandas, polars, pyarrow), or a mapping of numpy arrays (T,).
        columns: heading of each quantity's column, such as {"C.x": "px"}, where it is not found by its heading.
        units: of columns whose heading has none, such as ("mm", "deg").
        estimate: unknowns to estimate first, of "time" and "phase".
        tolerance: largest error by quantity, normalised; None judges nothing.
        scene, baseline, accept: as in `check_model`.

    Raises:
        InvalidInput: the table or an argument cannot be used; says what can.
    """
    with file_of_table(table) as (path, shown):
        check_readable(path)
        name, machine = scene_by_name(scene)
        points, units, estimate = tuple(machine.lengths), as_names(units), as_names(estimate)
        wanted = column_request(columns or {}, units, points, rotating_links(machine.kinematics))

        def judge(one: Scene) -> TableStudy:
            from conrod.models.tables.reading import read_table

            reading = call_on_file(read_table, path, points, wanted, timeout=READING_TIMEOUT)
            return study_table(str(path), name, one, reading, check_estimated(estimate), allowed)

        allowed = None if tolerance is None else check_tolerance(tolerance, ALL_TOLERANCE_NAMES)
        check_estimated(estimate)
        options: dict[str, Any] = {"column": column_texts(columns), "unit": units, "estimate": ",".join(estimate)}
        given = {"columns": columns, "units": units, "estimate": estimate, "tolerance": tolerance}
        call = text_of_call("check_table", shown or str(path), name, **given)
        return table_findings(judge, path, shown, (name, machine), options, (baseline, accept), call)


def table_findings(
    judge: Any,
    path: Path,
    shown: str | None,
    scene: tuple[str, Scene],
    options: Mapping[str, Any],
    baseline: tuple[str | Path | None, bool],
    call: str,
) -> Findings[TableStudy]:
    """Judge a table, or an FMU by the table of its run, and compare the result with a baseline.

    Args:
        judge: judges the table against a scene, and returns its `TableStudy`.
        path: the table or FMU.
        shown: name that the report states; None for the file's.
        scene: name and scene.
        options: arguments that the result depends on, see `BaselineCheck.prepare`.
        baseline: file of the baseline, None for none, and whether to accept the result.
        call: the Python call that finds the same.
    """
    baseline_check = BaselineCheck.prepare(baseline[0], dict([scene]), options, accept=baseline[1])

    def find(several: Sequence[Mapping[str, Scene]]) -> list[list[TableStudy]]:
        with name_file_in_errors(path):
            return [[judge(one) for one in scenes.values()] for scenes in several]

    ((found,),) = find([dict([scene])])
    compared = baseline_check.compare([found], find, table_lines) if baseline_check else None
    return Findings(
        trajectory.TABLE_REPORT, {trajectory.PART: replace(found, file=shown or found.file)}, call,
        typed={trajectory.PART: str(path)}, baseline=compared,
    )  # fmt: skip


def column_texts(columns: Mapping[str, str] | None) -> tuple[str, ...]:
    """Return the columns as they are typed on a command line, such as `C.x=px`."""
    return tuple(f"{name}={heading}" for name, heading in (columns or {}).items())
