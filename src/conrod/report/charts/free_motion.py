"""Free motion over time: the crank angle, the error and the drift of energy, each a panel."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from conrod.report.charts.canvas import on_grid, on_log_grid, tolerance_heads
from conrod.report.charts.panels import draw_curves, error_panel, finish_panels
from conrod.report.charts.styles import EXACT, preset_style, preset_title
from conrod.studies.free_motion.results import MotionStudy

EXACT_SAMPLES = 721


def motion_figure(study: MotionStudy) -> Figure:
    """Of all runs that completed."""
    figure = Figure(figsize=(10.5, 9.0))
    above, middle, below = figure.subplots(3, 1, sharex=True)
    keep = np.unique(np.linspace(0, len(study.exact.times) - 1, EXACT_SAMPLES).astype(int))
    exact = np.degrees(study.exact.angle[keep])
    seconds, span = float(study.exact.times[-1]), float(np.ptp(exact)) or 1.0
    above.plot(on_grid(study.exact.times[keep], seconds), on_grid(exact, span), label="exact", **EXACT)
    runs = [(r.curves, preset_style(r.engine, r.preset), r) for r in study.results if r.curves is not None]
    angles = [
        (on_grid(c.times, seconds), on_grid(np.degrees(c.angle), span), s | {"label": preset_title(r.engine, r.preset)})
        for c, s, r in runs
    ]
    draw_curves(above, angles)
    errors = [(on_grid(curves.middles, seconds), on_log_grid(curves.error), style) for curves, style, _ in runs]
    error_panel(middle, "position error / L", errors)
    energies = [(on_grid(curves.middles, seconds), on_log_grid(curves.energy), style) for curves, style, _ in runs]
    error_panel(below, "energy error / largest energy", energies)
    tolerance_heads(middle, seconds, [(run.tolerance.get("position"), style) for _, style, run in runs])
    # A run that goes off must not make the exact curve flat: what is out of the panel is out of it.
    room = 0.12 * span
    above.set_ylim(float(exact.min()) - room, float(exact.max()) + room)
    above.set_ylabel("crank angle [deg]")
    below.set_xlabel("time [s]")
    below.set_xlim(0.0, seconds)
    return finish_panels(figure, [above, middle, below])
