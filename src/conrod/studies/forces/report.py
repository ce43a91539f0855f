"""The report on forces: drive torque, joint reactions and contact forces of engines against the exact ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.kind import Kind
from conrod.report.results import (
    distrusted_scenes,
    engine_and_preset,
    results_table,
    scene_summary,
    scene_verdict,
    verdict_cell,
)
from conrod.report.table import Cell, Table, table
from conrod.report.terminal import PrintedPart
from conrod.scenes import Scene
from conrod.studies.forces.results import GROUPS, ForceResult, ForceStudy, is_moment

TITLE = "largest error over the run, by the exact peak; of contact rms between arc joints, of means of 16 steps"


# -- words -----------------------------------------------------------------------------------------------------------


def reasons(results: Iterable[ForceResult]) -> list[str]:
    """Reasons of the tolerances, each once, with engine and preset."""
    given = [(r.engine, r.preset, r.reason_of_tolerance) for r in results if r.reason_of_tolerance]
    return [f"{engine_title(engine)} {preset}, {why}" for engine, preset, why in dict.fromkeys(given)]


def lacking(result: ForceResult) -> list[str]:
    """List the quantities of a completed run that the engine does not report, by reason."""
    reasons: dict[str, dict[str, None]] = {}
    for name, reason in (result.unsupported or {}).items() if result.completed else ():
        reasons.setdefault(reason, {})[name.rpartition(".")[0] or name] = None
    return [f"unsupported: {', '.join(names)} ({reason})" for reason, names in reasons.items()]


# -- tables ----------------------------------------------------------------------------------------------------------


def verdicts_table(found: Sequence[ForceStudy]) -> Table:
    """A row for each result: largest errors, observed orders, verdict."""
    groups = [g for g in GROUPS if any(g in r.groups for one in found for r in one.results)]
    columns: dict[str, Callable[[ForceResult], str]] = {"steps/rev": lambda r: str(r.steps_per_revolution)}
    columns |= {g: lambda r, g=g: numbers.measured_text(r.judged_error(g)) for g in groups}  # type: ignore[misc]
    columns |= {f"order of {g}": lambda r, g=g: numbers.order((r.order or {}).get(g)) for g in groups}  # type: ignore[misc]

    def verdict(result: ForceResult, scene: Scene) -> Cell:
        return verdict_cell(result, scene, "".join(f"; {words}" for words in lacking(result)))

    return results_table(found, columns, TITLE, verdict)


def errors_tables(study: ForceStudy) -> list[Table]:
    """Return a table for each group of quantities, with max and rms of each run."""
    return [_errors_table([r for r in study.results if r.errors], group) for group in GROUPS]


def _errors_table(results: Sequence[ForceResult], group: str) -> Table:
    names = next((r.groups[group] for r in results if group in r.groups), ())
    rows = []
    for name in names:
        some = [r.errors[name] for r in results if r.errors and name in r.errors]
        if not some:
            rows.append([f"`{name}`", numbers.MISSING, *(["unsupported"] * len(results))])
            continue
        unit = "N m" if is_moment(name) else "N"
        peak = f"{numbers.quantity(some[0].peak)} {unit}" + ("" if some[0].own_peak else " (of others)")
        rows.append([f"`{name}`", peak, *(_error_cell(r, name) for r in results)])
    return table(["quantity", "exact peak", *(f"{' '.join(engine_and_preset(r))}: max, rms" for r in results)], rows)


def _error_cell(result: ForceResult, name: str) -> str:
    one = (result.errors or {}).get(name)
    if one is None:
        return "unsupported"
    between = "" if one.between is None else f"; {numbers.measured_text(one.between)} between arc joints"
    return f"{numbers.measured_text(one.max)}, {numbers.measured_text(one.rms)}{between}"


# -- the report ------------------------------------------------------------------------------------------------------


def _largest_errors(result: ForceResult) -> dict[str, Any]:
    return {"largest": {group: result.judged_error(group) for group in result.groups}}


def results_to_print(found: Sequence[ForceStudy]) -> Iterator[PrintedPart]:
    """Yield the errors of forces, observed orders, verdicts and reasons of tolerances."""
    yield from distrusted_scenes(found)
    yield verdicts_table(found)
    yield from (f"tolerance: {reason}" for reason in reasons(result for one in found for result in one.results))


FORCES_REPORT = Kind(
    name="forces",
    findings=ForceStudy,
    title=lambda found: found.scene.title,
    summary=partial(scene_summary, more=_largest_errors),
    printed=results_to_print,
    verdict=scene_verdict,
    results="forces.json",
    index_file="forces.md",
    suffix="-forces",
    digits=6,
)
