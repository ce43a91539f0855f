"""Curves against the crank angle as small SVGs, with a cursor that a page can move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from conrod.exact.motion import Array
from conrod.report.numbers import ROUNDING

# Edges of the area in a drawing of 400 by 145; machine.js knows those at the sides.
LEFT, RIGHT, TOP, BOTTOM = 52.0, 386.0, 24.0, 122.0
MOST_DECADES = 4  # that are named
TICKS = 5  # of the angle


@dataclass(frozen=True)
class Line:
    """A curve.

    Attributes:
        along: (K,) part of the stretch of the crank angle, from 0 to 1.
        values: (K,).
        run: number of the engine's run; -1 of the exact motion.
        look: attributes of SVG.
    """

    along: Array
    values: Array
    run: int
    look: str


def panel(title: str, lines: Sequence[Line], ends: tuple[float, float], at: float, log: bool = False) -> Markup:
    """Curves over a stretch of the crank angle [deg] with a cursor at a part of it; errors on a logarithmic scale."""
    values = np.concatenate([line.values for line in lines] or [np.zeros(1)])
    if log:
        values = np.log10(np.maximum(values, ROUNDING))
        low, high = (
            float(np.floor(values.min())),
            max(float(np.ceil(values.max())), float(np.floor(values.min())) + 1.0),
        )
        ticks = np.arange(high, low - 1.0, -np.ceil((high - low) / MOST_DECADES))
        names = [f"1e{tick:.0f}" for tick in ticks]
    else:
        low, high = float(values.min()), float(values.max()) or 1.0
        ticks = np.array([low, high])
        names = [f"{tick:.3g}" for tick in ticks]
    span = (high - low) or 1.0

    def y(value: Array) -> Array:
        return np.asarray(BOTTOM - (BOTTOM - TOP) * (value - low) / span)

    marks = "".join(
        f'<path class="grid" d="M{LEFT} {h:.1f}H{RIGHT}"/>'
        f'<text x="{LEFT - 4}" y="{h + 4:.1f}" text-anchor="end">{name}</text>'
        for h, name in zip(y(ticks), names, strict=True)
    )
    for share in np.linspace(0.0, 1.0, TICKS):
        degrees = f"{ends[0] + share * (ends[1] - ends[0]):.0f}"
        place, anchor = (_x(share), "middle") if share < 1.0 else (400.0, "end")
        unit = "" if share < 1.0 else " deg"
        marks += f'<text x="{place:.0f}" y="{BOTTOM + 16}" text-anchor="{anchor}">{degrees}{unit}</text>'
    drawn = "".join(
        _path(line, y(np.log10(np.maximum(line.values, ROUNDING)) if log else line.values)) for line in lines
    )
    cursor = f'<line class="cursor" x1="{_x(at):.1f}" x2="{_x(at):.1f}" y1="{TOP}" y2="{BOTTOM}"/>'
    return Markup(  # of numbers and of texts that are escaped
        f'<svg class="curves" viewBox="0 0 400 145" role="img" aria-label="{escape(title)}, against the crank angle in '
        f'degrees"><text x="0" y="12" class="title">{escape(title)}</text>{marks}{drawn}{cursor}</svg>'
    )


def _x(share: float) -> float:
    return LEFT + (RIGHT - LEFT) * share


def _path(line: Line, heights: Array) -> str:
    places = " ".join(f"{_x(share):.1f},{h:.1f}" for share, h in zip(line.along, heights, strict=True))
    return f'<path data-run="{line.run}" d="M{places}" {line.look}/>'
