"""The figure of a table: errors of its observed points over revolutions."""

from __future__ import annotations

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from conrod.models.tables.errors import ALL_ERRORS
from conrod.models.tables.study import TableStudy
from conrod.report.charts.canvas import (
    NORMS,
    round_to_grid,
    round_to_log_grid,
)
from conrod.report.charts.panels import Panel, panels_figure
from conrod.report.charts.styles import CURVE_COLOURS
from conrod.report.numbers import ROUNDING

MIN_SHARE_OF_LARGEST = 1e-5  # of a table's panel, below which errors are not drawn: a run may begin with none


def table_figure(study: TableStudy) -> Figure:
    """Draw the largest error of each observed point or link of a table against revolutions."""
    # Without a crank angle the errors `position` and `total` are the same.
    named = [q for q in ALL_ERRORS if q != "position" or study.phase is not None]
    hues = dict(zip(study.errors, cycle(CURVE_COLOURS), strict=False))
    panels = []
    for quantity in named:
        curves = {point: errors[quantity] for point, errors in study.errors.items() if quantity in errors}
        if curves:
            least = max(ROUNDING, MIN_SHARE_OF_LARGEST * max(float(curve.largest.max()) for curve in curves.values()))
            lines = [
                (
                    round_to_grid(curve.at, study.revolutions), round_to_log_grid(np.maximum(curve.largest, least)),
                    {"color": hues[point], "label": point},
                )
                for point, curve in curves.items()
            ]  # fmt: skip
            head = {"color": "#444444", "markerfacecolor": "#444444"}
            title, allowed = (
                f"{quantity.replace('_', ' ')} error / {NORMS.get(quantity, 'L')}",
                [(study.tolerance.get(quantity), head)],
            )
            panels.append(Panel(title, lines, (0.0, study.revolutions), allowed))
    return panels_figure(panels, "revolutions since the first row")
