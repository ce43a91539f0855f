"""Runs through the releases of an engine: which changed, and by how much."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from conrod.studies.versions.findings import Change, VersionStudy

ROW, COLUMN, LEFT, TOP, BOTTOM = 0.19, 0.27, 2.6, 0.45, 0.75  # [inch]
# Sizes of a change of position over L, each up to its number, from pale to dark; then what has no size.
SIZES = {0.0: "last digits, other bits", 1e-6: "position up to 1e-6 L", 1e-3: "up to 1e-3 L", float("inf"): "more"}
COLOURS = ("#bcd6ea", "#6baed6", "#2171b5", "#08306b")
SAME, OTHERWISE = "#f4f4f4", "#D55E00"


def colour_of(change: Change | None) -> str:
    """Colour of a run in a release."""
    if change is None:
        return SAME
    if change.outcomes[0] != change.outcomes[1]:
        return OTHERWISE
    if change.last_digits:
        return COLOURS[0]
    return next(
        colour for top, colour in zip(list(SIZES)[1:], COLOURS[1:], strict=True) if change.size["position"] <= top
    )


def releases_figure(study: VersionStudy) -> Figure:
    """A row for each scene with some settings, a column for each release but the first."""
    versions, rows = study.measured[1:], study.histories
    width, height = LEFT + COLUMN * max(len(versions), 16) + 0.1, TOP + ROW * len(rows) + BOTTOM
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((LEFT / width, BOTTOM / height, COLUMN * len(versions) / width, ROW * len(rows) / height))
    for row, one in enumerate(rows):
        for column, version in enumerate(versions):
            axes.add_patch(Rectangle((column, row), 0.94, 0.94, color=colour_of(one.change_at(version)), linewidth=0))
    axes.set_xlim(0, len(versions))
    axes.set_ylim(len(rows), 0)
    axes.set_xticks([k + 0.5 for k in range(len(versions))], list(versions), rotation=90, fontsize=7.5)
    axes.set_yticks([k + 0.5 for k in range(len(rows))], [f"{one.scene}, {one.settings}" for one in rows], fontsize=7.5)
    axes.grid(False)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    known = [(SAME, "same bits"), *zip(COLOURS, SIZES.values(), strict=True), (OTHERWISE, "another outcome")]
    figure.legend(handles=[Patch(color=colour, label=label) for colour, label in known], loc="upper center", ncols=6)
    return figure
