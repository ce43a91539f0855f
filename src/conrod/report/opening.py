"""The first sentences of a report: how far off each engine is, with what was not judged named too."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_style
from conrod.engines.engine import STOCK
from conrod.execution.result import JudgedResult
from conrod.report import numbers

KINEMATIC = "kinematic mode"
AS_IT_COMES = "as it comes (stock)"
NO_SIZE = ""


def preset_words(preset: str | None) -> str:
    """Return a preset's name in a sentence."""
    return KINEMATIC if preset is None else AS_IT_COMES if preset == STOCK else preset


def offset_words(result: JudgedResult, lengths: Mapping[str, float]) -> str:
    """Return the largest position error of a run in mm, `7.9 mm`; empty if it has none.

    Args:
        lengths: L of each observed point [m].
    """
    errors = replace(result, weights=None).judged_points("position") if result.completed else {}
    if not errors or not errors.keys() <= lengths.keys():
        return NO_SIZE
    return f"{numbers.in_mm(errors, lengths)} mm"


def engine_sentence(
    engine: str, results: Sequence[JudgedResult], lengths: Mapping[str, float], lack: Callable[[JudgedResult], str]
) -> str:
    """Say how far off an engine's results are, first those that are not judged; empty if there is nothing to say.

    Args:
        results: of the engine; those that failed are left out.
        lack: returns words on what the engine lacks.
    """
    parts = []
    for run in results:
        if run.passed is None and (offset := offset_words(run, lengths)):
            parts.append(f"{preset_words(run.preset)} is {offset} off (not judged)")
        elif run.passed is None and not run.completed and run.outcome != Outcome.UNSUPPORTED.slug:
            parts.append(f"{preset_words(run.preset)} ended as {run.outcome} (not judged)")
    within = [run for run in results if run.passed]
    if within:
        named = [f"{preset_words(run.preset)} {offset_words(run, lengths)}".strip() for run in within]
        verb = "is" if len(within) == 1 else "are"
        lacking = next(filter(None, map(lack, within)), "")
        parts.append(f"{joined(named)} {verb} within tolerance{lacking}")
    return f"{engine_style(engine).title} {'; '.join(parts)}." if parts else ""


def engine_sentences(
    results: Iterable[JudgedResult], lengths: Mapping[str, float], lack: Callable[[JudgedResult], str]
) -> list[str]:
    """Say how far off each engine's results are, a sentence each; nothing where no result has a size."""
    of_engine: dict[str, list[JudgedResult]] = {}
    for run in results:
        of_engine.setdefault(run.engine, []).append(run)
    if not any(offset_words(run, lengths) for runs in of_engine.values() for run in runs):
        return []
    return [said for name, runs in of_engine.items() if (said := engine_sentence(name, runs, lengths, lack))]


def joined(words: Sequence[str]) -> str:
    """Join words as in a sentence: `a, b and c`."""
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


# -- many machines -----------------------------------------------------------------------------------------------------


def index_words(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say of a report's machines how far off engines are as they come, and what was judged.

    Args:
        entries: entries of the report's index by machine, see `scene_summary`.
    """
    failed = [name for name, entry in entries.items() if entry["summary"]["passed"] is False]
    runs = [(name, run) for name, entry in entries.items() for run in entry["summary"]["results"]]
    stock = [(name, run) for name, run in runs if run["passed"] is None and run["preset"] == STOCK]
    said = [words for engine in dict.fromkeys(run["engine"] for _, run in stock) if (words := _worst(engine, stock))]
    worst = f"As they come (stock, not judged), {joined(said)}. " if said else ""
    judged = [run for _, run in runs if run["passed"] is not None]
    largest = max((_metres(run) for run in judged), default=0.0)
    at_most = f", off by at most {numbers.measured_text(1e3 * largest)} mm" if largest else ""
    verdict = (
        f"Not within tolerance: {', '.join(failed)}." if failed else f"All that is judged is within tolerance{at_most}."
    )
    return worst + (verdict if judged else "Nothing was judged.")


def _worst(engine: str, runs: Iterable[tuple[str, Mapping[str, Any]]]) -> str:
    """Return the largest position error of an engine's runs with its machine; empty if there is none."""
    sizes = {name: _metres(run) for name, run in runs if run["engine"] == engine}
    name = max(sizes, key=lambda one: sizes[one])
    size = numbers.measured_text(1e3 * sizes[name])
    return f"{engine_style(engine).title} is up to {size} mm off ({name})" if sizes[name] else ""


def _metres(run: Mapping[str, Any]) -> float:
    return run.get("position_m") or 0.0
