"""Largest position errors of all machines on one scale: a row for each machine, a mark for each engine and preset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from conrod.report.charts.canvas import on_log_grid
from conrod.report.charts.layout import log_axis, rows_axis
from conrod.report.charts.styles import preset_style, preset_title
from conrod.report.numbers import ROUNDING

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
