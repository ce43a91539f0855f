"""Panels of curves in a page, each a small SVG with a cursor that the page's script moves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup, escape

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.html.parts import points_text, svg_number
from conrod.report.numbers import ROUNDING

# Edges of the plot in an SVG of 400 by 145 units; machine.js and links.js know LEFT and RIGHT too.
LEFT, RIGHT, TOP, BOTTOM = 52.0, 386.0, 24.0, 122.0
MAX_LABELS = 4  # on a linear axis
MAX_DECADE_LABELS = 4  # on an axis
AXIS_TICKS = 5  # on the axis of the crank angle, or of the other quantity
CRANK_ANGLE = ("the crank angle in degrees", "deg")


class PanelCurve(NamedTuple):
    """A curve of a panel.

    Attributes:
        along: abscissae (K,), shares of the drawn range of the axis.
        values: ordinates (K,).
        run: number of the run; -1 for the exact motion.
        look: SVG attributes."""

    along: Array
    values: Array
    run: int
    look: str


def panel_svg(
    title: str, lines: Sequence[PanelCurve], ends: tuple[float, float], at: float, log: bool = False,
    axis: tuple[str, str] = CRANK_ANGLE,
) -> Markup:  # fmt: skip
    """Draw curves against the crank angle, or another quantity, as SVG, with a cursor.

    Args:
        title: title of the panel.
        lines: the curves.
        ends: first and last crank angle [deg], or values of the other quantity.
        at: place of the cursor, a share of the range.
        log: True for a logarithmic scale.
        axis: quantity along the axis, with its unit, in words, and the unit's sign.
    """
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
    for share in np.linspace(0.0, 1.0, AXIS_TICKS):
        along = ends[0] + share * (ends[1] - ends[0])
        text = f"{along:.0f}" if axis is CRANK_ANGLE else numbers.quantity(along, 3)
        place, anchor = (_cursor_x(share), "middle") if share < 1.0 else (400.0, "end")
        unit = "" if share < 1.0 else f" {axis[1]}"
        marks += f'<text x="{place:.0f}" y="{BOTTOM + 16}" text-anchor="{anchor}">{text}{unit}</text>'
    drawn = "".join(_curve_path(line, y(line.values)) for line in lines)
    cursor = f'<line class="cursor" x1="{_cursor_x(at):.1f}" x2="{_cursor_x(at):.1f}" y1="{TOP}" y2="{BOTTOM}"/>'
    kind = ' data-log="1"' if log else ""
    return Markup(  # made of numbers and escaped texts
        f'<svg class="curves" viewBox="0 0 400 145" data-low="{low:.6g}" data-high="{high:.6g}"'
        f'{kind} role="img" aria-label="{escape(title)}, against {axis[0]}">'
        f'<text x="0" y="12" class="title">{escape(title)}</text>'
        f'<text x="{RIGHT}" y="12" text-anchor="end" class="value"></text>{marks}{drawn}{cursor}</svg>'
    )


def axis_ticks(low: float, high: float) -> tuple[Array, list[str]]:
    """Return round values within an interval, with zero if the interval contains it, and their texts."""
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
