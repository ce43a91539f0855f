"""The convex hull of points in a plane."""

from __future__ import annotations

import numpy as np

from conrod.motion import Array


def convex_hull(points: Array) -> Array:
    """Corners (C, 2) of the convex hull of points (N, 2), counter-clockwise (Andrew's monotone chain).

    Points between two corners are left out; of points in one line the two ends remain.
    """
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if len(ordered) == 1:
        return np.array(ordered)

    def chain(some: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for p in some:
            while len(kept) > 1 and _turn(kept[-2], kept[-1], p) <= 0.0:
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
