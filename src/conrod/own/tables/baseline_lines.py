"""A judged table as the line of a baseline."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.own.tables.errors import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.studies.frame.baseline import BaselineLine
from conrod.studies.frame.baseline_check import baseline_line


def table_lines(found: Sequence[TableStudy]) -> dict[str, BaselineLine]:
    """Return the line of one judged table."""
    (study,) = found
    sizes = {name: study.largest(name) for name in (*ERRORS, "phase")}
    return {"table": baseline_line("completed", study.passed, sizes)}
