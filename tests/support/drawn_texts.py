"""Texts of a figure that lie over each other."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox


def overlaps(drawn: Figure, apart: float = 0.45) -> list[tuple[str, str]]:
    """Texts whose letters overlap, tried with points along their middle lines.

    Args:
        apart: so many heights of a text a middle line may come near its own.
    """
    renderer = FigureCanvasAgg(drawn).get_renderer()  # type: ignore[no-untyped-call]  # of the library
    boxes = []
    for text in (text for text in drawn.axes[0].texts if text.get_text()):
        turned = text.get_rotation()
        text.set_rotation(0.0)
        text.set_bbox(None)
        boxes.append((text.get_text(), text.get_window_extent(renderer), np.radians(turned)))
        text.set_rotation(turned)
    return [(a[0], b[0]) for a, b in combinations(boxes, 2) if _touch(a, b, apart) or _touch(b, a, apart)]


def _touch(one: tuple[str, Bbox, float], other: tuple[str, Bbox, float], apart: float) -> bool:
    middles = [np.array([(b.x0 + b.x1) / 2.0, (b.y0 + b.y1) / 2.0]) for b in (one[1], other[1])]
    along = np.array([np.cos(one[2]), np.sin(one[2])])
    points = middles[0] + np.outer(np.linspace(-0.48, 0.48, 60) * one[1].width, along)
    turn = np.array([[np.cos(other[2]), np.sin(other[2])], [-np.sin(other[2]), np.cos(other[2])]])
    inside = np.abs((points - middles[1]) @ turn.T) < np.array([0.45 * other[1].width, apart * other[1].height])
    return bool(inside.all(axis=1).any())
