"""The figure of free motion: errors of position and energy over time."""

from __future__ import annotations

from matplotlib.figure import Figure

from conrod.report.charts.canvas import (
    round_to_grid,
    round_to_log_grid,
)
from conrod.report.charts.panels import Panel, labelled_style, panels_figure
from conrod.report.charts.styles import curve_style
from conrod.studies.free_motion.results import MotionStudy


def free_motion_figure(study: MotionStudy) -> Figure:
    """Draw the errors of all completed runs of free motion over time."""
    runs = [(r, r.curves) for r in study.results if r.curves is not None]
    seconds = max(run.seconds for run, _ in runs)
    errors, energies = (
        [(round_to_grid(c.middles, seconds), round_to_log_grid(getattr(c, name)), labelled_style(r)) for r, c in runs]
        for name in ("error", "energy")
    )
    allowed = [(run.tolerance.get("position"), curve_style(run)) for run, _ in runs]
    panels = [
        Panel("position error / L", errors, (0.0, seconds), allowed),
        Panel("energy error / largest energy", energies, (0.0, seconds)),
    ]
    return panels_figure(panels, "time [s]")
