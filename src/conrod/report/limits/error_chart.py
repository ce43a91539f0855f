"""Errors along an axis, a curve for each engine and preset, and above it a mark for each run that did not complete."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.report.charts.canvas import Layout, legend_rows, on_log_grid, preset_handles, whole_decades
from conrod.report.charts.styles import OUTCOME_MARKS, colour, preset_style, preset_title
from conrod.report.limits.marks import UNDETECTED_COLOUR, AxisScale, outcome_handles
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.records import ROUGH_ERROR, SAFE_ERROR
from conrod.studies.limits.results import Probe, Walk
from conrod.studies.limits.scale import Scale

WIDTH, PANEL = 9.5, 2.9  # [inch]
LEFT, RIGHT, TOP, GAP, BOTTOM = 0.85, 0.25, 0.24, 0.16, 0.52  # margins [inch]
LEGEND_COLUMNS, LEGEND_ROW = 5, 0.19
LANE = 0.17  # of a run that did not complete [inch]
ABOVE = 0.06  # of the panel's top [inch]
RING: dict[str, Any] = {
    "linestyle": "none",
    "color": UNDETECTED_COLOUR,
    "zorder": 6,
    "marker": "o",
    "markersize": 11.0,
    "markerfacecolor": "none",
    "markeredgewidth": 1.3,
}


@dataclass(frozen=True)
class Panel:
    """A quantity of the runs along an axis.

    Attributes:
        label: of the vertical axis, with what the quantity is divided by.
        of: its value; None where a run has none.
    """

    label: str
    of: Callable[[Probe], float | None]


POSITION = Panel("position error, max / L", lambda probe: probe.position)
TORQUE = Panel("drive torque error, max / peak", lambda probe: probe.torque)


def error_chart(walks: Sequence[Walk]) -> Figure:
    """Draw torque and position errors of all runs of some walks of an axis, of which one has errors at least."""
    walks = [walk for walk in walks if walk.probes]
    panels = [panel for panel in (TORQUE, POSITION) if _values(walks, panel)]
    axis = AXES[walks[0].axis]
    scale = AxisScale.of(axis.scale, walks)
    lanes = list(dict.fromkeys((w.engine, w.preset) for w in walks if any(p.errors is None for p in w.probes)))
    handles = _legend(walks)
    strip = ABOVE + LANE * len(lanes) if lanes else 0.0
    head = TOP + LEGEND_ROW * legend_rows(handles, LEGEND_COLUMNS) + strip
    height = head + len(panels) * PANEL + (len(panels) - 1) * GAP + BOTTOM
    layout = Layout(WIDTH, height)
    for k, panel in enumerate(panels):
        axes = layout.axes(LEFT, height - head - (k + 1) * PANEL - k * GAP, WIDTH - LEFT - RIGHT, PANEL)
        _draw_panel(axes, scale, walks, panel)
        if k == 0:
            _draw_failed(axes, scale, walks, lanes)
        if k < len(panels) - 1:
            axes.set_xlabel("")
            axes.tick_params(axis="x", labelbottom=False)
        else:
            axes.set_xlabel(axis.label)
    layout.legend(handles, LEGEND_COLUMNS, handlelength=3.0)
    return layout.figure


def _values(walks: Sequence[Walk], panel: Panel) -> list[float]:
    found = (panel.of(probe) for walk in walks for probe in walk.probes)
    return [value for value in found if value is not None]


def _draw_panel(axes: Axes, scale: AxisScale, walks: Sequence[Walk], panel: Panel) -> None:
    drawn = [on_log_grid(np.array(_values(walks, panel)))]
    whole_decades(axes, drawn)
    for limit in (SAFE_ERROR, ROUGH_ERROR) if panel is POSITION else ():
        axes.axhline(limit, color="#888888", linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
    for walk in walks:
        style = preset_style(walk.engine, walk.preset)
        if scale.scale is Scale.LISTED:
            style = style | {"linestyle": "none"}
        # A curve is broken where a run has no value: nothing is known there.
        _plot(axes, scale, walk.probes, panel, style)
        _plot(axes, scale, [probe for probe in walk.probes if probe.undetected], panel, RING)
    scale.apply(axes, "")
    axes.set_ylabel(panel.label)


def _plot(axes: Axes, scale: AxisScale, probes: Sequence[Probe], panel: Panel, style: Mapping[str, Any]) -> None:
    heights = np.array([panel.of(probe) for probe in probes], dtype=float)
    if not np.isnan(heights).all():
        axes.plot(scale.places(probe.value for probe in probes), on_log_grid(heights), **style)


def _draw_failed(axes: Axes, scale: AxisScale, walks: Sequence[Walk], lanes: Sequence[tuple[str, str]]) -> None:
    """A mark for each run without errors, above the panel, a lane for each engine and preset."""
    for lane, key in enumerate(lanes):
        up = 1.0 + (ABOVE + LANE * (len(lanes) - lane - 0.5)) / PANEL
        failed = [p for w in walks if (w.engine, w.preset) == key for p in w.probes if p.errors is None]
        for outcome, undetected in dict.fromkeys((p.outcome, p.undetected) for p in failed):
            places = scale.places(p.value for p in failed if (p.outcome, p.undetected) == (outcome, undetected))
            hue = UNDETECTED_COLOUR if undetected else colour(key[0])
            style: dict[str, Any] = {"linestyle": "none", "markersize": 4.0, "color": hue, "markeredgewidth": 0.9}
            style |= {"marker": OUTCOME_MARKS.get(outcome, "o"), "clip_on": False}
            axes.plot(places, np.full(len(places), up), transform=axes.get_xaxis_transform(), **style)
        axes.annotate(preset_title(*key), (-0.005, up), xycoords="axes fraction", ha="right", va="center", fontsize=6.0)


def _legend(walks: Sequence[Walk]) -> list[Line2D]:
    names = dict.fromkeys((walk.engine, walk.preset) for walk in walks)
    bare: dict[str, Any] = {"linestyle": "none"} if AXES[walks[0].axis].scale is Scale.LISTED else {}
    handles = preset_handles(names, **bare)
    probes = [probe for walk in walks for probe in walk.probes]
    if any(probe.undetected for probe in probes):
        handles.append(Line2D([], [], label="red: undetected", **RING))
    return [*handles, *outcome_handles({probe.outcome for probe in probes if probe.errors is None})]
