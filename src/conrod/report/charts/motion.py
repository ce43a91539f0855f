"""Motion of the observed points: engines over the exact curve, against the crank angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.exact.motion import Array
from conrod.report.charts.canvas import legend_above, on_grid
from conrod.report.charts.styles import EXACT, completed, curve_style, label
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.validation.results import SceneStudy, ValidationResult

SECONDS = {"position": "", "velocity": "/s", "acceleration": "/s²"}
# Numbers of more digits than this, in mm, are shown in m.
LARGEST_IN_MM = 2e4
COMPONENTS = "xy"
# Samples of a turn: straight from degree to degree is less than a line's width off.
EXACT_SAMPLES = 361
BESIDE_BREAK = 1e-6  # [rad]
# A run that leaves the panel is no curve; its samples are drawn as dots.
DOTS: dict[str, Any] = {"linestyle": "none", "markersize": 2.0, "markeredgewidth": 0.6}
ENOUGH_SAMPLES = 90
# A component that stays this close to a constant, against the point's L, has nothing to show.
FLAT = 1e-9
# How far beyond the exact curve, in its span, a panel follows the engines.
MARGIN, FOLLOW = 0.08, 0.30
# Degrees from marker to marker of a curve; the curves take turns, so that no marker covers another.
MARKER_SPACING = 40.0


@dataclass(frozen=True)
class Coordinate:
    """Content of one panel."""

    point: str
    component: int  # 0 x, 1 y
    quantity: str


def motion_figure(study: SceneStudy) -> Figure:
    """Position, velocity and acceleration over one turn, a column for each component that moves."""
    columns = moving_components(study.scene)
    runs = completed(study.results)
    figure = Figure(figsize=(3.6 * len(columns) + 1.0 if len(columns) > 1 else 8.0, 8.4))
    grid = figure.subplots(3, len(columns), sharex=True, squeeze=False)
    angle = _angles(study.scene)
    exact = study.scene.motion(angle, study.scene.speed)
    for j, (point, k) in enumerate(columns):
        for i, name in enumerate(QUANTITIES):
            truth = getattr(exact.point(point), name)[:, k]
            _panel(grid[i, j], Coordinate(point, k, name), angle, truth, runs)
        grid[0, j].set_title(f"{point}, along {COMPONENTS[k]}", loc="left")
        grid[2, j].set_xlabel("crank angle [deg]")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.subplots_adjust(left=0.09, right=0.985, top=0.925, bottom=0.07, hspace=0.18, wspace=0.32)
    legend_above(figure, handles, labels, 3.0)
    return figure


def _angles(scene: Scene) -> Array:
    """Crank angles [rad] of one turn, or of the one pass, with both sides of every break."""
    breaks = np.array(scene.break_angles())
    turn = np.linspace(*scene.kinematics.span, EXACT_SAMPLES)
    return np.sort(np.concatenate([turn, breaks - BESIDE_BREAK, breaks + BESIDE_BREAK]))


def moving_components(scene: Scene) -> list[tuple[str, int]]:
    """(point, 0 for x or 1 for y) of all observed coordinates that move in a turn."""
    turn = np.linspace(*scene.kinematics.span, 361)
    points = scene.motion(turn, scene.speed).points
    spans = {(name, k): float(np.ptp(p.position[:, k])) for name, p in points.items() for k in (0, 1)}
    return [(name, k) for (name, k), span in spans.items() if span > FLAT * scene.lengths[name]]


def _panel(axes: Axes, shown: Coordinate, angle: Array, truth: Array, runs: list[ValidationResult]) -> None:
    unit, metres = ("m", 1.0) if np.abs(truth).max() * 1e3 > LARGEST_IN_MM else ("mm", 1e-3)
    truth, unit = truth / metres, unit + SECONDS[shown.quantity]
    span = float(np.ptp(truth)) or 1.0
    low, high = float(truth.min()), float(truth.max())
    axes.plot(np.degrees(angle), on_grid(truth, span), label="exact", **EXACT)
    reached = [low, high]
    for place, run in enumerate(runs):
        assert run.curves is not None
        curve = run.curves[shown.point][shown.quantity]
        degrees, values = _one_turn(curve.angle), curve.values[:, shown.component] / metres
        inside = (values > low - FOLLOW * span) & (values < high + FOLLOW * span)
        reached += [float(values[inside].min(initial=low)), float(values[inside].max(initial=high))]
        if inside.all():
            every = max(1, len(degrees) // ENOUGH_SAMPLES)
            _draw(axes, run, degrees[::every], values[::every], span, place / len(runs))
        else:
            dots = curve_style(run) | DOTS
            axes.plot(on_grid(degrees[inside], 360.0), on_grid(values[inside], span), **dots)
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 60))
    axes.set_ylim(*on_grid(np.array([min(reached) - MARGIN * span, max(reached) + MARGIN * span]), 100.0 * span))
    axes.set_ylabel(f"{shown.quantity} [{unit}]")


def _draw(axes: Axes, run: ValidationResult, degrees: Array, values: Array, span: float, phase: float) -> None:
    """A thin line with sparse markers; `phase`, from 0 to 1, shifts the markers."""
    style = curve_style(run) | {"linewidth": 0.7}
    marked = _markers(degrees, phase)
    axes.plot(on_grid(degrees, 360.0), on_grid(values, span), markevery=marked, label=label(run), **style)


def _one_turn(angle: Array) -> Array:
    """Crank angles [deg], whole turns taken off."""
    turns = np.rint(angle.min() / (2.0 * np.pi))
    return np.asarray(np.degrees(angle - 2.0 * np.pi * turns))


def _markers(degrees: Array, phase: float) -> list[int]:
    """Samples that get a marker."""
    wanted = np.arange(0.0, 360.0, MARKER_SPACING) + (phase + 0.1) * MARKER_SPACING
    return sorted({int(np.argmin(np.abs(degrees - at))) for at in wanted})
