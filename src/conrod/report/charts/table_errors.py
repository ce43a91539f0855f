"""Error of a table over its run: a panel for each quantity that it has."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.own.error_curve import ErrorCurve
from conrod.own.tables.study import TableStudy
from conrod.report.charts.canvas import on_grid, on_log_grid, whole_decades
from conrod.report.charts.layout import NORMS
from conrod.report.charts.styles import HUES

LEAST = 1e-5  # of the largest error of a panel: what is below leaves the panel
PANEL, MARGINS = 2.7, 1.3  # heights [inch]
# Two points, each twice, and two tolerances stand side by side.
LEGEND = {"fontsize": 7.5, "columnspacing": 1.2, "handlelength": 1.7}
TOTAL_LINE, OWN_LINE = (0, (4, 2)), "-"


def error_figure(study: TableStudy) -> Figure:
    """Largest error in each span of the run against the revolutions, a line for each point."""
    shown = [q for q in NORMS if any(q in errors for errors in study.errors.values())]
    figure = Figure(figsize=(10.5, PANEL * len(shown) + MARGINS))
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, quantity in zip(panels, shown, strict=True):
        drawn = []
        for label, hue, line, curve in _lines(study, quantity):
            drawn.append(on_log_grid(curve.largest))
            axes.plot(on_grid(curve.at, study.revolutions), drawn[-1], label=label, color=hue, linestyle=line)
        # A run that starts without error, or crosses zero, does not squeeze the rest together.
        least = LEAST * max(float(error.max()) for error in drawn)
        whole_decades(axes, [np.maximum(error, least) for error in drawn])
        axes.set_ylabel(f"{quantity} error / {NORMS[quantity]}")
        axes.set_xlim(0.0, study.revolutions)
        _mark_tolerance(axes, study, quantity)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=6, borderaxespad=0.2, **LEGEND)
    panels[-1].set_xlabel("revolutions since the first row")
    figure.align_ylabels(list(panels))
    height = figure.get_figheight()
    figure.subplots_adjust(left=0.085, right=0.975, top=1.0 - 0.5 / height, bottom=0.6 / height, hspace=0.2)
    return figure


def _lines(study: TableStudy, quantity: str) -> Iterator[tuple[str, str, object, ErrorCurve]]:
    """Label, colour, style and error of each line of a panel."""
    for place, (point, errors) in enumerate(study.errors.items()):
        hue = HUES[place % len(HUES)]
        if quantity == "position" and study.crank is None:
            # Without a crank angle the two are one.
            if "total" in errors:
                yield point, hue, OWN_LINE, errors["total"]
            continue
        if quantity in errors:
            label = f"{point}, at the angle reached" if quantity == "position" else point
            yield label, hue, OWN_LINE, errors[quantity]
        if quantity == "position" and "total" in errors:
            yield f"{point}, at the nominal time (total)", hue, TOTAL_LINE, errors["total"]


def _mark_tolerance(axes: Axes, study: TableStudy, quantity: str) -> None:
    """A line where the tolerance is, if that is within the panel."""
    names = ("position", "total") if quantity == "position" else (quantity,)
    low, high = axes.get_ylim()
    for name in names:
        allowed = study.tolerance.get(name)
        if allowed is not None and low < allowed < high:
            label = f"tolerance of {name}"
            axes.axhline(
                on_log_grid(np.array([allowed]))[0], color="#444444", linewidth=0.9, linestyle=":", label=label
            )
