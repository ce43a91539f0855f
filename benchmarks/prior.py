"""The table that `conrod recommend` starts from, made of saved sweeps: `python -m benchmarks.prior DATA.json...`."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from conrod.exact.motion import QUANTITIES
from conrod.studies.sweep.prior import DECIBELS, PriorSweep


def table_of(studies: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The table of saved sweeps (data of a sweep's report)."""
    return {study["name"]: _machine(study["points"]) for study in studies}


def _machine(points: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    steps = sorted({point["steps_per_revolution"] for point in points})
    made: dict[str, Any] = {"steps": steps}
    for engine, rule in dict.fromkeys((point["engine"], point["rule"]) for point in points):
        own = {p["steps_per_revolution"]: p for p in points if (p["engine"], p["rule"]) == (engine, rule)}
        costs = [point["ratio"] / n for n, point in own.items() if point["ratio"] is not None]
        if costs:
            errors = [[_decibels(own[n]["errors"], q) for n in steps] for q in QUANTITIES]
            made.setdefault(engine, {})[rule] = [float(f"{median(costs):.3g}"), *errors]
    return made


def _decibels(errors: Mapping[str, float] | None, quantity: str) -> int | None:
    return None if errors is None else round(DECIBELS * math.log10(max(errors[quantity], 1e-30)))


def table_text(table: Mapping[str, PriorSweep]) -> str:
    """The table as JSON, one machine a line."""
    compact = json.JSONEncoder(separators=(",", ":")).encode
    return "{\n" + ",\n".join(f"{compact(name)}:{compact(swept)}" for name, swept in table.items()) + "\n}\n"


if __name__ == "__main__":
    sys.stdout.write(table_text(table_of([json.loads(Path(name).read_text("utf-8")) for name in sys.argv[1:]])))
