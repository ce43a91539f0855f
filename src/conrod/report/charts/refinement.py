"""Error against step size, with lines of whole orders."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.exact.motion import Array
from conrod.report.charts.canvas import on_log_grid, whole_decades
from conrod.report.charts.layout import NORMS, steps_axis
from conrod.report.charts.styles import curve_style, label
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.validation.results import SceneStudy, ValidationResult

COLUMNS = 3  # of the legend


def refinement_figure(study: SceneStudy) -> Figure:
    """Largest error over the observed points against steps per revolution, a panel for each quantity."""
    runs = [r for r in study.results if r.mode == "dynamic" and r.refinement]
    steps = sorted({p.steps_per_revolution for r in runs for p in r.refinement})
    figure = Figure(figsize=(8.6, 10.0))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, name in zip(panels, QUANTITIES, strict=True):
        drawn = [_curve(axes, run, name) for run in runs]
        whole_decades(axes, drawn)
        for run in runs:
            _draw_guide(axes, run, name)
        axes.set_xscale("log")
        axes.set_ylabel(f"{name} error, max / {NORMS[name]}")
    steps_axis(panels[-1], steps, 1.15)
    # One for all panels, which have the same curves.
    figure.legend(*panels[0].get_legend_handles_labels(), loc="upper center", ncols=COLUMNS, handlelength=4.2)
    figure.align_ylabels(panels)
    figure.subplots_adjust(left=0.1, right=0.9, top=0.93, bottom=0.06, hspace=0.12)
    return figure


def _stable(run: ValidationResult, name: str) -> tuple[Array, Array]:
    """Steps per revolution and errors of the runs that completed."""
    stable = [(p.steps_per_revolution, e) for p in run.refinement if (e := getattr(p, name)) is not None]
    return np.array([float(n) for n, _ in stable]), on_log_grid(np.array([e for _, e in stable]))


def _curve(axes: Axes, run: ValidationResult, name: str) -> Array:
    steps, errors = _stable(run, name)
    axes.plot(steps, errors, label=label(run), **curve_style(run))
    return errors


def _draw_guide(axes: Axes, run: ValidationResult, name: str) -> None:
    """A pale line of the nearest whole order through the coarsest point of a curve that claims an order."""
    steps, errors = _stable(run, name)
    order = round((run.order or {}).get(name) or 0.0)
    if order >= 1:
        guide = errors[0] * (steps / steps[0]) ** -float(order)
        color = curve_style(run)["color"]
        axes.plot(steps, guide, color=color, alpha=0.18, linewidth=6.0, zorder=1, solid_capstyle="butt")
