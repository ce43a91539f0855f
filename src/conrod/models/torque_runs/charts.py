"""The figure of a run under a torque: errors of points and of the crank over time."""

from __future__ import annotations

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from conrod.models.torque_runs.comparison import JUDGED_QUANTITIES, PHASE
from conrod.models.torque_runs.study import TorqueRunStudy
from conrod.report.charts.canvas import round_to_grid, round_to_log_grid
from conrod.report.charts.panels import Panel, panels_figure
from conrod.report.charts.styles import CURVE_COLOURS
from conrod.report.numbers import ROUNDING

MIN_SHARE_OF_LARGEST = 1e-5  # of a panel, below which errors are not drawn: a run may begin with none
LABELS = {
    "position": "position error / L", "velocity": "velocity error / ω L", "acceleration": "acceleration error / ω² L",
    "phase": "crank angle error [deg]", "speed": "crank speed error / ω",
}  # fmt: skip


def torque_run_figure(study: TorqueRunStudy) -> Figure:
    """Draw the largest errors of each observed point and of the crank against time."""
    hues = dict(zip(study.errors, cycle(CURVE_COLOURS), strict=False))
    panels = []
    for quantity in JUDGED_QUANTITIES:
        curves = {point: errors[quantity] for point, errors in study.errors.items() if quantity in errors}
        if curves:
            least = max(ROUNDING, MIN_SHARE_OF_LARGEST * max(float(curve.largest.max()) for curve in curves.values()))
            factor = 180.0 / np.pi if quantity == PHASE else 1.0
            lines = [
                (
                    round_to_grid(curve.at, study.span[1]),
                    round_to_log_grid(factor * np.maximum(curve.largest, least)),
                    {"color": hues[point], "label": point},
                )
                for point, curve in curves.items()
            ]  # fmt: skip
            allowed = study.tolerance.get(quantity)
            head = {"color": "#444444", "markerfacecolor": "#444444"}
            panels.append(Panel(LABELS[quantity], lines, study.span, [(allowed and factor * allowed, head)]))
    return panels_figure(panels, "time [s]")
