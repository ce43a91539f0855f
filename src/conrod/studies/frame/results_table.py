"""The ledger as a tidy table: a row a run (and machine that timed it), chosen by an expression, in three formats."""

from __future__ import annotations

import csv
import io
import json
import re
import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from conrod.errors import InvalidInput, unknown_choice
from conrod.runs.comparison import QUANTITIES as COMPARED
from conrod.studies.frame.measurement import MEASURES, QUANTITIES, Measurement
from conrod.studies.frame.timing import Timing

# Of runs that only one study makes, a part of the identity that only these have.
MARKS = {"limits": {"watched", "repeated", "gap_spans"}, "ablate": {"change", "cost"}, "versions": {"bits"}}
TIMED = ("seconds_per_revolution", "reference_seconds", "ratio", "machine")


def tidy_row(
    key: str, name: str, identity: Mapping[str, Any], measurement: Measurement | None, timing: Timing | None
) -> dict[str, Any]:
    """The row of a run; what it does not have is None.

    Columns, in this order:
        key, scene, kind; study: validate, forces or motion, of a result of `conrod validate`, else limits, ablate,
        versions, or sweep (`study_of`); parameter.NAME [SI], of a machine from a file its mechanism as JSON; engine,
        engine_version; preset that settings are or come from: None of others, and of runs kept before presets were
        noted with them;
        setting.NAME [SI];
        steps_per_revolution, revolutions, start_angle [rad], result_version; outcome, reason;
        passed: the verdict by conrod's own tolerances, of a result of `conrod validate`;
        position, velocity, acceleration, total, each _max, _rms, _final: largest of the observed points, normalised;
        closure_position, _velocity, _acceleration; phase_max, _final [rad]; drive_speed, _acceleration;
        predicted_position, _velocity, _acceleration: predicted from the joints alone, and each with _difference;
        seconds_per_revolution [s], reference_seconds [s], ratio, machine;
        of forces torque, reactions, contact, and of free motion angle, energy: each _max, _rms or _final.
    """
    settings = dict(identity["settings"])
    steps = settings.pop("steps_per_revolution", None)
    return {
        "key": key,
        "scene": name,
        "kind": identity["scene"],
        "study": study_of(identity),
        **{f"parameter.{n}": _plain(value) for n, value in identity["parameters"].items()},
        "engine": identity["engine"],
        "engine_version": identity["engine_version"],
        "preset": identity.get("preset", identity.get("label")),
        **{f"setting.{n}": _plain(value) for n, value in settings.items()},
        "steps_per_revolution": steps,
        "revolutions": identity.get("revolutions"),
        "start_angle": identity.get("start_angle"),
        "result_version": identity["result_version"],
        **_measured(measurement),
        **{name: None if timing is None else getattr(timing, name) for name in TIMED},
    }


def study_of(identity: Mapping[str, Any]) -> str:
    """The study of a run, by what its identity holds; sweep of a plain run, which sweep, recommend and ablate share."""
    for study, marks in MARKS.items():
        if not marks.isdisjoint(identity):
            return study
    return str(identity.get("study", "sweep"))


def _plain(value: Any) -> Any:
    """A value that a cell of a table can hold: what a setting holds several of becomes text."""
    if isinstance(value, Mapping):
        return json.dumps(value, sort_keys=True)
    return " ".join(str(part) for part in value) if isinstance(value, list | tuple) else value


def _measured(measurement: Measurement | None) -> dict[str, Any]:
    m = measurement if measurement is not None else Measurement(outcome="")
    closure, phase, drive, prediction = m.closure or {}, m.phase or {}, m.drive or {}, m.prediction or {}
    predicted = {q: prediction.get(q, {}) for q in QUANTITIES}
    kept = m.beside or {}
    return {
        "outcome": m.outcome or None,
        "reason": m.reason or None,
        "passed": kept.get("passed"),
        **{f"{q}_{measure}": m.largest(q, measure) for q in COMPARED for measure in MEASURES},
        **{f"closure_{q}": closure.get(q) for q in QUANTITIES},
        **{f"phase_{measure}": phase.get(measure) for measure in ("max", "final")},
        **{f"drive_{q}": drive.get(q) for q in ("speed", "acceleration")},
        **{f"predicted_{q}": predicted[q].get("predicted") for q in QUANTITIES},
        **{f"predicted_{q}_difference": predicted[q].get("difference") for q in QUANTITIES},
        **{f"{q}_{measure}": size for q, sizes in kept.get("sizes", {}).items() for measure, size in sizes.items()},
    }


Row = Mapping[str, Any]
# A text, or a name in double quotes, which SQLite would take for a text where there is no such column.
QUOTED = re.compile(r"""('[^']*')|"([^"]*)\"""")
NO_COLUMN = "no such column: "


@dataclass(frozen=True)
class ResultsTable:
    """Columns by name, in order; every row has all of them, None where it has no value."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]

    def written(self, form: str) -> str | bytes:
        """The table as csv (an empty cell where there is no value), json (a list of objects, one a line) or parquet.

        Raises:
            InvalidInput: pyarrow is not installed.
        """
        if form == "parquet":
            return self._parquet()
        if form == "json":
            lines = [json.dumps(dict(zip(self.columns, row, strict=True)), allow_nan=False) for row in self.rows]
            return "[\n" + ",\n".join(lines) + "\n]\n"
        stream = io.StringIO()
        if self.columns:
            csv.writer(stream, lineterminator="\n").writerows([self.columns, *self.rows])
        return stream.getvalue()

    def _parquet(self) -> bytes:
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise InvalidInput("--parquet needs pyarrow: pip install pyarrow") from None
        values = {name: [row[i] for row in self.rows] for i, name in enumerate(self.columns)}
        stream = io.BytesIO()
        pyarrow.parquet.write_table(pyarrow.table(values), stream)
        return stream.getvalue()


def results_table(rows: Iterable[Row], where: Sequence[str] = ()) -> ResultsTable:
    """The rows for which all expressions hold, with the union of their columns.

    Args:
        where: SQL expressions on the columns, such as `engine = 'mujoco' and position_max < 1e-6`; names with a point
            are put in double quotes.

    Raises:
        InvalidInput: an expression that SQLite does not understand; says what it stumbled on.
    """
    kept = list(rows)
    columns = tuple(dict.fromkeys(name for row in kept for name in row))
    if not columns:
        return ResultsTable((), ())
    names = ", ".join(_quoted(name) for name in columns)
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as memory:
        memory.execute(f"CREATE TABLE results ({names})")
        marks = ", ".join("?" * len(columns))
        memory.executemany(f"INSERT INTO results VALUES ({marks})", ([row.get(c) for c in columns] for row in kept))
        # Only what reads is allowed from here on: an expression is a user's, and may come from anywhere.
        memory.set_authorizer(_reading_only)
        asked = [QUOTED.sub(lambda found: found[1] or f"[{found[2]}]", expression) for expression in where]
        for expression in asked:
            # Without parentheses around it: what only they would balance is not an expression.
            _selected(memory, f"{expression}\n", columns, most=0)
        condition = " AND ".join(f"({expression})" for expression in asked) or "1"
        return ResultsTable(columns, tuple(_selected(memory, condition, columns)))


def _selected(memory: sqlite3.Connection, condition: str, columns: Sequence[str], most: int = -1) -> list[Any]:
    try:
        return memory.execute(f"SELECT * FROM results WHERE {condition} ORDER BY rowid LIMIT {most}").fetchall()
    except (sqlite3.Error, sqlite3.Warning) as error:
        text = str(error)
        if text.startswith(NO_COLUMN):
            text = str(unknown_choice("column", text.removeprefix(NO_COLUMN), columns))
        raise InvalidInput(f"--where, SQL on the columns with texts in single quotes: {text}") from None


def _reading_only(action: int, *_: Any) -> int:
    reading = (sqlite3.SQLITE_SELECT, sqlite3.SQLITE_READ, sqlite3.SQLITE_FUNCTION)
    return sqlite3.SQLITE_OK if action in reading else sqlite3.SQLITE_DENY


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'
