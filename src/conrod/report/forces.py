"""The report on forces: drive torque, joint reactions and contact forces of engines against the exact ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.charts.torque import torque_figure
from conrod.report.figure import Figure
from conrod.report.force_words import (
    change_words,
    hidden_words,
    property_words,
    stamps_words,
    tolerance_reasons,
    unsupported_words,
    verdict_words,
)
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.table import Cell, Table, Toned, table
from conrod.report.template import rendered
from conrod.scenes import Scene
from conrod.studies.forces.exact import GROUPS, is_moment
from conrod.studies.forces.results import ForceResult, ForceStudy
from conrod.studies.forces.seen import Effect

TITLE = "largest error over the run, by the exact peak; of contact rms between arc joints, of means of 16 steps"


@dataclass(frozen=True)
class ForceFindings:
    """All results of one scene, and what they can show of a wrong mass.

    Attributes:
        effects: of each property of each body on the quantities.
        hidden: changes of several properties together, by "body.property", that none of the quantities shows.
    """

    name: str
    scene: Scene
    results: tuple[ForceResult, ...]
    effects: tuple[Effect, ...]
    hidden: tuple[Mapping[str, float], ...]

    @property
    def passed(self) -> bool:
        """No judged result is out of tolerance."""
        return all(result.passed is not False for result in self.results)


def force_findings(study: ForceStudy) -> ForceFindings:
    """The findings of a study."""
    hidden = tuple({".".join(of): change for of, change in blind.shares.items()} for blind in study.seen.blind)
    return ForceFindings(study.name, study.scene, study.results, study.seen.effects, hidden)


# -- tables ----------------------------------------------------------------------------------------------------------


def verdicts_table(found: Sequence[ForceFindings], order: Callable[[float | None], str] = numbers.order) -> Table:
    """A row for each result: largest errors, observed orders as asked for, verdict."""
    groups = _groups(r for one in found for r in one.results)
    right = ("steps/rev", *groups, *(f"order of {g}" for g in groups))
    rows = [
        (
            *(one.name, *_name(r), str(r.steps_per_revolution)),
            *(numbers.measured(r.judged(g)) for g in groups),
            *(order((r.order or {}).get(g)) for g in groups),
            _verdict(r),
        )
        for one in found
        for r in one.results
    ]
    return table(("scene", "engine", "preset", *right, "verdict"), rows, right, TITLE)


def _verdict(result: ForceResult) -> Cell:
    words = verdict_words(result)
    if result.outcome != "completed":
        return Toned(words, "odd")
    return words if result.passed is None else Toned(words, "good" if result.passed else "bad")


def _name(result: ForceResult) -> tuple[str, str]:
    return engine_title(result.engine), result.preset


def _groups(results: Iterable[ForceResult]) -> list[str]:
    there = {group for result in results for group in result.groups}
    return [g for g in GROUPS if g in there]


def _errors_table(results: Sequence[ForceResult], group: str) -> Table:
    """A row for each quantity, joint by joint, with max and rms of each run."""
    names = next((r.groups[group] for r in results if group in r.groups), ())
    rows = []
    for name in names:
        some = [r.errors[name] for r in results if r.errors and name in r.errors]
        if not some:
            rows.append([f"`{name}`", numbers.MISSING, *(["unsupported"] * len(results))])
            continue
        unit = "N m" if is_moment(name) else "N"
        peak = f"{numbers.quantity(some[0].peak)} {unit}" + ("" if some[0].own_peak else " (of others)")
        rows.append([f"`{name}`", peak, *(_sizes(r, name) for r in results)])
    return table(["quantity", "exact peak", *(f"{' '.join(_name(r))}: max, rms" for r in results)], rows)


def _sizes(result: ForceResult, name: str) -> str:
    one = (result.errors or {}).get(name)
    if one is None:
        return "unsupported"
    between = "" if one.between is None else f"; {numbers.measured(one.between)} between arc joints"
    return f"{numbers.measured(one.max)}, {numbers.measured(one.rms)}{between}"


def _orders_table(results: Sequence[ForceResult]) -> Table:
    runs = [r for r in results if r.refinement]
    steps = sorted({p.steps_per_revolution for r in runs for p in r.refinement})
    rows = []
    for run in runs:
        by_steps = {p.steps_per_revolution: p for p in run.refinement}
        for group, names in run.groups.items():
            cells = []
            for n in steps:
                point = by_steps.get(n)
                sizes = [] if point is None else [point.errors[k] for k in names if k in point.errors]
                ended = "" if point is None or point.outcome == "completed" else f" ({point.outcome})"
                cells.append(numbers.measured(max(sizes) if sizes else None) + ended)
            rows.append([*_name(run), group, *cells, numbers.order((run.order or {}).get(group))])
    return table(["engine", "preset", "largest of", *(f"N = {n}" for n in steps), "order"], rows)


def _masses_table(found: ForceFindings) -> Table:
    """A row for each property of each body: what shows it most, and how many such changes errors look like."""
    judged = [r for r in found.results if r.likeness is not None and r.tolerance]
    rows = []
    for effect in found.effects:
        name = f"{effect.body}.{effect.quality}"
        most = "none" if effect.unseen else f"`{effect.quantity}`"
        by = numbers.measured(None if effect.unseen else effect.effect)
        changed = (effect.body, property_words(effect.quality), change_words(effect.quality, effect.change))
        rows.append([*changed, most, by, *(numbers.measured((r.likeness or {}).get(name)) for r in judged)])
    head = ["body", "property", "change", "shown most by", "by, of its peak", *(" ".join(_name(r)) for r in judged)]
    return table(head, rows)


# -- the report ------------------------------------------------------------------------------------------------------


def _figures(found: ForceFindings) -> tuple[Figure, ...]:
    if all(r.curve is None for r in found.results):
        return ()
    alt = f"Drive torque of {found.name} over the crank angle, exact and by engines, and its error"
    return (Figure(f"{found.name}-torque", alt, partial(torque_figure, found.results)),)


def _page(part: Part[ForceFindings]) -> Page:
    found, figures = part.findings, _figures(part.findings)
    measured = [r for r in found.results if r.errors]
    lacking = [
        f"{' '.join(_name(r))}: {words}"
        for r in found.results
        if r.outcome == "completed"
        for words in unsupported_words(r)
    ]
    text = rendered(
        "forces", found=found, figures=figures, command=part.command, verdicts=verdicts_table([found]),
        versions=", ".join(dict.fromkeys(f"{engine_title(r.engine)} {r.engine_version}" for r in found.results)),
        reasons=tolerance_reasons(found.results), lacking=lacking, orders=_orders_table(measured),
        contact=bool(found.scene.kinematics.mechanism.cam_contacts),
        errors=[_errors_table(measured, group) for group in GROUPS],
        stamps=table(["engine", "preset", "values"], [[*_name(r), stamps_words(r.stamps)] for r in measured]),
        masses=_masses_table(found), hidden=hidden_words(found.hidden),
    )  # fmt: skip
    return Page(text, figures)


def _summary(found: ForceFindings) -> dict[str, Any]:
    results = [
        {
            "engine": r.engine,
            "preset": r.preset,
            "verdict": verdict_words(r),
            "passed": r.passed,
            "largest": {group: r.judged(group) for group in r.groups},
        }
        for r in found.results
    ]
    return {"passed": found.passed, "results": results}


def _index(index: Index[ForceFindings]) -> Page:
    found = [index.findings(name) for name in index.entries]
    failed = [one.name for one in found if not one.passed]
    figures = [figure for one in found for figure in _figures(one)]
    text = rendered(
        "forces-index", entries=index.entries, verdicts=verdicts_table(found), failed=failed, figures=figures[:1],
        origin=index.origin,
    )  # fmt: skip
    return Page(text)


KIND = Kind(
    name="forces",
    findings=ForceFindings,
    title=lambda found: found.scene.title,
    summary=_summary,
    page=_page,
    index=_index,
    results="forces.json",
    index_file="forces.md",
    suffix="-forces",
    digits=6,
)
