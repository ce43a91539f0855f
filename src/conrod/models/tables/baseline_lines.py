"""A judged table as the line of a baseline."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.execution.baseline import BaselineLine
from conrod.execution.baseline_check import baseline_line
from conrod.models.tables.errors import ALL_ERRORS
from conrod.models.tables.study import TableStudy


def table_lines(found: Sequence[TableStudy]) -> dict[str, BaselineLine]:
    """Return the line of one judged table."""
    (study,) = found
    sizes = {name: study.largest(name) for name in (*ALL_ERRORS, "phase")}
    return {"table": baseline_line("completed", study.passed, sizes)}
