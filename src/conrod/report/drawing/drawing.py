"""A drawing of a scene's mechanism with its dimensions, made from its mechanism and its exact poses."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from conrod.mechanism.mechanism import GROUND, Pose
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.drawing.dimension_marks import draw_dimensions
from conrod.report.drawing.joints import draw_joints, draw_links
from conrod.report.drawing.label_placement import LabelPlacement
from conrod.report.drawing.marks import draw_crank_angle, draw_frame_axes, draw_observed, draw_paths, reserve_axes
from conrod.report.drawing.view import MM, View, outline
from conrod.scenes import Scene

# Of a pass, because links often lie in line or over each other in its middle.
TELLING_PART = 0.75
POINTS = 450.0  # on paper for the extent of a mechanism, about: what is beside it takes a quarter of the paper
LARGEST_SIDE, LEAST_SIDE = 8.2, 4.6  # of the drawing [inch]


def mechanism_svg(scene: Scene) -> str:
    """The drawing as SVG text."""
    with drawing_style():
        return svg_text(mechanism_figure(scene))


def mechanism_figure(scene: Scene) -> Figure:
    """The mechanism at a telling crank angle, with the paths of the observed points over a turn."""
    angle = telling_angle(scene)
    view = _view(scene, angle)
    draw_paths(view)
    draw_joints(view)
    draw_links(view)
    draw_observed(view)
    reserve_axes(view)
    draw_crank_angle(view, scene, angle)
    draw_frame_axes(view)
    draw_dimensions(view)
    return _framed(view)


def telling_angle(scene: Scene) -> float:
    """The crank angle [rad] that a scene is drawn at."""
    span = scene.kinematics.mechanism.driver.span
    if span is not None:
        return span[0] + TELLING_PART * (span[1] - span[0])
    return math.radians(scene.drawn_at)


def _view(scene: Scene, angle: float) -> View:
    mechanism = scene.mechanism()
    stacked = scene.kinematics.poses(np.array([angle]))[0].reshape(-1, 3)
    rounded = np.round(stacked * [MM, MM, 1.0], 9)
    poses: dict[str, Pose] = {
        b.name: (x / MM, y / MM, phi) for b, (x, y, phi) in zip(mechanism.bodies, rounded.tolist(), strict=True)
    }
    poses[GROUND] = (0.0, 0.0, 0.0)
    angles = np.linspace(*scene.kinematics.span, 181)
    paths = {name: MM * point.position for name, point in scene.motion(angles, scene.speed).points.items()}
    reached = np.concatenate([*paths.values(), MM * outline(mechanism, poses)])
    extent = float(np.ptp(reached, axis=0).max())
    turn = scene.kinematics.poses(angles)
    # The angles and the sides of the dimensions of the scenes with a closed form were chosen for them.
    labels = LabelPlacement(extent / POINTS, first=scene.closed_form)
    axes, size = Figure().subplots(), 0.022 * extent
    return View(axes, mechanism, poses, turn, size, labels, extent=extent, paths=paths)


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
