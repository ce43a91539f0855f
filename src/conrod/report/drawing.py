"""A drawing of a scene's mechanism with its dimensions, made from its mechanism and its exact poses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import assert_never

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.files import write_whole
from conrod.mechanism import GROUND, CamContact, Mechanism, Pose, Prismatic, Revolute, to_world
from conrod.motion import Array
from conrod.report import machine_parts as parts
from conrod.report import numbers
from conrod.report.canvas import drawing_style, svg_text
from conrod.report.dimensions import Length, dimensions
from conrod.report.outlines import outline, pitch_lines, profile
from conrod.rolling import Rack, Rolling
from conrod.scenes import Scene

MM = 1e3
# Where the links stand clear of each other and of the frame.
TELLING_ANGLES = {"shear-press": 50.0, "saw": 60.0, "cam-follower": 120.0}  # [deg]
OTHERWISE = 60.0
TRACE, ANGLE = "#2a8c6a", "#5b4a9c"
LARGEST_SIDE, LEAST_SIDE = 8.2, 4.6  # of the drawing [inch]


@dataclass(frozen=True)
class View:
    """What the parts of a drawing share; lengths in mm."""

    axes: Axes
    mechanism: Mechanism
    poses: dict[str, Pose]  # x and y in mm
    paths: dict[str, Array]  # of the observed points over a turn, (T, 2)
    size: float  # of a symbol
    extent: float  # of the mechanism


def draw_mechanism(scene: Scene, path: Path) -> None:
    """Write the drawing as an SVG file, whole or not at all."""
    write_whole(path, mechanism_svg(scene))


def mechanism_svg(scene: Scene) -> str:
    """The drawing as SVG text."""
    with drawing_style():
        return svg_text(mechanism_figure(scene))


def mechanism_figure(scene: Scene) -> Figure:
    """The mechanism at a telling crank angle, with the paths of the observed points over a turn."""
    # A machine from a file may have any name, also one of these.
    angle = math.radians(TELLING_ANGLES[scene.kind] if scene.closed_form else OTHERWISE)
    if scene.kinematics.mechanism.driver.span is not None:
        angle = float(np.mean(scene.kinematics.span))
    view = _view(scene, angle)
    _paths(view)
    _joints(view)
    _links(view)
    _observed(view)
    _crank_angle(view, scene, angle)
    _frame_axes(view)
    for dimension in dimensions(view.mechanism, _in_metres(view.poses)):
        if isinstance(dimension, Length):
            start, stop = MM * np.array(dimension.start), MM * np.array(dimension.stop)
            if np.linalg.norm(stop - start) > 1e-6 * view.extent:
                parts.length_line(view.axes, dimension, start, stop, view.extent)
        else:
            parts.radius_line(view.axes, dimension, MM * np.array(dimension.centre), MM * dimension.radius)
    return _framed(view)


def _view(scene: Scene, angle: float) -> View:
    mechanism = scene.mechanism()
    stacked = scene.kinematics.poses(np.array([angle]))[0].reshape(-1, 3)
    rounded = np.round(stacked * [MM, MM, 1.0], 9)
    poses: dict[str, Pose] = {b.name: (p[0], p[1], p[2]) for b, p in zip(mechanism.bodies, rounded, strict=True)}
    poses[GROUND] = (0.0, 0.0, 0.0)
    turn = scene.motion(np.linspace(*scene.kinematics.span, 181), scene.speed)
    paths = {name: MM * point.position for name, point in turn.points.items()}
    reached = np.concatenate([*paths.values(), *([MM * outline(mechanism, _in_metres(poses))])])
    extent = float(np.ptp(reached, axis=0).max())
    return View(Figure().subplots(), mechanism, poses, paths, 0.022 * extent, extent)


def _in_metres(poses: dict[str, Pose]) -> dict[str, Pose]:
    return {name: (x / MM, y / MM, phi) for name, (x, y, phi) in poses.items()}


def _world(view: View, body: str, point: tuple[float, float]) -> Array:
    return np.array(to_world(view.poses[body], (MM * point[0], MM * point[1])))


def _paths(view: View) -> None:
    for path in view.paths.values():
        view.axes.plot(*np.round(path, 6).T, color=TRACE, linewidth=2.2, alpha=0.35, zorder=2)


def _joints(view: View) -> None:
    for joint in view.mechanism.joints:
        match joint:
            case Revolute():
                centre = _world(view, joint.b, joint.point_b)
                place = (float(centre[0]), float(centre[1]))
                if joint.a == GROUND:
                    parts.bearing(view.axes, place, view.size)
                parts.pin(view.axes, place, view.size)
            case Prismatic():
                _slide(view, joint)
            case CamContact():
                _cam(view, joint)
            case Rolling() | Rack():
                for line in pitch_lines(joint, _in_metres(view.poses)):
                    view.axes.plot(*(MM * line).T, color=parts.INK, linewidth=1.2, linestyle="-.", zorder=5)
            case _:
                assert_never(joint)


def _slide(view: View, joint: Prismatic) -> None:
    direction = view.poses[joint.a][2] + joint.direction
    along = parts.unit(direction)
    line = _world(view, joint.a, joint.point_a)
    block = _world(view, joint.b, joint.point_b)
    travel = [(path - line) @ along for name, path in view.paths.items() if _body_of(view, name) == joint.b]
    places = np.concatenate([*travel, [float((block - line) @ along)]])
    room = 2.4 * view.size
    # A cam's follower is guided above its roller, or the rails would hide the cam.
    if any(contact.b == joint.b for contact in view.mechanism.cam_contacts):
        block = block + 5.0 * view.size * along
        view.axes.plot(*np.array([block, _world(view, joint.b, joint.point_b)]).T, color=parts.LINK, linewidth=4)
        top = places.max() + 9.0 * view.size
        parts.guide(view.axes, line, (top - 5.0 * view.size, top), direction, view.size)
        tip = line + (top + 1.5 * view.size) * along
        view.axes.plot(*np.array([block, tip]).T, color=parts.LINK, linewidth=4, alpha=0.75, zorder=4)
        return
    parts.guide(view.axes, line, (places.min() - room, places.max() + room), direction, view.size)
    parts.slider(view.axes, block, direction, view.size)


def _body_of(view: View, point: str) -> str:
    return next(o.body for o in view.mechanism.observed if o.name == point)


def _cam(view: View, contact: CamContact) -> None:
    pose = view.poses[contact.a]
    outline = MM * np.array(profile(contact, _in_metres(view.poses)[contact.a]))
    view.axes.fill(*outline.T, facecolor="#dde6ec", edgecolor="none", zorder=1)
    view.axes.plot(*outline.T, color=parts.INK, linewidth=1.4, zorder=5)
    for end, normal in zip(*contact.profile.joints(), strict=True):
        place = np.array(to_world(pose, (MM * end[0], MM * end[1])))
        outward = np.array(to_world((0.0, 0.0, pose[2]), (normal[0], normal[1])))
        ends = np.array([place - 0.4 * view.size * outward, place + 0.4 * view.size * outward])
        view.axes.plot(*ends.T, color=parts.INK, linewidth=1.4, zorder=6)
    roller = _world(view, contact.b, contact.roller_centre)
    ring = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = roller + MM * contact.roller_radius * np.column_stack([np.cos(ring), np.sin(ring)])
    view.axes.fill(*circle.T, facecolor="white", edgecolor=parts.INK, linewidth=1.4, zorder=7)


def _links(view: View) -> None:
    """A bar through the pins of every body that has at least two."""
    for body in view.mechanism.bodies:
        ends = [
            to_world(view.poses[body.name], (MM * point[0], MM * point[1]))
            for joint in view.mechanism.joints
            if isinstance(joint, Revolute)
            for name, point in ((joint.a, joint.point_a), (joint.b, joint.point_b))
            if name == body.name
        ]
        if len(ends) > 1:
            parts.link(view.axes, ends, 6.0)


def _observed(view: View) -> None:
    for point in view.mechanism.observed:
        place = _world(view, point.body, point.point)
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


def _crank_angle(view: View, scene: Scene, angle: float) -> None:
    """The crank angle from its zero, and the sense of rotation at the scene's speed."""
    driver, joint = view.mechanism.driver, view.mechanism.driven_joint
    shaft = _world(view, joint.b, joint.point_b)
    now = view.mechanism.crank_turn(angle)
    reach = 5.0 * view.size
    for direction, dashes in ((driver.start, (4, 3)), (now, (1, 2))):
        ray = np.array([shaft, shaft + 1.25 * reach * parts.unit(direction)])
        view.axes.plot(*ray.T, color=ANGLE, linewidth=0.8, dashes=dashes, zorder=7)
    parts.turn_arrow(view.axes, shaft, reach, driver.start, now, ANGLE)
    middle = 0.5 * (driver.start + now)
    parts.note(view.axes, shaft + 1.5 * reach * parts.unit(middle), f"t = {math.degrees(angle):.0f} deg", ANGLE)
    sense = driver.sense * (1.0 if scene.speed > 0.0 else -1.0)
    away = now + math.pi - 0.6 * sense
    parts.turn_arrow(view.axes, shaft, 3.2 * view.size, away, away + 1.6 * sense, parts.INK)
    rpm = numbers.quantity(abs(scene.speed) * numbers.SHOWN_UNITS["rad/s"][1])
    parts.note(view.axes, shaft + 5.2 * view.size * parts.unit(away + 0.8 * sense), f"{rpm} rpm", parts.INK)


def _frame_axes(view: View) -> None:
    """The document's axes x and y, from its origin."""
    reach = 6.5 * view.size
    for direction, name, aside in ((0.0, "x", math.pi / 2.0), (math.pi / 2.0, "y", math.pi)):
        tip = reach * parts.unit(direction)
        parts.arrow(view.axes, np.zeros(2), tip, "#888888")
        parts.note(view.axes, tip + 1.1 * view.size * parts.unit(aside), name, "#666666", ground=False)


def _framed(view: View) -> Figure:
    """Equal scales, and a page that fits the drawing."""
    axes, figure = view.axes, view.axes.figure
    assert isinstance(figure, Figure)
    axes.set_aspect("equal")
    axes.autoscale_view()
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    room = 0.06 * view.extent
    left, right, bottom, top = np.round([left - room, right + room, bottom - room, top + room], 3)
    width, height = right - left, top - bottom
    scale = LARGEST_SIDE / max(width, height)
    inches = max(LEAST_SIDE, width * scale), max(LEAST_SIDE, height * scale)
    figure.set_size_inches(inches[0] + 0.7, inches[1] + 0.6)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_anchor("C")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    figure.subplots_adjust(left=0.7 / (inches[0] + 0.7), right=0.98, bottom=0.5 / (inches[1] + 0.6), top=0.99)
    return figure
