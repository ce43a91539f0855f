"""Whether engines do the same thing twice."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.styles import engine_title
from conrod.report.tables import table
from conrod.studies.limits.determinism import Determinism

HEAD = [
    "engine",
    "preset",
    "again in one process",
    "after another machine",
    "in another process",
    "ended",
    "fingerprint",
]
SHOWN = 12  # hexadecimal digits
ANSWERS = {True: "identical", False: "**different**", None: numbers.MISSING}


def determinism_table(found: Sequence[Determinism], with_scene: bool = False) -> str:
    """A row for each engine and preset; nothing where there is none."""
    rows = [[*([one.scene] if with_scene else []), *_cells(one)] for one in found]
    return table([*(["machine"] if with_scene else []), *HEAD], rows)


def _cells(one: Determinism) -> list[str]:
    same = (one.identical_in_process, one.identical_after_another, one.identical_across)
    first = one.fingerprints.get("first")
    return [
        engine_title(one.engine),
        one.preset,
        *(ANSWERS[answer] for answer in same),
        one.outcome,
        numbers.MISSING if first is None else f"`{first[:SHOWN]}`",
    ]
