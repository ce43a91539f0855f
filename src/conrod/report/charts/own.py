"""A table against the exact motion: errors over a run."""

from __future__ import annotations

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from conrod.own.tables.samples import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report.charts.canvas import NORMS, on_grid, on_log_grid, tolerance_heads
from conrod.report.charts.panels import Curve, error_panel, finish_panels
from conrod.report.charts.styles import HUES
from conrod.report.numbers import ROUNDING

PANEL, MARGINS = 2.6, 0.9  # heights [inch]
HEAD = {"color": "#444444", "markerfacecolor": "#444444"}  # of a tolerance


def error_figure(study: TableStudy) -> Figure:
    """Largest error in each span of the run against the revolutions, a line for each point."""
    # Without a crank angle the error at the angle reached is that at the time.
    named = [q for q in ERRORS if q != "position" or study.phase is not None]
    shown = [q for q in named if any(q in errors for errors in study.errors.values())]
    figure = Figure(figsize=(9.0, PANEL * len(shown) + MARGINS))
    panels = list(figure.subplots(len(shown), 1, squeeze=False)[:, 0])
    for axes, quantity in zip(panels, shown, strict=True):
        of_points = {point: errors[quantity] for point, errors in study.errors.items() if quantity in errors}
        curves: list[Curve] = [
            (
                on_grid(curve.at, study.revolutions),
                on_log_grid(np.maximum(curve.largest, ROUNDING / 10.0)),
                {"label": point, "color": hue},
            )
            for (point, curve), hue in zip(of_points.items(), cycle(HUES), strict=False)
        ]
        error_panel(axes, f"{quantity} error / {NORMS.get(quantity, 'L')}", curves)
        axes.set_xlim(0.0, study.revolutions)
        tolerance_heads(axes, study.revolutions, [(study.tolerance.get(quantity), HEAD)])
    panels[-1].set_xlabel("revolutions since the first row")
    room = figure.get_figheight()
    return finish_panels(figure, panels, left=0.11, top=1.0 - 0.5 / room, bottom=0.55 / room)
