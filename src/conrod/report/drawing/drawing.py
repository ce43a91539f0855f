"""A drawing of a scene's mechanism with its dimensions, from its exact poses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Pose, pin_points
from conrod.mechanism.units import MM
from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.dimensions import draw_dimensions
from conrod.report.drawing.links import draw_joints, draw_links
from conrod.report.drawing.machine_parts import Labels
from conrod.report.drawing.view import View, reached_points
from conrod.scenes import Scene

# Share of a pass to draw the machine at: in its middle links often lie in line or over each other.
TELLING_SHARE = 0.75
EXTENT_POINTS = 450.0  # on paper for the extent of a mechanism, roughly: dimensions take a quarter of the paper
MAX_SIDE, MIN_SIDE = 8.2, 4.6  # of the drawing [inch]
LEFT = 0.85  # room for the numbers and the label of the vertical axis [inch]
TRACE, ANGLE = "#2a8c6a", "#5b4a9c"
NAME_STYLE: dict[str, Any] = {"fontsize": 10.0, "fontweight": "bold"}
NAME_SIDES = np.array([(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])  # of a point, where its name may stand
NAME_DISTANCES = (1.0, 1.0), (1.0, 2.4), (2.6, 1.0)  # of a name: beside its point, and beyond the rails of a slide
# The crank itself hides a smaller angle.
MIN_DRAWN_ANGLE = math.radians(5.0)


def mechanism_svg(scene: Scene) -> str:
    """Draw a scene's mechanism as SVG text."""
    with drawing_style():
        return svg_text(mechanism_figure(scene))


def mechanism_figure(scene: Scene) -> Figure:
    """Draw a scene's mechanism with dimensions and the paths of its observed points."""
    angle = telling_angle(scene)
    view = view_at(scene, angle)
    for path in view.paths.values():
        view.axes.plot(*np.round(path, 6).T, color=TRACE, linewidth=2.2, alpha=0.35, zorder=2)
    draw_joints(view)
    draw_links(view)
    draw_observed(view)
    draw_frame_axes(view)
    draw_crank_angle(view, scene, angle)
    draw_dimensions(view)
    return _fit_page(view)


def telling_angle(scene: Scene) -> float:
    """Return the crank angle [rad] at which a scene is drawn."""
    span = scene.kinematics.mechanism.driver.span
    if span is not None:
        return span[0] + TELLING_SHARE * (span[1] - span[0])
    return math.radians(scene.drawn_at)


def view_at(scene: Scene, angle: float, axes: Axes | None = None) -> View:
    """Return an empty drawing of a scene at a crank angle [rad], on given axes or in a new figure."""
    mechanism = scene.mechanism()
    stacked = scene.kinematics.poses(np.array([angle]))[0].reshape(-1, 3)
    rounded = np.round(stacked * [MM, MM, 1.0], 9)
    poses: dict[str, Pose] = {
        b.name: (x / MM, y / MM, phi) for b, (x, y, phi) in zip(mechanism.bodies, rounded.tolist(), strict=True)
    }
    poses[GROUND] = (0.0, 0.0, 0.0)
    angles = np.linspace(*scene.kinematics.span, 181)
    paths = {name: MM * point.position for name, point in scene.motion(angles, scene.speed).points.items()}
    reached = np.concatenate([*paths.values(), MM * reached_points(mechanism, poses, scene.disc_radii())])
    extent = float(np.ptp(reached, axis=0).max())
    turn = scene.kinematics.poses(angles)
    size = 0.022 * extent
    if axes is None:
        figure = Figure()
        figure.set_layout_engine("none")
        axes = figure.subplots()
    labels = Labels(extent / EXTENT_POINTS)
    return View(axes, mechanism, poses, turn, size, labels, extent, paths, scene.disc_radii())


def _fit_page(view: View) -> Figure:
    """Give a drawing equal scales and a page that fits it."""
    axes, figure = view.axes, view.axes.figure
    assert isinstance(figure, Figure)
    axes.set_aspect("equal")
    axes.autoscale_view()
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    room = 0.06 * view.extent
    left, right, bottom, top = np.round([left - room, right + room, bottom - room, top + room], 3)
    width, height = right - left, top - bottom
    scale = MAX_SIDE / max(width, height)
    inches = max(MIN_SIDE, width * scale), max(MIN_SIDE, height * scale)
    figure.set_size_inches(inches[0] + LEFT, inches[1] + 0.6)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_anchor("C")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    low = LEFT / (inches[0] + LEFT), 0.5 / (inches[1] + 0.6)
    axes.set_position((*low, 0.98 - low[0], 0.99 - low[1]))
    return figure


# -- marks around the mechanism ----------------------------------------------------------------------------------------


def draw_observed(view: View) -> None:
    """Draw the observed points with their names."""
    for point in view.mechanism.observed:
        place = view.place_of(point.body, point.point)
        view.axes.plot(*place, marker="o", markersize=4.5, color=TRACE, zorder=12)
        half = 0.5 * view.labels.width(point.name, NAME_STYLE["fontsize"])
        reach = NAME_SIDES * (view.labels.point * np.array([7.0, 11.0]) + [half, 0.0])
        places = [one for far in NAME_DISTANCES for one in place + reach * far]
        _place_note(view, places, point.name, TRACE, NAME_STYLE)


def draw_crank_angle(view: View, scene: Scene, angle: float) -> None:
    """Draw the crank angle from its zero, and the sense of rotation with the speed."""
    driver, joint = view.mechanism.driver, view.mechanism.driven_joint
    shaft = view.place_of(joint.b, joint.point_b)
    now = crank_direction(view, shaft, angle)
    zero = now - driver.sense * angle
    reach = 5.0 * view.size
    if abs(angle) >= MIN_DRAWN_ANGLE:
        for direction, dashes in ((zero, (4, 3)), (now, (1, 2))):
            ray = np.array([shaft, shaft + 1.25 * reach * parts.unit_vector(direction)])
            view.axes.plot(*ray.T, color=ANGLE, linewidth=0.8, dashes=dashes, zorder=7)
        _draw_turn(view, shaft, reach, (zero, now), ANGLE)
        directions = 0.5 * (zero + now), now, zero
        centres = [shaft + factor * reach * parts.unit_vector(one) for factor in (1.5, 2.1) for one in directions]
        _place_note(view, centres, f"\N{GREEK SMALL LETTER THETA} = {math.degrees(angle):.0f} deg", ANGLE)
    _draw_sense(view, scene, shaft, now)


def crank_direction(view: View, shaft: Array, angle: float) -> float:
    """Return the direction [rad] of the crank at a crank angle: to its next pin, or its body's x-axis without one."""
    crank = view.mechanism.crank
    arms = [view.place_of(crank, point) - shaft for point in pin_points(view.mechanism, crank)]
    arm = next((arm for arm in arms if np.linalg.norm(arm) > 1e-6 * view.extent), None)
    return view.mechanism.crank_turn(angle) if arm is None else math.atan2(arm[1], arm[0])


def _draw_turn(view: View, centre: Array, radius: float, ends: tuple[float, float], colour: str) -> None:
    """Draw an arrow about a point between two directions [rad], and keep texts off it."""
    parts.draw_turn_arrow(view.axes, centre, radius, *ends, colour)
    angles = np.linspace(*ends, 60)
    arc = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    view.labels.add_line(arc)
    view.labels.add_symbol(arc[-1], 0.6 * view.size)


def _draw_sense(view: View, scene: Scene, shaft: Array, now: float) -> None:
    """Draw an arrow about the shaft in the sense of rotation, with the speed."""
    sense = view.mechanism.driver.sense * (1.0 if scene.speed > 0.0 else -1.0)
    rpm = numbers.quantity(abs(scene.speed) * numbers.SHOWN_UNITS["rad/s"][1])
    # Opposite to the crank, if there is room.
    beginnings = [now + math.pi - 0.6 * sense + turn for turn in (0.0, 0.7, -0.7, 1.4, -1.4)]
    centres = [shaft + 5.2 * view.size * parts.unit_vector(away + 0.8 * sense) for away in beginnings]
    away = beginnings[_place_note(view, centres, f"{rpm} rpm", parts.INK)]
    _draw_turn(view, shaft, 3.2 * view.size, (away, away + 1.6 * sense), parts.INK)


def _place_note(
    view: View, centres: Sequence[Array], text: str, colour: str, look: Mapping[str, Any] = parts.TEXT_STYLE
) -> int:
    """Draw a text at the place with most room, and return the index of the place."""
    boxes = [view.labels.box(centre, text, look["fontsize"]) for centre in centres]
    best = view.labels.best_place([(box, ()) for box in boxes])
    view.labels.add_text(boxes[best])
    parts.draw_note(view.axes, centres[best], text, colour, look=look)
    return best


def draw_frame_axes(view: View) -> None:
    """Draw the axes x and y of the scene's frame from its origin."""
    for direction, name, aside in ((0.0, "x", 0.5 * math.pi), (0.5 * math.pi, "y", math.pi)):
        tip = 6.5 * view.size * parts.unit_vector(direction)
        parts.draw_arrow(view.axes, np.zeros(2), tip, "#888888")
        _place_note(view, [tip + 1.1 * view.size * parts.unit_vector(aside)], name, "#666666")
