"""Largest errors on one scale: of all machines side by side, and of a scene against the step size."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from conrod.report.charts.canvas import NORMS, legend_above, log_axis, on_log_grid, rows_axis, steps_axis, whole_decades
from conrod.report.charts.styles import curve_style, label, preset_style, preset_title
from conrod.report.numbers import ROUNDING
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.validation.results import SceneStudy

ROW, MARGINS = 0.26, 1.25  # heights [inch]
LARGEST = 10.0  # error / L that ends the scale: what is further off is no machine any more


def overview_figure(scenes: Mapping[str, Mapping[str, Any]]) -> Figure:
    """The errors of completed runs; those that ended otherwise are crosses at the right edge.

    Args:
        scenes: summaries of a validation by machine.
    """
    figure = Figure(figsize=(10.5, ROW * len(scenes) + MARGINS))
    axes = figure.subplots()
    labels: dict[str, Any] = {}
    for row, summary in enumerate(scenes.values()):
        for result in summary["results"]:
            if result["mode"] != "dynamic" or result["outcome"] == "unsupported":
                continue
            style = preset_style(result["engine"], result["preset"]) | {"linestyle": "none"}
            error = result["largest"]["position"]
            if result["outcome"] == "completed" and error is not None:
                at = float(on_log_grid(np.array([min(error, LARGEST)]))[0])
            else:
                at, style = LARGEST, style | {"marker": "x", "markersize": 6.0}
            (mark,) = axes.plot([at], [row], **style, clip_on=False)
            labels.setdefault(preset_title(result["engine"], result["preset"]), mark)
            if result["outcome"] != "completed":
                labels.setdefault("did not complete", mark)
    log_axis(axes, (ROUNDING, LARGEST), [10.0**k for k in range(-12, 2, 2)])
    rows_axis(axes, list(scenes))
    axes.set_xlabel("largest position error / L over the run")
    height = figure.get_figheight()
    figure.subplots_adjust(left=0.19, right=0.975, top=1.0 - 0.45 / height, bottom=0.6 / height)
    figure.legend(labels.values(), labels, loc="upper center", ncol=len(labels), bbox_to_anchor=(0.55, 1.0))
    return figure


# -- refinement --------------------------------------------------------------------------------------------------------


def refinement_figure(study: SceneStudy) -> Figure:
    """Largest error over the observed points against steps per revolution, a panel for each quantity."""
    runs = [r for r in study.results if r.mode == "dynamic" and r.refinement]
    steps = sorted({p.steps_per_revolution for r in runs for p in r.refinement})
    figure = Figure(figsize=(10.5, 9.0))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, name in zip(panels, QUANTITIES, strict=True):
        drawn = []
        for run in runs:
            stable = [(p.steps_per_revolution, e) for p in run.refinement if (e := getattr(p, name)) is not None]
            drawn.append(on_log_grid(np.array([e for _, e in stable])))
            axes.plot([n for n, _ in stable], drawn[-1], label=label(run), **curve_style(run))
        whole_decades(axes, drawn)
        axes.set_ylabel(f"{name} error, max / {NORMS[name]}")
    steps_axis(panels[-1], steps, 1.15)
    # One for all panels, which have the same curves.
    legend_above(figure, *panels[0].get_legend_handles_labels())
    figure.align_ylabels(panels)
    figure.subplots_adjust(left=0.1, right=0.975, top=0.93, bottom=0.06, hspace=0.12)
    return figure
