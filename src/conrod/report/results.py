"""Words and tables on a scene and its judged results, the same on terminals and on pages."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeVar

from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_style
from conrod.engines.engine import STOCK
from conrod.execution.result import JudgedResult, SceneResults
from conrod.execution.tolerances import Scales, judged_scale, scene_scales
from conrod.report import numbers
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, table
from conrod.report.terminal import PrintedPart, verdict_line
from conrod.scenes import Scene

KINEMATIC = "kinematic mode"
PLAIN_NAMES = {
    "velocity_rms": "velocity (rms)", "total": "position at time t", "closure": "loops open",
    "angular_velocity": "angular velocity", "angular_acceleration": "angular acceleration",
}  # fmt: skip
DISTRUST_ADVICE = "This is an error of conrod, not of the engine or the model; please report it."

MIN_ACCELERATION_LACK = (
    1e-3  # error of an acceleration, normalised, from which on it is said that an engine lacks a part of it
)

AS_IT_COMES = "as it comes (stock)"

R = TypeVar("R", bound=JudgedResult)


def engine_and_preset(result: JudgedResult) -> tuple[str, str]:
    """Return engine and preset of a result, the first two cells of its row."""
    return engine_style(result.engine).title, result.preset or KINEMATIC


def verdict_words(result: JudgedResult, scene: Scene | None = None) -> str:
    """Say whether a result is within tolerance, or why not, or why its run did not complete.

    Args:
        scene: scene of the result, whose sizes are printed beside shares; None for shares alone.
    """
    if not result.completed:
        failed = "" if result.passed is not False else "failed, "
        return f"{failed}{result.outcome}: {result.reason or Outcome.from_slug(result.outcome).meaning}"
    if result.distrust:
        return f"CANNOT BE TRUSTED: {result.distrust}"
    if result.passed is None:
        return "measured, not judged"
    if result.passed:
        return f"within tolerance{lacking_words(result)}"
    scales = {} if scene is None else judged_scales(result, {**scene_scales(scene), **result.own_scales()})
    over = exceeded_words(result.out_of_tolerance(), scales=scales)
    return "OUT OF TOLERANCE: " + "; ".join([*over, *result.other_failures()])


def judged_scales(result: JudgedResult, scales: Scales) -> dict[str, float]:
    """SI size of a share of 1 of each judged error, by quantity.

    Args:
        scales: by quantity and point or link.
    """
    weights = result.weights or {}
    found = {
        name: judged_scale(result.judged_points(name), scales.get(name, {}), weighed=name in weights)
        for name in result.limits
    }
    return {name: scale for name, scale in found.items() if scale is not None}


def lacking_words(result: JudgedResult) -> str:
    """Name the term of accelerations that the engine lacks, if it shows; empty otherwise."""
    look = engine_style(result.engine)
    if not look.missing_term:
        return ""
    off = result.acceleration_error
    if off is None or not off > MIN_ACCELERATION_LACK:
        return ""
    return f", though {look.title} lacks {look.missing_term}: accelerations are off by {numbers.measured_text(off)}"


def exceeded_words(
    exceeded: Mapping[str, tuple[float | None, float]],
    allowed_text: Callable[[str, float], str] = numbers.allowed_text,
    scales: Mapping[str, float] = MappingProxyType({}),
) -> list[str]:
    """List the quantities out of tolerance, each with its error and tolerance.

    Args:
        scales: SI size of a share of 1, by quantity, to print sizes beside shares.
    """
    return [
        f"{PLAIN_NAMES.get(name, name)} has no error to judge"
        if found is None
        else f"{PLAIN_NAMES.get(name, name)} {_error_and_limit(name, found, allowed, allowed_text, scales.get(name))}"
        for name, (found, allowed) in exceeded.items()
    ]


def within_words(
    judged: Mapping[str, tuple[float | None, float]],
    allowed_text: Callable[[str, float], str],
    scales: Mapping[str, float],
) -> list[str]:
    """List judged quantities with error and tolerance: `position 4.7e-5 (0.01 mm) <= 1e-4 (0.021 mm)`.

    Args:
        scales: as for `exceeded_words`.
    """
    lines = []
    for name, (found, allowed) in judged.items():
        error = numbers.with_size(numbers.error(name, found), name, found or 0.0, scales.get(name))
        limit = numbers.with_size(allowed_text(name, allowed), name, allowed, scales.get(name))
        lines.append(f"{name.replace('angular_', 'angular ')} {error} <= {limit}")
    return lines


def _error_and_limit(
    name: str, found: float, allowed: float, allowed_text: Callable[[str, float], str], scale: float | None
) -> str:
    """Return an error and its tolerance, as `4.7e-4 (0.1 mm) > 1e-4 (0.021 mm)`."""
    error = numbers.with_size(numbers.error(name, found), name, found, scale)
    return f"{error} > {numbers.with_size(allowed_text(name, allowed), name, allowed, scale)}"


def scene_verdict(study: SceneResults[Any]) -> str:
    """Return the verdict on a scene, with each result that is out of tolerance."""
    failed = [
        f"{' '.join(engine_and_preset(one))}: {verdict_words(one, study.scene)}"
        for one in study.results
        if one.passed is False
    ]
    return f"{study.name}: {'; '.join(failed) or summary_words(study.results, study.scene.lengths)}"


def distrust_words(findings: Any) -> str:
    """Say which figures of a study cannot be trusted, and why; empty if the exact motion contradicts nothing."""
    return f"CANNOT BE TRUSTED: {findings.distrust}. {DISTRUST_ADVICE}" if findings.distrust else ""


def distrust_lines(studies: Iterable[Any]) -> Iterator[PrintedPart]:
    """Yield a line for each study whose figures cannot be trusted, to print first."""
    yield from (verdict_line(words, False) for study in studies if (words := distrust_words(study)))


def distrusted_scenes(studies: Sequence[SceneResults[Any]]) -> Iterator[PrintedPart]:
    """Yield a line for each scene whose exact motion contradicts itself, to print first."""
    doubted = [study for study in studies if any(result.distrust for result in study.results)]
    yield from (verdict_line(f"{study.name}: {summary_words(study.results)}", False) for study in doubted)


def verdict_cell(result: JudgedResult, scene: Scene, more: str = "") -> Cell:
    """Return the verdict on a result of a scene as a coloured cell, with more words added."""
    words = verdict_words(result, scene) + more
    if not result.completed and result.passed is None:
        return ColouredCell(words, "odd")
    return words if result.passed is None else ColouredCell(words, "good" if result.passed else "bad")


def summary_words(results: Iterable[JudgedResult], lengths: Mapping[str, float] = MappingProxyType({})) -> str:
    """Return how far off a scene's results are, and the verdict on them, in a few sentences.

    Args:
        lengths: L of each observed point [m]; without them no sizes are said.
    """
    found = list(results)
    judged = [r for r in found if r.passed is not None]
    failed = [r for r in judged if not r.passed]
    if doubted := [r for r in judged if r.distrust]:
        names = ", ".join(" ".join(engine_and_preset(r)) for r in doubted)
        return f"Cannot be trusted ({names}): {doubted[0].distrust}. {DISTRUST_ADVICE}"
    sizes = _engine_sentences(found, lengths)
    said = [] if judged else ["Nothing was judged."]
    if failed:
        names = ", ".join(" ".join(engine_and_preset(r)) for r in failed)
        said.append(f"{len(failed)} of {len(judged)} judged results did not pass: {names}.")
    elif judged and not sizes:
        count = "The judged result is" if len(judged) == 1 else f"All {len(judged)} judged results are"
        lacking = dict.fromkeys(filter(None, map(lacking_words, judged)))
        said.append(f"{count} within tolerance{next(iter(lacking), '')}.")
    return " ".join([*said, *sizes])


def _preset_words(preset: str | None) -> str:
    """Return a preset's name in a sentence."""
    return KINEMATIC if preset is None else AS_IT_COMES if preset == STOCK else preset


def _offset_words(result: JudgedResult, lengths: Mapping[str, float]) -> str:
    """Return the largest position error of a run in mm, `7.9 mm`; empty if it has none.

    Args:
        lengths: L of each observed point [m].
    """
    errors = replace(result, weights=None).judged_points("position") if result.completed else {}
    if not errors or not errors.keys() <= lengths.keys():
        return ""
    return f"{numbers.in_mm(errors, lengths)} mm"


def _engine_sentence(engine: str, results: Sequence[JudgedResult], lengths: Mapping[str, float]) -> str:
    """Say how far off an engine's results are, the unjudged first; empty if none has an error.

    Args:
        results: of the engine; those that failed are left out.
    """
    parts = []
    for run in results:
        if run.passed is None and (offset := _offset_words(run, lengths)):
            parts.append(f"{_preset_words(run.preset)} is {offset} off (not judged)")
        elif run.passed is None and not run.completed and run.outcome != Outcome.UNSUPPORTED.slug:
            parts.append(f"{_preset_words(run.preset)} ended as {run.outcome} (not judged)")
    within = [run for run in results if run.passed]
    if within:
        named = [f"{_preset_words(run.preset)} {_offset_words(run, lengths)}".strip() for run in within]
        verb = "is" if len(within) == 1 else "are"
        lacking = next(filter(None, map(lacking_words, within)), "")
        parts.append(f"{join_in_sentence(named)} {verb} within tolerance{lacking}")
    return f"{engine_style(engine).title} {'; '.join(parts)}." if parts else ""


def _engine_sentences(results: Iterable[JudgedResult], lengths: Mapping[str, float]) -> list[str]:
    """Return a sentence on each engine's errors; none if no result has an error in mm."""
    of_engine: dict[str, list[JudgedResult]] = {}
    for run in results:
        of_engine.setdefault(run.engine, []).append(run)
    if not any(_offset_words(run, lengths) for runs in of_engine.values() for run in runs):
        return []
    return [said for name, runs in of_engine.items() if (said := _engine_sentence(name, runs, lengths))]


def join_in_sentence(words: Sequence[str]) -> str:
    """Join words as in a sentence: `a, b and c`."""
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def versions_words(results: Iterable[JudgedResult]) -> str:
    """Name the engines of some results with their versions."""
    return ", ".join(dict.fromkeys(f"{engine_style(r.engine).title} {r.engine_version}" for r in results))


def results_table(
    studies: Sequence[SceneResults[R]],
    columns: Mapping[str, Callable[[R], str]],
    title: str,
    verdict: Callable[[R, Scene], Cell] = verdict_cell,
) -> Table:
    """Return a row for each result: scene, engine, preset, given columns, verdict."""
    rows = [
        (study.name, *engine_and_preset(r), *(text(r) for text in columns.values()), verdict(r, study.scene))
        for study in studies
        for r in study.results
    ]
    return table(("scene", "engine", "preset", *columns, VERDICT), rows, columns, title, names=3)


def scene_summary(study: SceneResults[R], more: Callable[[R], Mapping[str, Any]]) -> dict[str, Any]:
    """Return a summary of a scene's results as plain values, for the index and for scripts.

    Args:
        more: returns further values of a result.
    """
    results = [
        {
            "engine": r.engine,
            "engine_version": r.engine_version,
            "preset": r.preset,
            "outcome": r.outcome,
            "reason": r.reason,
            "passed": r.passed,
            "verdict": verdict_words(r, study.scene),
            **more(r),
        }
        for r in study.results
    ]
    return {"passed": study.passed, "verdict": summary_words(study.results, study.scene.lengths), "results": results}


def scene_description(scene: Scene) -> str:
    """Return the scene's description, with the values of the parameters that it names."""
    facts = scene.parameter_facts()
    words = {
        name: " ".join(numbers.in_shown_unit(value, facts[name].unit)).removesuffix(" -")
        for name, value in scene.parameters.items()
    }
    return scene.description.format(**words)


def parameters_table(scene: Scene) -> Table:
    """Return a row for each parameter of the scene: value, unit, meaning."""
    facts = scene.parameter_facts()
    rows = [
        (f"`{name}`", *numbers.in_shown_unit(value, facts[name].unit), facts[name].meaning)
        for name, value in scene.parameters.items()
    ]
    return table(("parameter", "value", "unit", "meaning"), rows, right=("value",))


# -- the first sentence of an index of machines ------------------------------------------------------------------------


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
    """Return the largest position error of a run [m]; 0 if it has none."""
    return run.get("position_m") or 0.0
