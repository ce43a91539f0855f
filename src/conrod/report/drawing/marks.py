"""Marks beside the mechanism: names of points, the crank angle, the sense of rotation, the axes."""

from __future__ import annotations

import math

import numpy as np

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.view import View
from conrod.scenes import Scene

TRACE, ANGLE = "#2a8c6a", "#5b4a9c"
NAME = 10  # font size of a point's name [pt]
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
        view.labels.take(_named(view, place, point.name))
        view.axes.annotate(
            point.name,
            (float(place[0]), float(place[1])),
            xytext=(-9, 9),
            textcoords="offset points",
            ha="right",
            color=TRACE,
            fontweight="bold",
            fontsize=NAME,
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
        # The documents of the scenes with a closed form write t for the crank angle.
        letter = "t" if scene.closed_form else "\N{GREEK SMALL LETTER THETA}"
        middle = 0.5 * (driver.start + now)
        ways = [(1.5, middle), (1.5, now), (1.5, driver.start), (2.1, middle), (2.1, driver.start), (2.1, now)]
        centres = [shaft + factor * reach * parts.unit(direction) for factor, direction in ways]
        _note(view, centres, f"{letter} = {math.degrees(angle):.0f} deg", ANGLE)
    _sense(view, scene, shaft, now)


def _sense(view: View, scene: Scene, shaft: Array, now: float) -> None:
    """An arrow about the shaft in the sense of rotation, with the speed."""
    sense = view.mechanism.driver.sense * (1.0 if scene.speed > 0.0 else -1.0)
    rpm = numbers.quantity(abs(scene.speed) * numbers.SHOWN_UNITS["rad/s"][1])
    # Opposite to the crank, if there is room.
    beginnings = [now + math.pi - 0.6 * sense + turn for turn in (0.0, 0.7, -0.7, 1.4, -1.4)]
    centres = [shaft + 5.2 * view.size * parts.unit(away + 0.8 * sense) for away in beginnings]
    away = beginnings[_note(view, centres, f"{rpm} rpm", parts.INK)]
    parts.turn_arrow(view.axes, shaft, 3.2 * view.size, away, away + 1.6 * sense, parts.INK)


def _note(view: View, centres: list[Array], text: str, colour: str) -> int:
    """A text at that of some places where it has room; which it is."""
    boxes = [view.labels.box(centre, text, parts.TEXT["fontsize"]) for centre in centres]
    best = view.labels.best([(box, ()) for box in boxes])
    view.labels.take(boxes[best])
    parts.note(view.axes, centres[best], text, colour)
    return best


def _named(view: View, place: Array, name: str) -> Array:
    """Corners (4, 2) of the name beside an observed point."""
    width = view.labels.box(np.zeros(2), name, NAME)[1, 0]
    return view.labels.box(place + np.array([-width - 0.4 * view.size, 1.2 * view.size]), name, NAME)


def reserve_axes(view: View) -> None:
    """Keep the places of the axes' names free."""
    for _, at, name in _axes(view):
        view.labels.take(view.labels.box(at, name, parts.TEXT["fontsize"]))


def draw_frame_axes(view: View) -> None:
    """The document's axes x and y, from its origin."""
    for tip, at, name in _axes(view):
        parts.arrow(view.axes, np.zeros(2), tip, "#888888")
        parts.note(view.axes, at, name, "#666666", ground=False)


def _axes(view: View) -> list[tuple[Array, Array, str]]:
    """Tip, place of the name and name of the two axes."""
    reach = 6.5 * view.size
    found = []
    for direction, name, aside in ((0.0, "x", math.pi / 2.0), (math.pi / 2.0, "y", math.pi)):
        tip = reach * parts.unit(direction)
        found.append((tip, tip + 1.1 * view.size * parts.unit(aside), name))
    return found
