"""Free motion of scenes as the lines of a baseline."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.execution.baseline import ORDER_PREFIX, BaselineLine
from conrod.execution.baseline_check import baseline_line, line_name
from conrod.studies.free_motion.results import MotionResult, MotionStudy


def motion_lines(found: Sequence[MotionStudy]) -> dict[str, BaselineLine]:
    """Return the results of free motion as lines of a baseline: one for each engine and preset."""
    pairs = [(one.name, result) for one in found for result in one.results]
    return {line_name(name, result, several=len(found) > 1): _line(result) for name, result in pairs}


def _line(result: MotionResult) -> BaselineLine:
    names = result.quantities if result.completed else ()
    orders = {f"{ORDER_PREFIX}{name}": (result.order or {}).get(name) for name in names}
    return baseline_line(result.outcome, result.passed, {name: result.largest(name) for name in names} | orders)
