"""What a drawing says beside the mechanism: names of points, the crank angle, the sense of rotation, the axes."""

from __future__ import annotations

import math

import numpy as np

from conrod.report import machine_parts as parts
from conrod.report import numbers
from conrod.report.view import View
from conrod.scenes import Scene

TRACE, ANGLE = "#2a8c6a", "#5b4a9c"
# An angle as small as this is hidden by the crank itself.
LEAST_ANGLE = math.radians(5.0)


def draw_paths(view: View) -> None:
    """The paths of the observed points."""
    for path in view.paths.values():
        view.axes.plot(*np.round(path, 6).T, color=TRACE, linewidth=2.2, alpha=0.35, zorder=2)


def draw_observed(view: View) -> None:
    """The observed points with their names."""
    for point in view.mechanism.observed:
        place = view.place(point.body, point.point)
        view.axes.plot(*place, marker="o", markersize=4.5, color=TRACE, zorder=12)
        view.axes.annotate(
            point.name,
            (float(place[0]), float(place[1])),
            xytext=(-9, 9),
            textcoords="offset points",
            ha="right",
            color=TRACE,
            fontweight="bold",
            fontsize=10,
            bbox=parts.HALO,
            zorder=21,
        )


def draw_crank_angle(view: View, scene: Scene, angle: float) -> None:
    """The crank angle from its zero, and the sense of rotation at the scene's speed."""
    driver, joint = view.mechanism.driver, view.mechanism.driven_joint
    shaft = view.place(joint.b, joint.point_b)
    now = view.mechanism.crank_turn(angle)
    reach = 5.0 * view.size
    if abs(angle) >= LEAST_ANGLE:
        for direction, dashes in ((driver.start, (4, 3)), (now, (1, 2))):
            ray = np.array([shaft, shaft + 1.25 * reach * parts.unit(direction)])
            view.axes.plot(*ray.T, color=ANGLE, linewidth=0.8, dashes=dashes, zorder=7)
        parts.turn_arrow(view.axes, shaft, reach, driver.start, now, ANGLE)
        middle = 0.5 * (driver.start + now)
        # The documents of the scenes with a closed form write t for the crank angle.
        letter = "t" if scene.closed_form else "\N{GREEK SMALL LETTER THETA}"
        text = f"{letter} = {math.degrees(angle):.0f} deg"
        parts.note(view.axes, shaft + 1.5 * reach * parts.unit(middle), text, ANGLE)
    sense = driver.sense * (1.0 if scene.speed > 0.0 else -1.0)
    away = now + math.pi - 0.6 * sense
    parts.turn_arrow(view.axes, shaft, 3.2 * view.size, away, away + 1.6 * sense, parts.INK)
    rpm = numbers.quantity(abs(scene.speed) * numbers.SHOWN_UNITS["rad/s"][1])
    parts.note(view.axes, shaft + 5.2 * view.size * parts.unit(away + 0.8 * sense), f"{rpm} rpm", parts.INK)


def draw_frame_axes(view: View) -> None:
    """The document's axes x and y, from its origin."""
    reach = 6.5 * view.size
    for direction, name, aside in ((0.0, "x", math.pi / 2.0), (math.pi / 2.0, "y", math.pi)):
        tip = reach * parts.unit(direction)
        parts.arrow(view.axes, np.zeros(2), tip, "#888888")
        parts.note(view.axes, tip + 1.1 * view.size * parts.unit(aside), name, "#666666", ground=False)
