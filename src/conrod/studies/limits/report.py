"""The report on limits: a page for each machine, and an index."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import Any

from matplotlib.figure import Figure as Drawing

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure, Spot, spots_in_axes
from conrod.report.kind import Index, Kind
from conrod.report.results import distrust_lines, distrust_words
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart
from conrod.studies.limits import records, tables
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.charts import axis_label, axis_places, error_chart
from conrod.studies.limits.map_figure import map_figure
from conrod.studies.limits.maps import LimitMap
from conrod.studies.limits.results import STUDY_PARTS, LimitStudy, Walk

# Given values, which a folder keeps in all digits; other fractions were measured.
EXACT_FIELDS = ("value", "last_good", "first_bad", "good_again", "x", "y", "speed", "held", "flown")
DIGITS_OF_FIELDS = dict.fromkeys(EXACT_FIELDS)

MAX_VALUES_WITHOUT_FIGURE = 2  # of an axis; the table suffices
Walks = Sequence[Walk]


# -- figures ---------------------------------------------------------------------------------------------------------


def axis_figure(axis: str, walks: Walks) -> Figure | None:
    """Return the figure of errors along an axis; None without errors, or for only two values."""
    no_errors = all(probe.position is None for walk in walks for probe in walk.probes)
    if no_errors or max(len(walk.probes) for walk in walks) <= MAX_VALUES_WITHOUT_FIGURE:
        return None
    return Figure(f"{walks[0].scene}-{axis}", f"{AXES[axis].title}: errors", partial(error_chart, walks))


def figure_of_map(found: LimitMap) -> Figure:
    """Return the figure of a map of limits."""
    name = f"{found.scene}-{found.x_axis}-x-{found.y_axis}-{found.engine}-{found.preset}"
    title = f"{AXES[found.x_axis].title} x {AXES[found.y_axis].title}, {engine_title(found.engine)} {found.preset}"
    return Figure(name, title, partial(map_figure, found), partial(_map_spots, found))


def _map_spots(one: LimitMap, drawn: Drawing) -> list[Spot]:
    """Return a spot with the outcome for each run of a map."""
    across, upwards = AXES[one.x_axis], AXES[one.y_axis]
    x, y = axis_places(across, one.x), axis_places(upwards, one.y)
    places = []
    for run in one.runs:
        where = f"{one.x[run.i]:.0f} {across.label}, {axis_label(upwards)} {numbers.quantity(y[run.j])}"
        noticed = "" if run.level in records.GOOD_LEVELS else ", undetected" if run.undetected else ", detected"
        places.append((x[run.i], y[run.j], f"{where}, {run.level}, {run.outcome}{noticed}"))
    return spots_in_axes(drawn, drawn.axes[0], places)


def axis_figures(study: LimitStudy) -> list[Figure]:
    """Return a figure of errors for each axis that was walked."""
    walked = [(axis, [walk for walk in study.walks if walk.axis == axis and walk.probes]) for axis in AXES]
    return [figure for axis, walks in walked if (figure := axis_figure(axis, walks))]


def map_figures(study: LimitStudy) -> list[Figure]:
    """Return the figures of all maps of a study."""
    return [figure_of_map(found) for found in study.maps]


def first_figure(studies: Iterable[LimitStudy]) -> Figure | None:
    """Return the figure of errors along the axis of steps, of the first machine with such runs."""
    steps = [walk for study in studies for walk in study.walks if walk.axis == "steps" and walk.probes]
    return axis_figure("steps", [walk for walk in steps if walk.scene == steps[0].scene]) if steps else None


def machines_table(index: Index[LimitStudy]) -> Table:
    """Return a row for each machine: undetected runs, and the float speed of its follower."""
    rows = []
    for name, study in index.studies.items():
        onsets = [
            f"{f.onset:.4f} ({' '.join(tables.engine_and_preset(f))})" for f in study.floats if f.onset is not None
        ]
        title = f"[{name}]({index.entries[name]['page']}): {index.entries[name]['title']}"
        rows.append((title, tables.undetected_words(study.walks), ", ".join(onsets) or numbers.MISSING))
    return table(("machine", "wrong and undetected", "follower lets go at, over theory"), rows)


def _summary(study: LimitStudy) -> dict[str, Any]:
    return {
        "undetected": sum(probe.undetected for walk in study.walks for probe in walk.probes),
        "runs": sum(len(walk.probes) for walk in study.walks),
        "text": tables.undetected_words(study.walks),
    }


# -- merged with what a folder already holds --------------------------------------------------------------------------

TOPIC_FIELDS = ("engine", "preset", "axis", "x_axis", "y_axis")  # which tell the parts of a study apart


def merge_studies(earlier: LimitStudy, new: LimitStudy) -> LimitStudy:
    """Add a new study's parts to an earlier study, replacing parts on the same topic.

    Earlier parts with other parameters or another version of an engine are dropped: no run would reproduce them.
    """
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    changed = {name for name, version in new.engines.items() if earlier.engines.get(name, version) != version}
    engines = {**earlier.engines, **new.engines}
    parts: dict[str, Any] = {}
    doubts = [new.distrust]
    for name in STUDY_PARTS:
        replacing = _by_topic(getattr(new, name))
        kept = _by_topic([part for part in getattr(earlier, name) if part.engine not in changed])
        # A new part takes the place of the earlier one on its topic.
        parts[name] = tuple(chain.from_iterable((kept | replacing).values()))
        doubts += [earlier.distrust] if kept.keys() - replacing.keys() else []
    order = list(AXES), list(engines)
    walks = sorted(parts["walks"], key=lambda walk: (order[0].index(walk.axis), order[1].index(walk.engine)))
    distrust = "; ".join(dict.fromkeys(filter(None, doubts)))
    return replace(new, **{**parts, "engines": engines, "walks": tuple(walks)}, distrust=distrust)


def _by_topic(parts: Sequence[Any]) -> dict[tuple[Any, ...], list[Any]]:
    found: dict[tuple[Any, ...], list[Any]] = {}
    for part in parts:
        found.setdefault(tuple(getattr(part, name, None) for name in TOPIC_FIELDS), []).append(part)
    return found


def results_to_print(studies: Sequence[LimitStudy]) -> Iterator[PrintedPart]:
    """Yield how far each engine and preset can be relied on, and how it fails beyond."""
    yield from distrust_lines(studies)
    for study in studies:
        title = f"{study.name}: holds up to (undetected: finite numbers, no warning, wrong motion)"
        yield tables.limits_table(study.walks, title)
        yield f"10 % and 1 % are shares of the travel L{numbers.lengths(study.lengths)}"
        yield from (f"Not walked: {line}" for line in tables.refusal_lines(study.walks))


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say how many runs were wrong without any warning."""
    wrong, runs = (sum(entry["summary"][key] for entry in entries.values()) for key in ("undetected", "runs"))
    return f"{wrong} of {runs} runs were wrong without any warning."


LIMITS_REPORT = Kind(
    name="limits",
    findings=LimitStudy,
    title=lambda study: study.title,
    summary=_summary,
    printed=results_to_print,
    verdict=lambda study: f"{study.name}: {distrust_words(study) or tables.undetected_words(study.walks)}",
    headline=headline,
    merge=merge_studies,
    digits=4,
    digits_of=DIGITS_OF_FIELDS,
)
