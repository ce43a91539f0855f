"""The first sentence of an index of machines: how far off each engine is as it comes, and what was judged."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from conrod.engines import engine_style
from conrod.engines.engine import STOCK
from conrod.report import numbers
from conrod.report.results import join_in_sentence


def index_words(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Summarise a report's machines: largest errors of unjudged stock engines, then the verdict.

    Args:
        entries: entries of the report's index by machine, see `scene_summary`.
    """
    failed = [name for name, entry in entries.items() if entry["summary"]["passed"] is False]
    runs = [(name, run) for name, entry in entries.items() for run in entry["summary"]["results"]]
    stock = [(name, run) for name, run in runs if run["passed"] is None and run["preset"] == STOCK]
    said = [
        words
        for engine in dict.fromkeys(run["engine"] for _, run in stock)
        if (words := _worst_error_words(engine, stock))
    ]
    worst = f"As they come (stock, not judged), {join_in_sentence(said)}. " if said else ""
    judged = [run for _, run in runs if run["passed"] is not None]
    largest = max((_metres(run) for run in judged), default=0.0)
    at_most = f", off by at most {numbers.measured_text(1e3 * largest)} mm" if largest else ""
    verdict = f"Not passed: {', '.join(failed)}." if failed else f"All that is judged is within tolerance{at_most}."
    return worst + (verdict if judged else "Nothing was judged.")


def _worst_error_words(engine: str, runs: Iterable[tuple[str, Mapping[str, Any]]]) -> str:
    """Describe the largest position error of an engine's runs, with the machine; empty without one."""
    sizes = {name: _metres(run) for name, run in runs if run["engine"] == engine}
    name = max(sizes, key=lambda one: sizes[one])
    size = numbers.measured_text(1e3 * sizes[name])
    return f"{engine_style(engine).title} is up to {size} mm off ({name})" if sizes[name] else ""


def _metres(run: Mapping[str, Any]) -> float:
    return run.get("position_m") or 0.0
