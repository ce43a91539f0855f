"""The report on the releases of an engine: which release changed which run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import matplotlib.figure
from matplotlib.patches import Patch, Rectangle

from conrod.engines import engine_style
from conrod.report import numbers
from conrod.report.charts.canvas import add_legend_above
from conrod.report.figure import Figure
from conrod.report.kind import Kind
from conrod.report.results import distrust_lines, distrust_words
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, table
from conrod.report.terminal import PrintedPart
from conrod.studies.versions.study import ReleaseChange, ReleaseCost, VersionStudy

# -- words -------------------------------------------------------------------------------------------------------------


def unsupported_lines(study: VersionStudy) -> list[str]:
    """List the releases that could not be installed or run, with the reason."""
    return [f"{study.engine} {version} unsupported: {why}" for version, why in study.unsupported.items()]


def size_words(change: ReleaseChange) -> str:
    """Say how a run changed: its outcome, differences above rounding, or last digits only."""
    if change.outcomes[0] != change.outcomes[1]:
        return f"{change.outcomes[0]}, now {change.outcomes[1]}"
    if not change.size:
        return f"other bits, {change.outcomes[1]}"
    if not change.last_digits:
        above = {q: size for q, size in change.size.items() if size > numbers.ROUNDING}
        return ", ".join(f"{quantity} {numbers.measured_text(size)}" for quantity, size in above.items())
    return "last digits"


def headline(study: VersionStudy) -> str:
    """Say how many runs changed, how many without explanation, and which change is the largest."""
    changes = [(one, change) for version in study.measured for one, change in study.changes_at(version)]
    if not changes:
        return "No release changed a bit."
    unnamed = sum(not change.explained for _, change in changes)
    said = f"{len(changes)} changes of a run from one release to the next, {unnamed} of them unexplained"
    sized = [(one, change) for one, change in changes if change.size and not change.last_digits]
    if not sized:
        return f"{said}; none is more than last digits."
    one, change = max(sized, key=lambda each: each[1].size["position"])
    size = numbers.measured_text(change.size["position"])
    return f"{said}; the largest came with {change.version} ({one.scene}, {one.settings}: position {size} of L)."


def changes_table(study: VersionStudy) -> Table:
    """Return a row for each changed run, with the changelog's entries that can explain it."""
    rows = []
    for version in study.measured:
        for one, change in study.changes_at(version):
            why: Cell = " ".join(change.explained) if change.explained else ColouredCell("unexplained", "odd")
            errors = map(numbers.measured_text, change.errors)
            rows.append((version, one.scene, one.settings, size_words(change), *errors, why))
    title = f"{engine_style(study.engine).title}: what changed from the release before, over L, ω L, ω² L"
    headings = ("release", "scene", "settings", "motion changed by", "position error before", "after", "its changelog")
    return table(headings, rows, title=title, names=3)


def costs_table(study: VersionStudy) -> Table:
    """Return a row for each timed run: its CPU time over that in the reference release, with the interval."""
    rows: list[tuple[Cell, ...]] = []
    for one in study.costs:
        run = (one.version, one.scene, one.settings)
        if one.timing is None or one.noise is None:
            rows.append((*run, "n/a", "", f"not timed: {one.reason}"))
            continue
        noise = f"{one.noise.low:.2f} to {one.noise.high:.2f}"
        rows.append(
            (*run, f"{one.timing.ratio:.2f} ({one.timing.low:.2f} to {one.timing.high:.2f})", noise, _cost_cell(one))
        )
    title = f"{engine_style(study.engine).title}: CPU time of a step over that with {study.reference}"
    return table(
        ("release", "scene", "settings", "ratio", f"{study.reference} twice", VERDICT), rows, title=title, names=3
    )


def _cost_cell(cost: ReleaseCost) -> Cell:
    match cost.word:
        case "slower":
            return ColouredCell("slower", "odd")
        case "faster":
            return ColouredCell("faster", "good")
        case word:
            return word


def costs_words(study: VersionStudy) -> str:
    """Say how many runs are slower and faster than with the reference release; empty where none was timed."""
    timed = [one for one in study.costs if one.timing is not None]
    if not timed:
        return ""
    slower, faster = (sum(one.word == word for one in timed) for word in ("slower", "faster"))
    counts = f"{slower} slower, {faster} faster"
    return f"Of {len(timed)} timed runs {counts} than with {study.reference}; all others are within the spread."


# -- figure ------------------------------------------------------------------------------------------------------------

ROW, COLUMN, LEFT, MARGINS = 0.19, 0.27, 2.7, 1.2  # [inch]
SAME_BITS_COLOUR, OTHER_OUTCOME_COLOUR = "#f4f4f4", "#D55E00"
# Upper bounds of a change of position over L: words and colour of changes up to there.
SIZE_COLOURS = {
    0.0: ("last digits, other bits", "#bcd6ea"),
    1e-6: ("position up to 1e-6 L", "#6baed6"),
    1e-3: ("up to 1e-3 L", "#2171b5"),
    float("inf"): ("more", "#08306b"),
}


def colour_of(change: ReleaseChange | None) -> str:
    """Return the colour of a run in a release by the size of its change."""
    if change is None:
        return SAME_BITS_COLOUR
    if change.outcomes[0] != change.outcomes[1]:
        return OTHER_OUTCOME_COLOUR
    size = 0.0 if change.last_digits else change.size["position"]
    return next(colour for top, (_, colour) in SIZE_COLOURS.items() if size <= top and (top or change.last_digits))


def releases_figure(study: VersionStudy) -> matplotlib.figure.Figure:
    """Draw the changes of runs, a row for each scene and settings, a column for each release."""
    versions, rows = study.measured[1:], study.histories
    size = LEFT + COLUMN * max(len(versions), 16), MARGINS + ROW * len(rows)
    figure = matplotlib.figure.Figure(figsize=size)
    axes = figure.subplots()
    for row, one in enumerate(rows):
        for column, version in enumerate(versions):
            axes.add_patch(Rectangle((column, row), 0.94, 0.94, color=colour_of(one.change_at(version)), linewidth=0))
    axes.set(xlim=(0, max(len(versions), 1)), ylim=(len(rows), 0))
    axes.set_xticks([k + 0.5 for k in range(len(versions))], list(versions), rotation=90, fontsize=7.5)
    axes.set_yticks([k + 0.5 for k in range(len(rows))], [f"{one.scene}, {one.settings}" for one in rows], fontsize=7.5)
    axes.grid(False)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    known = [("same bits", SAME_BITS_COLOUR), *SIZE_COLOURS.values(), ("another outcome", OTHER_OUTCOME_COLOUR)]
    add_legend_above(figure, [Patch(color=colour, label=label) for label, colour in known], 3, handlelength=2.0)
    return figure


# -- pages -------------------------------------------------------------------------------------------------------------


def figure(study: VersionStudy) -> Figure:
    """Return the figure of the runs that each release changed."""
    alt = f"Which runs changed with each release of {engine_style(study.engine).title}, and by how much"
    return Figure(study.engine, alt, partial(releases_figure, study))


def _summary(study: VersionStudy) -> dict[str, Any]:
    return {"headline": headline(study), "releases": list(study.measured)}


def results_to_print(studies: Sequence[VersionStudy]) -> Iterator[PrintedPart]:
    """Yield a table and a sentence on the changes, and the releases that were not run."""
    yield from distrust_lines(studies)
    for study in studies:
        yield changes_table(study)
        yield headline(study)
        if study.costs:
            yield costs_table(study)
            yield costs_words(study)
        yield from unsupported_lines(study)


def joined_headlines(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Join the headlines of all engines."""
    return " ".join(f"{entry['title']}: {entry['summary']['headline']}" for entry in entries.values())


VERSIONS_REPORT = Kind(
    name="versions",
    findings=VersionStudy,
    title=lambda study: engine_style(study.engine).title,
    summary=_summary,
    printed=results_to_print,
    verdict=lambda study: distrust_words(study) or headline(study),
    headline=joined_headlines,
    digits=4,
)
