"""The moving machine of a validation: an engine's bodies over the exact ones, with magnified error, and curves.

Curves against the crank angle are small SVGs with a cursor that the page's script moves.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup, escape

from conrod.exact.motion import QUANTITIES, Array
from conrod.report import numbers
from conrod.report.charts.canvas import NORMS
from conrod.report.charts.styles import label, svg_stroke
from conrod.report.html.page import html_template
from conrod.report.html.parts import points_text, svg_number
from conrod.report.kind import Part
from conrod.report.numbers import ROUNDING
from conrod.studies.validation.motion_curves import PAGE_UNITS
from conrod.studies.validation.moving_drawing import MAX_POWER, POSES, MovingMachine, moving_machine, transforms
from conrod.studies.validation.results import SceneStudy

# Edges of the plot in an SVG of 400 by 145 units; machine.js knows LEFT and RIGHT too.
LEFT, RIGHT, TOP, BOTTOM = 52.0, 386.0, 24.0, 122.0
MAX_LABELS = 4  # on a linear axis
MAX_DECADE_LABELS = 4  # on an axis
STILL_SHARE = 1e-9  # of the other component's span: what moves by less is rounding, and is not drawn
ANGLE_TICKS = 5  # on the axis of the crank angle


class PanelCurve(NamedTuple):
    """A curve of a panel.

    Attributes:
        along: abscissae (K,), shares of the drawn range of the crank angle.
        values: ordinates (K,).
        run: number of the run; -1 for the exact motion.
        look: SVG attributes."""

    along: Array
    values: Array
    run: int
    look: str


def panel_svg(
    title: str, lines: Sequence[PanelCurve], ends: tuple[float, float], at: float, log: bool = False
) -> Markup:
    """Draw curves against the crank angle as SVG, with a cursor.

    Args:
        title: title of the panel.
        lines: the curves.
        ends: first and last crank angle [deg].
        at: place of the cursor, a share of the range.
        log: True for a logarithmic scale."""
    if log:
        lines = [line._replace(values=np.log10(np.maximum(line.values, ROUNDING))) for line in lines]
    values = np.concatenate([line.values for line in lines] or [np.zeros(1)])
    low, high = float(values.min()), float(values.max())
    if log:
        low, high = math.floor(low), max(math.ceil(high), math.floor(low) + 1)
        ticks = np.arange(high, low - 1.0, -np.ceil((high - low) / MAX_DECADE_LABELS))
        names = [f"1e{tick:.0f}" for tick in ticks]
    else:
        if low == high:
            low, high = low - 0.5, high + 0.5
        ticks, names = axis_ticks(low, high)
    span = (high - low) or 1.0

    def y(value: Array) -> Array:
        return np.asarray(BOTTOM - (BOTTOM - TOP) * (value - low) / span)

    marks = "".join(
        f'<path class="grid" d="M{LEFT} {h:.1f}H{RIGHT}"/>'
        f'<text x="{LEFT - 4}" y="{h + 4:.1f}" text-anchor="end">{name}</text>'
        for h, name in zip(y(ticks), names, strict=True)
    )
    for share in np.linspace(0.0, 1.0, ANGLE_TICKS):
        degrees = f"{ends[0] + share * (ends[1] - ends[0]):.0f}"
        place, anchor = (_cursor_x(share), "middle") if share < 1.0 else (400.0, "end")
        unit = "" if share < 1.0 else " deg"
        marks += f'<text x="{place:.0f}" y="{BOTTOM + 16}" text-anchor="{anchor}">{degrees}{unit}</text>'
    drawn = "".join(_curve_path(line, y(line.values)) for line in lines)
    cursor = f'<line class="cursor" x1="{_cursor_x(at):.1f}" x2="{_cursor_x(at):.1f}" y1="{TOP}" y2="{BOTTOM}"/>'
    kind = ' data-log="1"' if log else ""
    return Markup(  # made of numbers and escaped texts
        f'<svg class="curves" viewBox="0 0 400 145" data-low="{low:.6g}" data-high="{high:.6g}"'
        f'{kind} role="img" aria-label="{escape(title)}, against the crank angle in '
        f'degrees"><text x="0" y="12" class="title">{escape(title)}</text>'
        f'<text x="{RIGHT}" y="12" text-anchor="end" class="value"></text>{marks}{drawn}{cursor}</svg>'
    )


def axis_ticks(low: float, high: float) -> tuple[Array, list[str]]:
    """Return round values between two, zero among them if it lies between, and their texts."""
    tenth = 10.0 ** math.floor(math.log10((high - low) / MAX_LABELS))
    step = next(one * tenth for one in (1.0, 2.0, 5.0, 10.0) if (high - low) / (one * tenth) <= MAX_LABELS)
    ticks = np.asarray(step * np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1), dtype=float)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return ticks, [svg_number(tick, decimals) for tick in ticks]


def _cursor_x(share: float) -> float:
    return LEFT + (RIGHT - LEFT) * share


def _curve_path(line: PanelCurve, heights: Array) -> str:
    places = points_text(zip(map(_cursor_x, line.along), heights, strict=True))
    return f'<path data-run="{line.run}" d="M{places}" {line.look}/>'


def machine_html(part: Part[SceneStudy], anchor: str) -> str:
    """Return the HTML of a moving machine with controls and curves; empty if no run has poses."""
    machine = moving_machine(part.findings)
    if machine is None:
        return ""
    first, still = machine.runs[0], machine.still
    power, exact = machine.power(first), machine.exact[machine.still]
    error = machine.errors(first)[round(still * (len(machine.errors(first)) - 1) / POSES)]
    bodies, (start, end) = list(machine.drawing.bodies.items()), machine.ends
    degrees = start + (end - start) * still / POSES
    return html_template("machine.html.jinja").render(
        anchor=anchor, study=part.findings, box=" ".join(f"{one:.0f}" for one in machine.drawing.box), still=still,
        bodies=[Markup(svg) for _, svg in bodies[:-1]], ground=Markup(bodies[-1][1]), power=power,
        order=machine.drawing.order, magnification=numbers.magnification, powers=range(MAX_POWER + 1),
        exact=transforms(exact), engine=transforms(exact + 10.0**power * error),
        runs=[(label(run), _legend_sample(machine, k)) for k, run in enumerate(machine.runs)],
        panels=_panels(machine), data=Markup(json.dumps(_script_data(machine), separators=(",", ":"))),
        degrees=f"{degrees:.0f}", traces=_point_paths(machine), output=part.findings.scene.output,
    )  # fmt: skip


def _script_data(machine: MovingMachine) -> dict[str, Any]:
    """Return the numbers by which the page's script moves the drawing."""
    scene = machine.study.scene
    observed = next(point for point in scene.mechanism().observed if point.name == scene.output)
    x, y = (machine.drawing.scale * one for one in observed.point)
    return {
        "ends": machine.ends, "exact": np.round(machine.exact, 3).tolist(), "mm": 1e3 / machine.drawing.scale,
        "point": [scene.mechanism().body_index[observed.body], round(x, 4), round(-y, 4)],
        "runs": [
            {
                "power": machine.power(run),
                "errors": [[numbers.round_to_digits(one, 3) for one in row] for row in machine.errors(run).tolist()],
            }
            for run in machine.runs
        ],
    }  # fmt: skip


def _stroke(machine: MovingMachine, number: int) -> str:
    run = machine.runs[number]
    return svg_stroke(run.engine, run.preset)


def _legend_sample(machine: MovingMachine, number: int) -> Markup:
    return Markup(f'<svg viewBox="0 0 30 8" aria-hidden="true"><path d="M0 4H30" {_stroke(machine, number)}/></svg>')


def _point_paths(machine: MovingMachine) -> list[str]:
    scene, scale = machine.study.scene, machine.drawing.scale
    points = scene.motion(machine.angles[::4], scene.speed).points.values()
    return [points_text((scale * x, -scale * y) for x, y in point.position) for point in points]


def _panels(machine: MovingMachine) -> list[Markup]:
    """Draw for each quantity of the output its exact curve, and the errors of all runs."""
    scene, at, found = machine.study.scene, machine.still / POSES, list[Markup]()
    motion = scene.motion(machine.angles[::2], scene.speed).point(scene.output)
    along, ends = np.linspace(0.0, 1.0, len(machine.angles[::2])), machine.ends
    for quantity in QUANTITIES:
        unit, factor = PAGE_UNITS[quantity]
        values = factor * getattr(motion, quantity)
        # Each component in a scale of its own: the 12 mm of a ram are a flat line beside a height of -420 mm.
        spans = np.ptp(values, axis=0)
        for k, name in enumerate("xy"):
            if spans[k] > STILL_SHARE * spans.max():
                curve = PanelCurve(along, values[:, k], -1, f'class="{name}"')
                found.append(panel_svg(f"{quantity} of {scene.output}: {name} [{unit}]", [curve], ends, at))
        errors = [line for k in range(len(machine.runs)) for line in _error_curves(machine, k, quantity)]
        found.append(panel_svg(f"{quantity}: error of {scene.output} / {NORMS[quantity]}", errors, ends, at, log=True))
    return found


def _error_curves(machine: MovingMachine, number: int, quantity: str) -> list[PanelCurve]:
    """Return the curve of a run's errors over the drawn range; empty if the run has no curves."""
    run, (first, last) = machine.runs[number], (machine.angles[0], machine.angles[-1])
    if not run.curves:
        return []
    curve = run.curves[machine.study.scene.output][quantity]
    along = (curve.error_angle - first) / (last - first)
    inside = (along >= 0.0) & (along <= 1.0)
    return [PanelCurve(along[inside], curve.error[inside], number, _stroke(machine, number))] if inside.any() else []
