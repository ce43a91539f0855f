"""A table of a user's run, driven by a torque on the crank, judged by the exact motion under that torque."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput, as_names
from conrod.execution.local import call_on_file
from conrod.execution.resolve_arguments import OneScene, scene_by_name
from conrod.execution.tolerances import check_tolerance
from conrod.mechanism.units import check_number
from conrod.models.tables.api import READING_TIMEOUT
from conrod.models.tables.columns import column_request
from conrod.models.torque_runs.comparison import JUDGED_QUANTITIES
from conrod.models.torque_runs.exact import CrankStart
from conrod.models.torque_runs.report import PART, TORQUE_RUN_REPORT
from conrod.models.torque_runs.study import TorqueRunStudy, study_torque_run
from conrod.models.torque_runs.torque import Torque, constant_torque, read_torque, split_way
from conrod.report.findings import Findings, text_of_call
from conrod.user_files import TABLES
from conrod.user_files.files import check_readable, name_file_in_errors
from conrod.user_files.in_memory import file_of_table

MAX_SPEED = 1e6  # [rad/s]


def check_torque_run(
    table: str | Path | Mapping[str, Any] | Any,
    scene: OneScene,
    torque: float | str | Path,
    *,
    start: tuple[float, float] | float | None = None,
    columns: Mapping[str, str] | None = None,
    units: str | Sequence[str] = (),
    tolerance: Mapping[str, float | str] | None = None,
) -> Findings[TorqueRunStudy]:
    """Judge a run under a torque on the crank, made by any tool, by the exact motion of the scene under it.

    Args:
        torque: on the crank, in the sense of the crank angle: a number [N m], or text with a unit; the name of a column
            of the table; or a file with a time and a torque. A column is held from its row to the next, a file linear
            between its rows; `NAME:linear`, `NAME:previous` and `NAME:next` say which.
        start: speed [rad/s] of the crank at time 0, or that and its angle [rad]; None for the scene's own start.
        tolerance: largest error by quantity, of position, velocity, acceleration, phase and speed; None for 1e-3 of
            position and phase.
        table, scene, columns, units: as in `check_table`.

    Raises:
        InvalidInput: the table or an argument cannot be used, or the machine cannot move so; says what can.
    """
    with file_of_table(table) as (path, shown):
        check_readable(path)
        name, machine = scene_by_name(scene)
        points, units = tuple(machine.lengths), as_names(units)
        wanted = column_request(columns or {}, units, points)
        allowed = None if tolerance is None else check_tolerance(tolerance, JUDGED_QUANTITIES)
        begun = _initial_crank(start)
        from conrod.models.tables.reading import read_table

        acting = _torque_of(torque, path)
        reading = call_on_file(read_table, path, points, wanted, timeout=READING_TIMEOUT)
        with name_file_in_errors(path):
            found = study_torque_run(shown or str(path), name, machine, reading, acting, begun, allowed)
        given = {"start": start, "columns": columns, "units": units, "tolerance": tolerance}
        call = text_of_call("check_torque_run", shown or str(path), name, torque, **given)
        return Findings(TORQUE_RUN_REPORT, {PART: found}, call, typed={PART: str(path)})


def _initial_crank(start: tuple[float, float] | float | None) -> CrankStart:
    """Initial crank speed and angle of a user; raises InvalidInput if they are outside their bounds."""
    if start is None:
        return CrankStart()
    speed, angle = (*start, 0.0)[:2] if isinstance(start, tuple) else (start, 0.0)
    check_number("--start", speed, -MAX_SPEED, MAX_SPEED, "rad/s")
    check_number("--start", angle, -2.0 * math.pi, 2.0 * math.pi, "rad")
    return CrankStart(float(angle), float(speed))


def _torque_of(given: float | str | Path, path: Path) -> Torque:
    """The torque that a user gives: constant, of a file, or of a column of the run's own table."""
    if isinstance(given, Path) or not isinstance(given, str):
        constant = None if isinstance(given, Path) else constant_torque(given)
    else:
        constant = constant_torque(given)
    if constant is not None:
        return constant
    text = str(given)
    which, _ = split_way(text)
    if which.lower().endswith(TABLES):
        return call_on_file(read_torque, Path(which), text, timeout=READING_TIMEOUT)
    if not which:
        raise InvalidInput("--torque is empty: give a number [N m], a column of the table, or a file")
    return call_on_file(read_torque, path, text, which, timeout=READING_TIMEOUT)
