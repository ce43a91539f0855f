"""The report on machines in space: engines beside each other, on the console and as pages."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from conrod.comparison.trajectory import Outcome
from conrod.exact.motion import QUANTITIES
from conrod.report import numbers
from conrod.report.figure import Figure
from conrod.report.kind import Kind
from conrod.report.results import engine_and_preset, exceeded_words, join_in_sentence, verdict_words
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, table
from conrod.report.terminal import PrintedPart
from conrod.studies.space.results import LOOPS, SpatialResult, SpatialStudy, StepRun

BARS = (1e-3, 1e-6, 1e-9)  # position errors over L, for which the cheapest runs are sought
COMPARED = {"position": QUANTITIES[:1], "all three": QUANTITIES}  # of which the worst counts
ALIKE_COSTS = 1.3  # ratio of two costs that timings on a busy machine may turn round
MAX_NAMED = 3  # machines named in a sentence
ERROR_COLUMNS = (*QUANTITIES, "loops open")
ORDERS, COST, COST_RATIO = "order x, v, a", "a step [µs]", "cost of a step"
TITLE = "largest errors at the same times, over L, the largest speed and the largest acceleration"

# -- words -----------------------------------------------------------------------------------------------------------


def finding(studies: Sequence[SpatialStudy]) -> str:
    """Say which engines stay within what, and who ends early where, and why; what is within a tolerance first."""
    by_preset = dict[tuple[str, str], list[SpatialResult]]()
    for study in studies:
        for one in study.results:
            by_preset.setdefault(engine_and_preset(one), []).append(one)
    done = {name: [one for one in found if one.completed] for name, found in by_preset.items()}
    worst = {name: _worst(found, "position") for name, found in done.items() if found}
    judged = _tolerance_sentence(by_preset)
    if not worst:
        return f"{judged}No run came to its end. {_failure_sentence(by_preset)}"
    short = _short_runs(studies)
    sizes = [
        f"{' '.join(name)} {numbers.measured_text(worst[name])}{short.get(name, '')}"
        for name in sorted(worst, key=worst.__getitem__)
    ]
    where = studies[0].name if len(studies) == 1 else f"{len(studies)} machines in space"
    said = [f"{judged}On {where} the largest position errors over L are: {', '.join(sizes)}."]
    if failed := _failure_sentence(by_preset):
        said.append(failed)
    whole = {name: _worst(found, "acceleration") for name, found in done.items() if len(found) == len(studies)}
    if len(whole) > 1:
        by_size = sorted(whole, key=whole.__getitem__)
        best, last = (f"{' '.join(name)} ({numbers.measured_text(whole[name])})" for name in (by_size[0], by_size[-1]))
        said.append(f"Accelerations are best in {best}, worst in {last}.")
    return " ".join(said)


def _short_runs(studies: Sequence[SpatialStudy]) -> dict[tuple[str, str], str]:
    """Say of presets that were run with fewer steps than others with how many at most, by engine and preset."""
    steps = {engine_and_preset(one): one.steps_per_rev for study in studies for one in study.results}
    return {name: f" (at {steps[name]} steps)" for name in steps if steps[name] < max(steps.values())}


def _tolerance_sentence(by_preset: Mapping[tuple[str, str], Sequence[SpatialResult]]) -> str:
    """Say which presets are within tolerance on all machines, and a space; empty if nothing was judged."""
    if all(one.passed is None for found in by_preset.values() for one in found):
        return ""
    within = [" ".join(name) for name, found in by_preset.items() if all(one.passed for one in found)]
    where = "" if all(len(found) == 1 for found in by_preset.values()) else " on all machines"
    return f"Within tolerance{where}: {join_in_sentence(within) if within else 'none'}. "


def result_words(one: SpatialResult, scales: Mapping[str, float]) -> str:
    """The verdict on a result in words, with the sizes of what is out of tolerance.

    Args:
        scales: as in `SpatialStudy`.
    """
    if not one.completed or one.passed is not False:
        return verdict_words(one)
    sizes = {**scales, LOOPS: scales["position"]} if scales else {}
    return "OUT OF TOLERANCE: " + "; ".join(exceeded_words(one.out_of_tolerance(), scales=sizes))


def _worst(found: Sequence[SpatialResult], quantity: str) -> float:
    return max(one.largest(quantity) or 0.0 for one in found)


def _failure_sentence(by_preset: Mapping[tuple[str, str], Sequence[SpatialResult]]) -> str:
    """Say which presets did not run through which machines, and why; empty if all did."""
    said = []
    for name, found in by_preset.items():
        by_outcome = dict[str, list[SpatialResult]]()
        for one in found:
            if not one.completed:
                by_outcome.setdefault(one.outcome, []).append(one)
        for outcome, ended in by_outcome.items():
            more = f" and {len(ended) - MAX_NAMED} more" if len(ended) > MAX_NAMED else ""
            why = ended[0].reason or Outcome.from_slug(outcome).meaning
            machines = ", ".join(one.scene for one in ended[:MAX_NAMED])
            said.append(f"{' '.join(name)} has no result on {machines}{more} ({outcome}: {why})")
    return f"{'; '.join(said)}." if said else ""


def verdict(study: SpatialStudy) -> str:
    """Say how far off the engines are on one machine, and which quantities are out of tolerance."""
    failed = [
        f"{' '.join(engine_and_preset(one))}: {result_words(one, study.scales)}"
        for one in study.results
        if one.passed is False
    ]
    return f"{study.name}: {'; '.join(failed) or finding([study])}"


# -- tables ----------------------------------------------------------------------------------------------------------


def verdicts_table(studies: Sequence[SpatialStudy], *, ratios: bool = False) -> Table:
    """Return a row for each machine, engine and preset: errors, gap, orders, cost of a step, verdict.

    Args:
        ratios: whether costs are over the least of the machine, as other computers find them, too; or in µs.
    """
    rows = [
        (study.name, *engine_and_preset(one), *_cells(one, study.scales, _least_cost(study) if ratios else 1.0))
        for study in studies
        for one in study.results
    ]
    columns = (*ERROR_COLUMNS, ORDERS, COST_RATIO if ratios else COST)
    return table(("machine", "engine", "preset", *columns, VERDICT), rows, columns, TITLE, names=3)


def _least_cost(study: SpatialStudy) -> float:
    return min((one.cost for one in study.results if not math.isnan(one.cost)), default=1.0)


def _cells(one: SpatialResult, scales: Mapping[str, float], unit: float) -> tuple[Cell, ...]:
    sizes = [numbers.measured_text(one.largest(name)) for name in (*QUANTITIES, LOOPS)]
    orders = ", ".join(numbers.order((one.order or {}).get(name)) for name in QUANTITIES) if one.order else ""
    cost = numbers.MISSING
    if not math.isnan(one.cost):
        cost = numbers.quantity(numbers.round_to_digits(one.cost / unit, 2 if unit == 1.0 else 1))
    words = result_words(one, scales)
    if one.passed is None:
        return (*sizes, orders, cost, words if one.completed else ColouredCell(words, "odd"))
    return (*sizes, orders, cost, ColouredCell(words, "good" if one.passed else "bad"))


def cheapest_run(study: SpatialStudy, bar: float, quantities: Sequence[str]) -> tuple[SpatialResult, StepRun] | None:
    """The run with the least cost of a revolution whose errors are within a bar; None if none is.

    Of runs whose costs differ by less than timings do, it is the most accurate.
    """
    found = [
        (one, run)
        for one in study.results
        for run in one.runs
        if not math.isnan(run.cost) and run.worst(*quantities) <= bar
    ]
    least = min((run.revolution_cost for _, run in found), default=math.inf)
    alike = [pair for pair in found if pair[1].revolution_cost <= ALIKE_COSTS * least]
    return min(alike, key=lambda pair: pair[1].worst(*quantities), default=None)


def cheapest_words(studies: Sequence[SpatialStudy]) -> str:
    """Say which presets are the cheapest, and on how many machines: by the position alone, and by all quantities."""
    said = []
    for what, quantities in COMPARED.items():
        for bar in BARS:
            found = Counter[str]()
            for study in studies:
                cheapest = cheapest_run(study, bar, quantities)
                found["none" if cheapest is None else " ".join(engine_and_preset(cheapest[0]))] += 1
            words = [f"{name} on {count}" for name, count in found.most_common()]
            said.append(f"{what} within {numbers.quantity(bar)}: {join_in_sentence(words)}")
    return f"Cheapest, of {len(studies)} machines, for {'; '.join(said)}."


def cheapest_table(studies: Sequence[SpatialStudy]) -> Table:
    """Return for each machine the cheapest runs within some errors: of the position, and of all three quantities."""
    headings = [f"{what} {numbers.quantity(bar)}" for what in COMPARED for bar in BARS]
    rows = []
    for study in studies:
        cells = []
        for quantities in COMPARED.values():
            for bar in BARS:
                found = cheapest_run(study, bar, quantities)
                words = numbers.MISSING
                if found is not None:
                    words = f"{' '.join(engine_and_preset(found[0]))} ({found[1].steps_per_rev})"
                cells.append(words)
        rows.append((study.name, *cells))
    return table(("machine", *headings), rows, title="cheapest within an error, and its steps a revolution")


# -- the report ------------------------------------------------------------------------------------------------------


def figures(studies: Sequence[SpatialStudy]) -> list[Figure]:
    """Return the figure of error against cost of each machine with more than two runs of a preset."""
    from conrod.studies.space.charts import work_precision_figure

    return [
        Figure(
            f"{study.name}-space",
            f"Errors of {study.name} against the cost of a revolution, in each engine and preset",
            partial(work_precision_figure, study),
        )
        for study in studies
        if any(len(one.runs) > 2 for one in study.results) and any(one.completed for one in study.results)
    ]


def results_to_print(studies: Sequence[SpatialStudy]) -> Iterator[PrintedPart]:
    """Yield the finding, and a row for each machine, engine and preset."""
    yield finding(studies)
    yield verdicts_table(studies)
    run = studies[0].results[0]
    yield f"{run.steps_per_rev} steps in a revolution of the slowest drive, {run.revolutions} of them"
    yield from (f"{study.name}: {remark}" for study in studies for remark in study.remarks)


def _merge_results(before: SpatialStudy, new: SpatialStudy) -> SpatialStudy:
    """Keep the results of engines and presets that were not run again, as those of an engine whose runs are short."""
    again = {engine_and_preset(one) for one in new.results}
    kept = [one for one in before.results if engine_and_preset(one) not in again]
    if before.file != new.file or {one.revolutions for one in (*kept, *new.results)} != {new.results[0].revolutions}:
        return new
    return replace(new, results=(*kept, *new.results))


def _summary(study: SpatialStudy) -> dict[str, Any]:
    results = [
        {
            "engine": one.engine,
            "engine_version": one.engine_version,
            "preset": one.preset,
            "outcome": one.outcome,
            "reason": one.reason,
            "passed": one.passed,
            **{name: one.largest(name) for name in one.quantities},
        }
        for one in study.results
    ]
    return {"passed": study.passed, "verdict": finding([study]), "results": results}


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say how far off each engine's presets are at most, on all machines of a report."""
    worst = dict[tuple[str, str], float]()
    for entry in entries.values():
        for one in entry["summary"]["results"]:
            if one["position"] is not None:
                name = (one["engine"], one["preset"])
                worst[name] = max(worst.get(name, 0.0), one["position"])
    within = [f"{' '.join(name)} {numbers.measured_text(worst[name])}" for name in sorted(worst, key=worst.__getitem__)]
    said = f"Largest position errors over L on {len(entries)} machines in space"
    return f"{said}: {join_in_sentence(within)}." if within else ""


SPACE_REPORT = Kind(
    name="space",
    findings=SpatialStudy,
    title=lambda study: study.title,
    summary=_summary,
    printed=results_to_print,
    verdict=verdict,
    headline=headline,
    results="space.json",
    index_file="space.md",
    suffix="-space",
    merge=_merge_results,
    digits=2,
)
