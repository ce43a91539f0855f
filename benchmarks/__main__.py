"""Measure everything, print it as a table, keep it in benchmarks/results.json. Exit status 1 if a bar is missed."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

from benchmarks import (
    command_cost,
    help_time,
    ledger_cost,
    machine,
    mujoco_recording,
    pymunk_recording,
    references,
    space_cost,
    suite_cost,
    two_jobs,
)
from benchmarks.row import Row
from conrod.crash import run_guarded

RESULTS = Path(__file__).parent / "results.json"
# Rows and the number of their repeats.
GROUPS: dict[str, tuple[Callable[[int], list[Row]], int]] = {
    "mujoco": (mujoco_recording.rows, 7),
    "pymunk": (pymunk_recording.rows, 11),
    "references": (references.rows, 11),
    "ledger": (ledger_cost.rows, 5),
    "jobs": (two_jobs.rows, 3),
    "help": (help_time.rows, 11),
    "commands": (command_cost.rows, 5),
    "space": (space_cost.rows, 3),
    "recommend": (command_cost.recommend_rows, 1),
    "suite": (suite_cost.rows, 1),
}


def main() -> int:
    """The table on standard output; progress on standard error."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=f"of {', '.join(GROUPS)}; all if none is given")
    chosen = parser.parse_args().groups or list(GROUPS)
    if unknown := sorted(set(chosen) - set(GROUPS)):
        parser.error(f"unknown group {', '.join(unknown)}; there are {', '.join(GROUPS)}")
    rows: list[Row] = []
    loads = [machine.load()]
    for name in chosen:
        print(f"{name} ...", file=sys.stderr, flush=True)
        measured, repeats = GROUPS[name]
        rows += measured(repeats)
        loads.append(machine.load())
    where = machine.described() | {"load": ", ".join("?" if x is None else f"{x:.1f}" for x in loads)}
    RESULTS.write_text(json.dumps({"machine": where, "rows": [_as_dict(row) for row in rows]}, indent=2) + "\n")
    print(table(rows))
    print("\n" + "; ".join(f"{key} {value}" for key, value in where.items()))
    return 1 if any(row.reached is False for row in rows) else 0


def table(rows: list[Row]) -> str:
    """Markdown."""
    lines = ["| what | median | best | bar | |", "|---|---|---|---|---|"]
    for row in rows:
        bar = "" if row.bar is None else f"{row.bar:g} {row.unit}"
        verdict = {True: "reached", False: "**missed**", None: ""}[row.reached]
        lines.append(f"| {row.name} | {row.median:.3g} {row.unit} | {row.best:.3g} | {bar} | {verdict} |")
    return "\n".join(lines)


def _as_dict(row: Row) -> dict[str, object]:
    return {
        "name": row.name,
        "unit": row.unit,
        "median": row.median,
        "best": row.best,
        "bar": row.bar,
        "reached": row.reached,
        "repeats": list(row.repeats),
    }


if __name__ == "__main__":
    run_guarded(main)
