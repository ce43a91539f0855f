"""The ledger as a tidy table: one row for each run and each machine that timed it."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from conrod.comparison.trajectory import COMPARED_QUANTITIES as COMPARED
from conrod.errors import unknown_choice
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import MEASURES, SIZES

if TYPE_CHECKING:
    from conrod.execution.timing import Timing

TIMING_FIELDS = ("seconds_per_revolution", "reference_seconds", "ratio", "machine")


def tidy_row(
    key: str, name: str, identity: Mapping[str, Any], result: Mapping[str, Any] | None, timing: Timing | None
) -> dict[str, Any]:
    """Make the row of a run from the plain values of its result; a column without a value is None.

    Columns, in this order:
        key, scene, kind; study: validate, qualification (of --qualify), forces, motion (of `conrod free`), limits,
        ablate, versions, or sweep, whose runs several studies share; parameter.NAME [SI], or the mechanism as JSON if
        the machine is from a file; engine, engine_version; the preset that settings are or come from, None if there is
        none;
        setting.NAME [SI];
        steps_per_revolution, revolutions, start_angle [rad], cache_version; outcome, reason;
        passed: the verdict by conrod's own tolerances, of a result of `conrod validate`, `forces` or `free`;
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
        "study": identity["study"],
        **{f"parameter.{n}": _table_value(value) for n, value in identity["parameters"].items()},
        "engine": identity["engine"],
        "engine_version": identity["engine_version"],
        "preset": identity.get("preset", identity.get("label")),
        **{f"setting.{n}": _table_value(value) for n, value in settings.items()},
        "steps_per_revolution": steps,
        "revolutions": identity.get("revolutions"),
        "start_angle": identity.get("start_angle"),
        "cache_version": identity["cache_version"],
        **_result_columns(result or {}),
        **{name: None if timing is None else getattr(timing, name) for name in TIMING_FIELDS},
    }


def _table_value(value: Any) -> Any:
    """Value for one cell of a table: a mapping becomes JSON, a list text."""
    if isinstance(value, Mapping):
        return json.dumps(value, sort_keys=True)
    return " ".join(str(part) for part in value) if isinstance(value, list | tuple) else value


def _result_columns(result: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of the table that hold what a run gave: outcome, errors, predictions."""
    closure, phase, drive, prediction, sizes = (
        result.get(name) or {} for name in ("closure", "phase", "drive", "prediction", SIZES)
    )
    predicted = {q: prediction.get(q, {}) for q in QUANTITIES}
    return {
        "outcome": result.get("outcome"),
        "reason": result.get("reason") or None,
        "passed": result.get("passed"),
        **{f"{q}_{measure}": sizes.get(q, {}).get(measure) for q in COMPARED for measure in MEASURES},
        **{f"closure_{q}": closure.get(q) for q in QUANTITIES},
        **{f"phase_{measure}": phase.get(measure) for measure in ("max", "final")},
        **{f"drive_{q}": drive.get(q) for q in ("speed", "acceleration")},
        **{f"predicted_{q}": predicted[q].get("predicted") for q in QUANTITIES},
        **{f"predicted_{q}_difference": predicted[q].get("difference") for q in QUANTITIES},
        **{f"{q}_{measure}": size for q, found in sizes.items() for measure, size in found.items()},
    }


def columns_of(rows: Sequence[Mapping[str, Any]], wanted: Sequence[str] = ()) -> list[str]:
    """Names of the requested columns, or of all columns that any row has.

    Raises:
        InvalidInput: no row has a column that is wanted; names the nearest.
    """
    known = list(dict.fromkeys(name for row in rows for name in row))
    for name in wanted:
        if rows and name not in known:
            raise unknown_choice("column", name, known)
    return list(wanted) or known


def table_text(rows: Sequence[Mapping[str, Any]], form: str, wanted: Sequence[str] = ()) -> str:
    """Rows as text, with the union of their columns or those wanted: csv, or json with one object a line."""
    columns = columns_of(rows, wanted)
    if form == "json":
        lines = [json.dumps({name: row.get(name) for name in columns}, allow_nan=False) for row in rows]
        return "[\n" + ",\n".join(lines) + "\n]\n"
    stream = io.StringIO()
    if rows:
        writer = csv.DictWriter(stream, columns, lineterminator="\n", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    return stream.getvalue()
