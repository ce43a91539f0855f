"""The report of limits: a page for each machine, and an index."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.html.spots import Spot, spots_in
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.limits.error_chart import error_chart
from conrod.report.limits.follower import flight_table, float_figure, onset_table
from conrod.report.limits.map_figure import map_figure
from conrod.report.limits.marks import place
from conrod.report.limits.tables import (
    boundaries_table,
    by_axis,
    determinism_table,
    long_run_table,
    maps_table,
    reach_table,
    refusals,
    steps_table,
    undetected_table,
    undetected_words,
)
from conrod.report.table import Table, table, text_of
from conrod.report.template import rendered
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.maps import LimitMap, MapRun
from conrod.studies.limits.records import Level
from conrod.studies.limits.results import PARTS, LimitStudy, Walk

# In a folder all else that is a fraction was measured. Inputs are kept as they are; flights are compared with exact
# ones, and a small difference of the two is what counts.
INPUTS = ("value", "last_good", "first_bad", "good_again", "x", "y", "revolutions", "speed", "held", "flown")
DIGITS = {**dict.fromkeys(INPUTS, None), "exact": 8, "measured": 8}

Walks = Sequence[Walk]


# -- figures ---------------------------------------------------------------------------------------------------------


def axis_figure(axis: str, walks: Walks) -> Figure | None:
    """Return the errors along an axis; None where no run has any."""
    if all(probe.position is None for walk in walks for probe in walk.probes):
        return None
    return Figure(f"{walks[0].scene}-{axis}", f"{AXES[axis].title}: errors", partial(error_chart, walks))


def map_of(found: LimitMap) -> Figure:
    """Return the figure of a map."""
    name = f"{found.scene}-{found.x_axis}-x-{found.y_axis}-{found.engine}-{found.preset}"
    title = f"{AXES[found.x_axis].title} x {AXES[found.y_axis].title}, {engine_title(found.engine)} {found.preset}"
    return Figure(name, title, partial(map_figure, found))


def follower_figure(study: LimitStudy) -> Figure | None:
    """Return the flights of a follower; None where none was recorded."""
    if not any(one.curve for one in study.floats):
        return None
    alt = "Flight of the follower, and from which speed it flies"
    return Figure(f"{study.name}-follower-float", alt, partial(float_figure, study.floats))


def _spots(study: LimitStudy) -> dict[str, list[Spot]]:
    """What happened at each node of the maps that was run."""
    found = {}
    for one in study.maps:
        figure = map_figure(one)
        across, upwards = (AXES[name] for name in (one.x_axis, one.y_axis))
        places = [
            (place(across.scale, one.x[run.i]), place(upwards.scale, one.y[run.j]), _words(one, run))
            for run in one.runs
        ]
        found[map_of(one).name] = spots_in(figure, figure.axes[0], places)
    return found


def _words(one: LimitMap, run: MapRun) -> str:
    """A run of a map: where it is and what happened."""
    error = "" if run.error is None else f", error {numbers.measured(run.error)} L"
    end = f"{run.outcome}{', undetected' if run.undetected else ''}{error}"
    return f"{one.x[run.i]:.4g} steps, {AXES[one.y_axis].title.lower()} {one.y[run.j]:.3g}: {run.level}, {end}"


# -- pages -----------------------------------------------------------------------------------------------------------


def _page(part: Part[LimitStudy]) -> Page:
    study = part.findings
    walked = {axis: walks for axis, walks in by_axis(study.walks).items() if any(w.probes for w in walks)}
    sections = [_section(axis, walks) for axis, walks in walked.items()]
    follower = follower_figure(study)
    maps = [map_of(found) for found in study.maps]
    shown = [section["figure"] for section in sections if section["figure"]]
    text = rendered(
        "limits",
        study=study,
        versions=", ".join(f"{engine_title(name)} {version}" for name, version in study.engines.items()),
        command=part.command,
        undetected=undetected_words(study.walks),
        on_maps=[run.undetected for found in study.maps for run in found.runs],
        reach=reach_table(study.walks),
        overview=shown[0] if shown else None,
        dangers=undetected_table(study.walks),
        sections=sections,
        maps=maps,
        maps_table=maps_table(study.maps),
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
        follower=follower,
    )
    return Page(text, (*shown, *maps, *([follower] if follower else [])))


def _section(axis: str, walks: Walks) -> dict[str, Any]:
    return {
        "axis": AXES[axis],
        "figure": axis_figure(axis, walks),
        "boundaries": boundaries_table(walks),
        "refusals": refusals(walks),
    }


def _index(index: Index[LimitStudy]) -> Page:
    studies = {name: index.findings(name) for name in index.entries}
    walks = [walk for study in studies.values() for walk in study.walks]
    steps = [study for study in studies.values() if any(walk.axis == "steps" for walk in study.walks)]
    figure = axis_figure("steps", by_axis(steps[0].walks)["steps"]) if steps else None
    text = rendered(
        "limits-index",
        undetected=undetected_words(walks),
        machines=_machines_table(index.entries, studies),
        figure=figure,
        steps=steps_table(walks),
        levels=list(Level),
        versions=index.versions,
        origin=index.origin,
    )
    return Page(text, (figure,) if figure else ())


def _machines_table(entries: Mapping[str, Mapping[str, Any]], studies: Mapping[str, LimitStudy]) -> Table:
    """A row for each machine: what is undetected, repeated to the last bit, and completed of the long runs."""
    rows = []
    for name, study in studies.items():
        repeated = [all(one.identical.values()) for one in study.determinism if one.identical]
        completed = [run.outcome == "completed" for run in study.long_runs]
        onsets = [f for f in study.floats if f.fit and f.onset is not None]
        rows.append(
            (
                f"[{name}]({entries[name]['page']}): {entries[name]['title']}",
                entries[name]["summary"]["text"],
                f"{sum(repeated)} of {len(repeated)}" if repeated else numbers.MISSING,
                f"{sum(completed)} of {len(completed)}" if completed else numbers.MISSING,
                ", ".join(f"{f.onset:.4f} ({engine_title(f.engine)} {f.preset})" for f in onsets) or numbers.MISSING,
            )
        )
    head = ("machine", "wrong and undetected", "repeated to the last bit", "long runs completed")
    return table((*head, "follower lets go at, over theory"), rows)


def _summary(study: LimitStudy) -> dict[str, Any]:
    reach = reach_table(study.walks)
    return {
        "undetected": sum(probe.undetected for walk in study.walks for probe in walk.probes),
        "runs": sum(len(walk.probes) for walk in study.walks),
        "text": undetected_words(study.walks),
        "findings": [" | ".join(map(text_of, row)) for row in (reach.headings, *reach.rows)] if reach else [],
    }


# -- merged with what a folder already holds --------------------------------------------------------------------------

TOPIC = ("engine", "preset", "axis", "x_axis", "y_axis")  # of a part of a study, besides the scene


def merged(earlier: LimitStudy, new: LimitStudy) -> LimitStudy:
    """Return the earlier study with all that the new one studied again replaced, and with what it adds.

    Nothing is kept of another machine, or of another version of an engine: figures that no run would give again.
    """
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    changed = {name for name, version in new.engines.items() if earlier.engines.get(name, version) != version}
    engines = {**earlier.engines, **new.engines}
    parts: dict[str, Any] = {}
    for name in PARTS:
        kept = [part for part in getattr(earlier, name) if part.engine not in changed]
        # New parts stand where earlier ones about the same stood.
        parts[name] = tuple(chain.from_iterable((_by_topic(kept) | _by_topic(getattr(new, name))).values()))
    order = list(AXES), list(engines)
    walks = sorted(parts["walks"], key=lambda walk: (order[0].index(walk.axis), order[1].index(walk.engine)))
    return replace(new, **{**parts, "engines": engines, "walks": tuple(walks)})


def _by_topic(parts: Sequence[Any]) -> dict[tuple[Any, ...], list[Any]]:
    found: dict[tuple[Any, ...], list[Any]] = {}
    for part in parts:
        found.setdefault(tuple(getattr(part, name, None) for name in TOPIC), []).append(part)
    return found


KIND = Kind(
    name="limits",
    findings=LimitStudy,
    title=lambda study: study.title,
    summary=_summary,
    page=_page,
    spots=_spots,
    index=_index,
    merged=merged,
    digits=4,
    digits_of=DIGITS,
)
