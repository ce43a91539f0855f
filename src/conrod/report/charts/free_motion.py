"""Free motion over time: the crank angle, the error and the drift of energy, each a panel."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from conrod.exact.motion import Array
from conrod.report.charts.canvas import legend_above, on_grid, on_log_grid, taking_turns, tolerance_heads, whole_decades
from conrod.report.charts.styles import EXACT, preset_style, preset_title
from conrod.studies.free_motion.results import MotionStudy

MARKERS_PER_RUN = 12
EXACT_SAMPLES = 721


def motion_figure(study: MotionStudy) -> Figure:
    """Of all runs that completed."""
    figure = Figure(figsize=(10.5, 9.0))
    above, middle, below = figure.subplots(3, 1, sharex=True)
    keep = np.unique(np.linspace(0, len(study.exact.times) - 1, EXACT_SAMPLES).astype(int))
    exact = np.degrees(study.exact.angle[keep])
    seconds, span = float(study.exact.times[-1]), float(np.ptp(exact)) or 1.0
    above.plot(on_grid(study.exact.times[keep], seconds), on_grid(exact, span), label="exact", **EXACT)
    drawn: dict[str, list[Array]] = {"error": [], "energy": []}
    runs = [(r, r.curves) for r in study.results if r.curves is not None]
    for place, (result, curves) in enumerate(runs):
        style, name = preset_style(result.engine, result.preset), preset_title(result.engine, result.preset)
        # A run that goes off must not make the exact curve flat: what is out of the panel is out of it.
        above.plot(
            on_grid(curves.times, seconds), on_grid(np.degrees(curves.angle), span), label=name,
            markevery=taking_turns(len(curves.times), place, len(runs), MARKERS_PER_RUN), **style,
        )  # fmt: skip
        for axes, quantity in ((middle, "error"), (below, "energy")):
            values = on_log_grid(getattr(curves, quantity))
            drawn[quantity].append(values)
            marks = taking_turns(len(values), place, len(runs), MARKERS_PER_RUN)
            axes.plot(on_grid(curves.middles, seconds), values, markevery=marks, **style)
    room = 0.12 * span
    above.set_ylim(float(exact.min()) - room, float(exact.max()) + room)
    for axes, quantity in ((middle, "error"), (below, "energy")):
        whole_decades(axes, drawn[quantity])
    allowed = [(r.tolerance.get("position"), preset_style(r.engine, r.preset)) for r, _ in runs]
    tolerance_heads(middle, seconds, allowed)
    above.set_ylabel("crank angle [deg]")
    middle.set_ylabel("position error / L")
    below.set_ylabel("energy error / largest energy")
    below.set_xlabel("time [s]")
    below.set_xlim(0.0, seconds)
    figure.align_ylabels([above, middle, below])
    figure.subplots_adjust(left=0.095, right=0.97, top=0.93, bottom=0.06, hspace=0.13)
    handles, labels = above.get_legend_handles_labels()
    legend_above(figure, handles, labels)
    return figure
