"""Error against step size, with the observed order."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.motion import Array
from conrod.report import numbers
from conrod.report.canvas import on_log_grid, whole_decades
from conrod.report.error_figure import NORMS
from conrod.report.styles import curve_style, label
from conrod.studies.results import QUANTITIES, Result, SceneStudy


def refinement_figure(study: SceneStudy) -> Figure:
    """Largest error over the observed points against steps per revolution, a panel for each quantity."""
    runs = [r for r in study.results if r.mode == "dynamic" and r.refinement]
    steps = sorted({p.steps_per_revolution for r in runs for p in r.refinement})
    figure = Figure(figsize=(10.5, 9.6))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, name in zip(panels, QUANTITIES, strict=True):
        drawn = [_curve(axes, run, name) for run in runs]
        whole_decades(axes, drawn)
        axes.set_xscale("log")
        axes.set_ylabel(f"{name} error, max / {NORMS[name]}")
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), handlelength=4.2, labelspacing=0.9)
    if steps:
        panels[-1].set_xlim(steps[0] / 1.15, steps[-1] * 1.15)
        panels[-1].set_xticks(steps, [str(n) for n in steps])
    panels[-1].minorticks_off()
    panels[-1].set_xlabel("steps per revolution N (step of the crank angle h = 2π / N)")
    figure.subplots_adjust(left=0.085, right=0.72, top=0.98, bottom=0.06, hspace=0.12)
    return figure


def _curve(axes: Axes, run: Result, name: str) -> Array:
    """Draws the stable points of a refinement path, over a pale line of the whole order that it claims."""
    stable = [(p.steps_per_revolution, e) for p in run.refinement if (e := getattr(p, name)) is not None]
    steps = np.array([float(n) for n, _ in stable])
    errors = on_log_grid(np.array([e for _, e in stable]))
    order = None if run.order is None else run.order.get(name)
    found = "order not claimed" if order is None else f"order {numbers.order(order)}"
    style = curve_style(run)
    axes.plot(steps, errors, label=f"{label(run)}: {found}", **style)
    if order is not None and round(order) > 0:
        _slope_guide(axes, steps, errors, round(order), style["color"])
    return errors


def _slope_guide(axes: Axes, steps: Array, errors: Array, order: int, colour: str) -> None:
    """The line of a whole order through the coarsest point, and its order beside its end."""
    guide = errors[0] * (steps / steps[0]) ** -float(order)
    axes.plot(steps, guide, color=colour, alpha=0.18, linewidth=6.0, zorder=1, solid_capstyle="butt")
    axes.annotate(
        f"slope {order}",
        (steps[-1], guide[-1]),
        xytext=(7, 0),
        textcoords="offset points",
        fontsize=7.5,
        color=colour,
        va="center",
    )
