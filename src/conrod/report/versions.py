"""The report on the releases of an engine: what changed when, on the console and as pages."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from conrod.engines.registry import look_of
from conrod.report import numbers
from conrod.report.charts.releases import releases_figure
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.table import Cell, Table, Toned, table
from conrod.report.template import rendered
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.versions.findings import Change, History, VersionStudy

UNEXPLAINED = "unexplained"
COMPLETED = "completed"

# -- words -------------------------------------------------------------------------------------------------------------


def unsupported_lines(study: VersionStudy) -> list[str]:
    """A line for each release that could not be had."""
    return [f"{study.engine} {one.version} unsupported: {one.unsupported}" for one in study.releases if one.unsupported]


def size_words(change: Change) -> str:
    """How a run changed: its outcome, the sizes of what is above rounding, or that last bits did."""
    if change.outcomes[0] != change.outcomes[1]:
        return " -> ".join(change.outcomes)
    if not change.size:
        return "other bits"
    above = {q: size for q, size in change.size.items() if size > numbers.ROUNDING}
    if not above:
        return "outputs alone, last bits" if change.in_outputs_alone else "last bits"
    return ", ".join(f"{quantity} {numbers.measured(size)}" for quantity, size in above.items())


def explanation(change: Change) -> Cell:
    """What the changelog says that can be the cause."""
    return " ".join(change.explained) if change.explained else Toned(UNEXPLAINED, "odd")


# -- tables ------------------------------------------------------------------------------------------------------------


def changes_table(study: VersionStudy) -> Table:
    """A row for each change of a run from one release to the next."""
    rows = [
        (version, one.scene, one.settings, size_words(change), *_errors(one, change), explanation(change))
        for version in study.measured
        for one, change in study.changes_at(version)
    ]
    title = f"{look_of(study.engine).title}: what changed from the release before, over L, ω L, ω² L"
    headings = ("release", "scene", "settings", "motion changed by", "error before", "after", "its changelog")
    return table(headings, rows, title=title, names=2)


def _errors(one: History, change: Change) -> tuple[str, str]:
    """The position error before and after."""
    runs = {run.version: run for run in one.runs}
    before, after = runs[change.before], runs[change.version]
    return tuple(numbers.measured(run.errors["position"]) for run in (before, after))  # type: ignore[return-value]


KIND = Kind(
    name="versions",
    findings=VersionStudy,
    title=lambda study: look_of(study.engine).title,
    summary=lambda study: {},
    page=lambda part: Page(""),
)
