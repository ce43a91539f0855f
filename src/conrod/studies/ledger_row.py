"""A run of the ledger as one flat row of a tidy table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from conrod.comparison import QUANTITIES as COMPARED
from conrod.studies.measurement import Measurement
from conrod.studies.results import QUANTITIES
from conrod.studies.timing import Timing

MEASURES = ("max", "rms", "final")


def tidy_row(
    key: str, name: str, identity: Mapping[str, Any], measurement: Measurement | None, timing: Timing | None
) -> dict[str, Any]:
    """The row of a run; what it does not have is None.

    Columns, in this order:
        key, scene, kind; parameter.NAME [SI], of a machine from a file its mechanism as JSON; engine, engine_version;
        setting.NAME [SI];
        steps_per_revolution, revolutions, start_angle [rad], result_version; outcome, reason;
        position, velocity, acceleration, total, each _max, _rms, _final: largest of the observed points, normalised;
        closure_position, _velocity, _acceleration; phase_max, _final [rad]; drive_speed, _acceleration;
        predicted_position, _velocity, _acceleration: told from the joints alone, and each with _difference;
        seconds_per_revolution [s], reference_seconds [s], ratio, machine.
    """
    settings = dict(identity["settings"])
    steps = settings.pop("steps_per_revolution")
    return {
        "key": key,
        "scene": name,
        "kind": identity["scene"],
        **{f"parameter.{n}": _plain(value) for n, value in identity["parameters"].items()},
        "engine": identity["engine"],
        "engine_version": identity["engine_version"],
        **{f"setting.{n}": _plain(value) for n, value in settings.items()},
        "steps_per_revolution": steps,
        "revolutions": identity["revolutions"],
        "start_angle": identity["start_angle"],
        "result_version": identity["result_version"],
        **_measured(measurement),
        **_timed(timing),
    }


def _plain(value: Any) -> Any:
    """A value that a cell of a table can hold: what a setting holds several of becomes text."""
    if isinstance(value, Mapping):
        return json.dumps(value, sort_keys=True)
    return " ".join(str(part) for part in value) if isinstance(value, list | tuple) else value


def _measured(measurement: Measurement | None) -> dict[str, Any]:
    m = measurement if measurement is not None else Measurement(outcome="")
    closure, phase, drive, prediction = m.closure or {}, m.phase or {}, m.drive or {}, m.prediction or {}
    told = {q: prediction.get(q, {}) for q in QUANTITIES}
    return {
        "outcome": m.outcome or None,
        "reason": m.reason or None,
        **{f"{q}_{measure}": m.largest(q, measure) for q in COMPARED for measure in MEASURES},
        **{f"closure_{q}": closure.get(q) for q in QUANTITIES},
        **{f"phase_{measure}": phase.get(measure) for measure in ("max", "final")},
        **{f"drive_{q}": drive.get(q) for q in ("speed", "acceleration")},
        **{f"predicted_{q}": told[q].get("predicted") for q in QUANTITIES},
        **{f"predicted_{q}_difference": told[q].get("difference") for q in QUANTITIES},
    }


def _timed(timing: Timing | None) -> dict[str, Any]:
    columns = ("seconds_per_revolution", "reference_seconds", "ratio", "machine")
    return {name: None if timing is None else getattr(timing, name) for name in columns}
