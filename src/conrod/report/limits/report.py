"""The report of limits: a page for each machine, and an index."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.limits.boundary_chart import boundary_chart, has_boundaries, preset_lanes
from conrod.report.limits.error_chart import POSITION, TORQUE, error_chart
from conrod.report.limits.files import rounded
from conrod.report.limits.follower import flight_table, float_figure, onset_table
from conrod.report.limits.long_runs import long_run_figure, long_run_table
from conrod.report.limits.map_figure import map_figure
from conrod.report.limits.tables import (
    boundaries_table,
    determinism_table,
    maps_table,
    needs_table,
    reference_note,
    refusals,
    steps_table,
    torque_notes,
    undetected_table,
)
from conrod.report.limits.words import by_axis, elsewhere_words, findings, undetected_words
from conrod.report.table import Table, table
from conrod.report.template import rendered
from conrod.studies.limits.axes import AXES, Scale
from conrod.studies.limits.grade import Level
from conrod.studies.limits.maps import LimitMap
from conrod.studies.limits.results import LimitStudy, Walk

Walks = Sequence[Walk]


# -- figures ---------------------------------------------------------------------------------------------------------


def axis_figure(axis: str, walks: Walks) -> Figure | None:
    """Return the figure of an axis: boundaries, or the errors at listed values; None where nothing was walked."""
    name, title = f"{walks[0].scene}-{axis}", AXES[axis].title
    if AXES[axis].scale is Scale.LISTED:
        measured = any(probe.position is not None for walk in walks for probe in walk.probes)
        return Figure(name, f"{title}: errors", partial(error_chart, walks)) if measured else None
    if not any(map(has_boundaries, walks)):
        return None
    alt = f"{title}: how far each engine and preset can be relied on"
    return Figure(name, alt, lambda: boundary_chart(preset_lanes(walks)))


def errors_figure(axis: str, walks: Walks) -> Figure | None:
    """Return the errors along an axis where they show more than its boundaries."""
    if axis not in ("nearness", "regularisation") or not any(p.position for walk in walks for p in walk.probes):
        return None
    name, alt = f"{walks[0].scene}-{axis}-errors", f"{AXES[axis].title}: errors"
    if axis == "nearness":
        return Figure(name, alt, partial(error_chart, walks, reference=True))
    return Figure(name, alt, partial(error_chart, walks, (TORQUE, POSITION)))


def map_of(found: LimitMap) -> Figure:
    """Return the figure of a map."""
    name = f"{found.scene}-{found.x_axis}-x-{found.y_axis}-{found.engine}-{found.preset}"
    title = f"{AXES[found.x_axis].title} x {AXES[found.y_axis].title}, {engine_title(found.engine)} {found.preset}"
    return Figure(name, title, partial(map_figure, found))


def needs_figure(study: LimitStudy) -> Figure | None:
    """Return the mass ratio that holds with numbers of iterations that stay."""
    if not any(has_boundaries(walk) for need in study.needs for walk in need.walks):
        return None
    lanes = {
        f"{engine_title(n.engine)} {n.preset}, {n.iterations} iteration{'s' * (n.iterations > 1)}": n.walks
        for n in study.needs
    }
    alt = "Mass ratio that holds with a fixed number of iterations"
    return Figure(f"{study.name}-mass-ratio-iterations", alt, lambda: boundary_chart(lanes))


def follower_figure(study: LimitStudy) -> Figure | None:
    """Return the flights of a follower."""
    if not any(found.curve for found in study.floats):
        return None
    alt = "Flight of the follower, how deep it sinks, and from which speed it flies"
    return Figure(f"{study.name}-follower-float", alt, partial(float_figure, study.floats))


def long_figure(study: LimitStudy) -> Figure | None:
    """Return loop error and phase of the long runs."""
    if not any(run.marks for run in study.long_runs):
        return None
    alt = "Loop error and phase against revolutions"
    return Figure(f"{study.name}-long-runs", alt, partial(long_run_figure, study.long_runs))


# -- pages -----------------------------------------------------------------------------------------------------------


def _page(part: Part[LimitStudy]) -> Page:
    study = part.findings
    walked = {axis: walks for axis, walks in by_axis(study.walks).items() if any(w.probes for w in walks)}
    sections = [_section(axis, walks) for axis, walks in walked.items()]
    special = {"needs": needs_figure(study), "follower": follower_figure(study), "long_runs": long_figure(study)}
    maps = [map_of(found) for found in study.maps]
    shown = [figure for section in sections for figure in section["figures"]]
    text = rendered(
        "limits",
        study=study,
        versions=", ".join(f"{engine_title(name)} {version}" for name, version in study.engines.items()),
        commands=part.options.get("commands", {}).get(part.name, [part.command]),
        undetected=undetected_words(study.walks),
        elsewhere=elsewhere_words(study),
        findings=findings(study.walks),
        overview=shown[0] if shown else None,
        dangers=undetected_table(study.walks),
        sections=sections,
        maps=maps,
        maps_table=maps_table(study.maps),
        needs_table=needs_table(study.needs),
        onsets=onset_table(study.floats),
        flights=flight_table(study.floats),
        theory=next((found.theory * 30.0 / math.pi for found in study.floats if found.theory is not None), None),
        not_flown=[f"{engine_title(f.engine)} `{f.preset}`: {f.refusal}" for f in study.floats if f.refusal],
        same_again=determinism_table(study.determinism),
        long_table=long_run_table(study.long_runs),
        not_walked=[
            f"{AXES[axis].title}: {' '.join(refusals(walks))}"
            for axis, walks in by_axis(study.walks).items()
            if axis not in walked
        ],
        special=special,
    )
    return Page(text, (*shown, *maps, *(figure for figure in special.values() if figure)))


def _section(axis: str, walks: Walks) -> dict[str, Any]:
    return {
        "axis": axis,
        "title": AXES[axis].title,
        "listed": AXES[axis].listed,
        "figures": [figure for make in (axis_figure, errors_figure) if (figure := make(axis, walks))],
        "boundaries": boundaries_table(walks),
        "again": any(boundary.good_again for walk in walks for boundary in walk.boundaries),
        "reference": reference_note(walks),
        "torques": torque_notes(walks) if axis == "regularisation" else [],
        "refusals": refusals(walks),
    }


def _index(index: Index[LimitStudy]) -> Page:
    studies = [index.findings(name) for name in index.entries]
    walks = [walk for study in studies for walk in study.walks]
    figures = [figure for study in studies if (figure := _steps_figure(study))]
    text = rendered(
        "limits-index",
        entries=index.entries,
        undetected=undetected_words(walks),
        in_one_piece=[
            f"{study.name}, {row[0]}: {row[2]} (up to {row[3]} L)"
            for study in studies
            for row in undetected_table(study.walks).rows
            if str(row[1]).startswith(Level.WRONG.slug)
        ],
        repeated=_repeated(studies),
        long_runs=_long_runs(studies),
        onsets=_onsets(studies),
        figure=figures[0] if figures else None,
        steps=steps_table(walks),
        levels=list(Level),
        versions=_versions(index),
        origin=index.origin,
    )
    return Page(text, tuple(figures[:1]))


def _versions(index: Index[LimitStudy]) -> Table:
    """All versions of conrod that occur, and the environment of what was found last."""
    conrod = "; ".join(sorted({entry["conrod"] for entry in index.entries.values()}))
    return table(["what", "which"], [["conrod", conrod], *map(list, index.environment.items())])


def _steps_figure(study: LimitStudy) -> Figure | None:
    walks = [walk for walk in study.walks if walk.axis == "steps"]
    return axis_figure("steps", walks) if walks else None


def _repeated(studies: Sequence[LimitStudy]) -> str:
    """Number of repeated runs that were identical to the last bit, and which were not."""
    found = [one for study in studies for one in study.determinism if one.identical]
    other = [f"{f.scene} {engine_title(f.engine)} {f.preset}" for f in found if not all(f.identical.values())]
    if not found:
        return ""
    return f"{len(found) - len(other)} of {len(found)}" + (f"; not {', '.join(other)}" if other else "")


def _long_runs(studies: Sequence[LimitStudy]) -> str:
    """Number of long runs that completed, and how the others ended."""
    runs = [run for study in studies for run in study.long_runs]
    if not runs:
        return ""
    ended = [f"{r.scene} {engine_title(r.engine)} {r.preset} {r.outcome}" for r in runs if r.outcome != "completed"]
    longest = numbers.quantity(max(run.revolutions for run in runs))
    kept = f"{len(runs) - len(ended)} of {len(runs)} completed, the longest over {longest} revolutions"
    return kept + (f"; {', '.join(ended)}" if ended else "")


def _onsets(studies: Sequence[LimitStudy]) -> str:
    """Onsets of a follower's flight over the theory's, where the contact is hard enough to show them."""
    floats = [found for study in studies for found in study.floats if found.fit and found.onset is not None]
    return ", ".join(f"{found.onset:.4f} ({engine_title(found.engine)} {found.preset})" for found in floats)


def _summary(study: LimitStudy) -> dict[str, Any]:
    return {
        "undetected": sum(probe.undetected for walk in study.walks for probe in walk.probes),
        "runs": sum(len(walk.probes) for walk in study.walks),
        "text": undetected_words(study.walks),
        "findings": findings(study.walks),
    }


KIND = Kind(
    name="limits",
    findings=LimitStudy,
    title=lambda study: study.title,
    summary=_summary,
    page=_page,
    index=_index,
    kept=rounded,
)
