"""Errors in panels above each other: over the crank angle, of free motion over time, of a table over revolutions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from conrod.exact.motion import Array
from conrod.own.tables.samples import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report.charts.canvas import NORMS, legend_above, on_grid, on_log_grid, tolerance_heads, whole_decades
from conrod.report.charts.styles import HUES, completed, curve_style, label
from conrod.report.numbers import ROUNDING
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.result import Result
from conrod.studies.free_motion.results import MotionStudy
from conrod.studies.validation.results import SceneStudy, ValidationResult

MARKERS = 12  # of a curve
TAIL = 4  # last samples of a curve, which get no marker
HEIGHT, ABOVE, BELOW = 2.8, 0.5, 0.55  # of a panel, and of the rooms for the legend and the label [inch]
LEAST = 1e-5  # of the largest error of a table's panel: a run that begins without error squeezes no other

# Places and values (N,) on the grid that is drawn, and arguments of `Axes.plot`.
Curve: TypeAlias = tuple[Array, Array, Mapping[str, Any]]


@dataclass(frozen=True)
class Panel:
    """Curves of errors on a logarithmic scale.

    Attributes:
        ends: of the horizontal axis.
        allowed: tolerances with the style of their curves, arrow heads at the right edge.
    """

    label: str
    curves: Sequence[Curve]
    ends: tuple[float, float]
    allowed: Sequence[tuple[float | None, Mapping[str, Any]]] = ()


def panels_figure(panels: Sequence[Panel], along: str, turns: bool = True) -> Figure:
    """The panels, with one legend above them.

    Args:
        along: what the horizontal axis is.
        turns: it is an angle in degrees.
    """
    height = HEIGHT * len(panels) + ABOVE + BELOW
    figure = Figure(figsize=(10.5, height))
    drawn = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    named = dict[str, Any]()
    for axes, panel in zip(drawn, panels, strict=True):
        axes.set_xlim(*panel.ends)
        error_panel(axes, panel.label, panel.curves)
        tolerance_heads(axes, panel.ends[1], panel.allowed)
        if turns:
            axes.xaxis.set_major_locator(_turn_ticks(abs(panel.ends[1] - panel.ends[0])))
        handles, labels = axes.get_legend_handles_labels()
        named |= dict(zip(labels, handles, strict=True))
    if any(allowed is not None for panel in panels for allowed, _ in panel.allowed):
        named["tolerance"] = Line2D([], [], linestyle="none", marker="<", color="#444444", markersize=6)
    drawn[-1].set_xlabel(along)
    figure.align_ylabels(list(drawn))
    figure.subplots_adjust(left=0.095, right=0.97, top=1.0 - ABOVE / height, bottom=BELOW / height, hspace=0.2)
    legend_above(figure, [*named.values()], [*named])
    return figure


def error_panel(axes: Axes, label: str, curves: Sequence[Curve]) -> None:
    """Draw curves of errors, whose markers stand clear of each other, on a logarithmic axis that holds them all."""
    for place, (at, values, style) in enumerate(curves):
        every = max(1, len(at) // MARKERS)
        # The curves take turns, so that no marker covers another.
        marks = slice(2 + (place * every) // len(curves), len(at) - TAIL, every)
        axes.plot(at, values, markevery=marks, **style)
    whole_decades(axes, [values for _, values, _ in curves])
    axes.set_ylabel(label)


def _turn_ticks(degrees: float) -> MultipleLocator | MaxNLocator:
    """Quarters of a turn, or of several; of less than half a turn whatever divides it well."""
    whole = 90.0 * max(1, round(degrees / 720.0))
    return MultipleLocator(whole) if degrees >= 180.0 else MaxNLocator(8, steps=[1, 2, 3, 5, 10])


def _labelled(run: Result) -> dict[str, Any]:
    return curve_style(run) | {"label": label(run)}


# -- validations -------------------------------------------------------------------------------------------------------


def error_figure(study: SceneStudy) -> Figure:
    """Largest error over the observed points in each span of the crank angle, a panel for each quantity."""
    runs = completed(study.results)
    ends = _ends(study.scene, max(run.revolutions for run in runs))
    panels = [
        Panel(
            f"{name} error / {NORMS[name]}", [_error_curve(run, name) for run in runs], ends,
            [(getattr(run.tolerance, name), curve_style(run)) for run in runs],
        )
        for name in QUANTITIES
    ]  # fmt: skip
    return panels_figure(panels, "crank angle [deg]")


def _ends(scene: Scene, revolutions: float) -> tuple[float, float]:
    """Crank angles [deg] at which a run begins and ends; the end is on the right, also where the angle falls."""
    if scene.kinematics.mechanism.driver.span is None:
        return 0.0, float(np.copysign(np.degrees(2.0 * np.pi * revolutions), scene.speed))
    low, high = (float(angle) for angle in np.degrees(scene.kinematics.span))
    return (low, high) if scene.speed > 0.0 else (high, low)


def _error_curve(run: ValidationResult, name: str) -> Curve:
    """Crank angle [deg] and the largest error there over all observed points, on the grid that is drawn."""
    assert run.curves is not None
    curves = [curves[name] for curves in run.curves.values()]
    error = np.max([curve.error for curve in curves], axis=0)
    return on_grid(np.degrees(curves[0].error_angle), 360.0 * run.revolutions), on_log_grid(error), _labelled(run)


def free_motion_figure(study: MotionStudy) -> Figure:
    """Errors of all runs that completed, over time."""
    runs = [(r, r.curves) for r in study.results if r.curves is not None]
    seconds = max(run.seconds for run, _ in runs)
    errors, energies = (
        [(on_grid(c.middles, seconds), on_log_grid(getattr(c, name)), _labelled(r)) for r, c in runs]
        for name in ("error", "energy")
    )
    allowed = [(run.tolerance.get("position"), curve_style(run)) for run, _ in runs]
    panels = [
        Panel("position error / L", errors, (0.0, seconds), allowed),
        Panel("energy error / largest energy", energies, (0.0, seconds)),
    ]
    return panels_figure(panels, "time [s]", turns=False)


def table_figure(study: TableStudy) -> Figure:
    """Largest error in each span of the run against the revolutions, a line for each point."""
    # Without a crank angle the error at the angle reached is that at the time.
    named = [q for q in ERRORS if q != "position" or study.phase is not None]
    hues = dict(zip(study.errors, cycle(HUES), strict=False))
    panels = []
    for quantity in named:
        curves = {point: errors[quantity] for point, errors in study.errors.items() if quantity in errors}
        if curves:
            least = max(ROUNDING, LEAST * max(float(curve.largest.max()) for curve in curves.values()))
            lines = [
                (
                    on_grid(curve.at, study.revolutions), on_log_grid(np.maximum(curve.largest, least)),
                    {"color": hues[point], "label": point},
                )
                for point, curve in curves.items()
            ]  # fmt: skip
            head = {"color": "#444444", "markerfacecolor": "#444444"}
            title, allowed = f"{quantity} error / {NORMS.get(quantity, 'L')}", [(study.tolerance.get(quantity), head)]
            panels.append(Panel(title, lines, (0.0, study.revolutions), allowed))
    return panels_figure(panels, "revolutions since the first row", turns=False)
