"""How points stand and look in a work-precision diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from conrod.motion import Array
from conrod.report.canvas import on_log_grid
from conrod.report.styles import colour
from conrod.studies.sweep_results import SweptPoint

DOTS = {"mujoco": "o", "pymunk": "D"}
FRONT_OF_ALL: dict[str, Any] = {"color": "#c4c4c4", "linewidth": 7.0, "zorder": 1, "solid_capstyle": "round"}


def drawn_costs(points: Sequence[SweptPoint]) -> Array:
    """Measured costs [s], on the grid that is drawn."""
    return on_log_grid(np.array([point.cost or 0.0 for point in points]))


def drawn_errors(points: Sequence[SweptPoint], quantity: str) -> Array:
    """Errors, on the grid that is drawn."""
    return on_log_grid(np.array([point.error(quantity) or 0.0 for point in points]))


def dot_style(engine: str) -> dict[str, Any]:
    """Arguments of `Axes.plot` for runs that are nothing in particular."""
    return {
        "linestyle": "none",
        "marker": DOTS.get(engine, "s"),
        "markersize": 2.6,
        "color": colour(engine),
        "alpha": 0.35,
        "markeredgewidth": 0.0,
        "zorder": 2,
    }


def front_style(engine: str) -> dict[str, Any]:
    """Arguments of `Axes.plot` for the front of an engine."""
    hue = colour(engine)
    marked = {"marker": DOTS.get(engine, "s"), "markersize": 4.0, "markeredgecolor": "white", "markeredgewidth": 0.5}
    return {"color": hue, "linewidth": 2.2, "alpha": 0.9, "zorder": 6, "linestyle": "-", **marked}
