"""The links and joints of a drawing: bars, plates and slots, pins, slides, cams and pitch lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

import numpy as np
from matplotlib.patches import Polygon
from scipy.spatial import ConvexHull

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Prismatic, Rack, Revolute, Rolling, pin_points, to_world
from conrod.mechanism.slide import Slide, guide_and_block
from conrod.mechanism.units import MM
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.view import View, cam_outline, pitch_lines, slide_displacements

BAR_WIDTH = 6.0  # of a link [pt]
COLLINEAR_SHARE = 0.01  # of a line's length, by which places may lie off it: less than a bar's width
DISC_POINTS = 121  # of a disc's outline
SLOT_TOLERANCE = 1e-3  # [rad] of a whole turn, within which a wheel's slots repeat
PLACE_DIGITS = 6  # decimals of places [mm]: places that joints share differ by rounding


def draw_joints(view: View) -> None:
    """Draw pins with their bearings, slides, cams with their rollers, and pitch lines."""
    for joint in view.mechanism.joints:
        match joint:
            case Revolute():
                centre = view.place_of(joint.b, joint.point_b)
                place = (float(centre[0]), float(centre[1]))
                if GROUND in (joint.a, joint.b):
                    parts.draw_bearing(view.axes_of(GROUND), place, view.size)
                    view.labels.add_symbol(centre - np.array([0.0, 0.9 * view.size]), 0.9 * view.size)
                parts.draw_pin(view.axes_of(joint.a, joint.b), place, view.size)
                view.labels.add_symbol(centre, 0.35 * view.size)
            case Prismatic():
                _draw_slide(view, joint)
            case CamContact():
                _draw_cam(view, joint)
            case Rolling() | Rack():
                for body, line in zip(
                    (joint.a, joint.b), map(view.to_drawing, pitch_lines(joint, view.poses)), strict=True
                ):
                    view.axes_of(body).plot(*line.T, color=parts.INK, linewidth=1.2, linestyle="-.", zorder=5)
                    view.labels.add_line(line)
            case _:
                assert_never(joint)


def draw_links(view: View) -> None:
    """Draw every body as a bar or plate through its joints, slots and observed points, and discs behind them."""
    slots: dict[str, list[Array]] = {body.name: [] for body in view.mechanism.bodies}
    blocks: dict[str, list[Array]] = {body.name: [] for body in view.mechanism.bodies}
    for joint in view.mechanism.joints:
        if isinstance(joint, Prismatic):
            slide = guide_and_block(view.mechanism, joint)
            blocks[slide.moving].append(view.place_of(slide.moving, slide.point))
            if slide.guide != GROUND:
                slots[slide.guide].append(_slot_ends(view, slide))
    # What rolls has its pitch line already.
    rolling = {name for mesh in view.mechanism.meshes for name in (mesh.a, mesh.b)}
    for name in (name for name in view.discs if name not in rolling):
        _draw_disc(view, name, slots[name])
    for body in view.mechanism.bodies:
        held = [view.place_of(body.name, point) for point in pin_points(view.mechanism, body.name)] + blocks[body.name]
        # A link reaches to the near end of its slot, and is the slot from there on.
        near = [
            min(ends, key=lambda end: float(np.linalg.norm(end - pin))) for pin in held[:1] for ends in slots[body.name]
        ]
        seen = [view.place_of(body.name, point.point) for point in view.mechanism.observed if point.body == body.name]
        _draw_body(view, body.name, link_outline(held + near + seen))


def _slide_range(view: View, slide: Slide) -> tuple[float, float]:
    """Return the range of a block's displacement over a turn from where it is drawn [mm]."""
    gone = MM * slide_displacements(slide, view.poses_over_turn(slide.guide), view.poses_over_turn(slide.moving))
    now = MM * slide_displacements(slide, np.array([view.poses[slide.guide]]), np.array([view.poses[slide.moving]]))[0]
    return float(min(gone.min() - now, 0.0)), float(max(gone.max() - now, 0.0))


def _slot_ends(view: View, slide: Slide) -> Array:
    """Return the ends (2, 2) [mm] of a slot as long as its block's displacement over a turn."""
    back, forth = _slide_range(view, slide)
    block, room = view.place_of(slide.moving, slide.point), 2.0 * view.size
    along = parts.unit_vector(view.poses[slide.guide][2] + slide.direction)
    return np.asarray(block + np.outer((back - room, forth + room), along))


def _draw_slide(view: View, joint: Prismatic) -> None:
    slide = guide_and_block(view.mechanism, joint)
    direction = view.poses[slide.guide][2] + slide.direction
    block = view.place_of(slide.moving, slide.point)
    if slide.guide != GROUND:
        parts.draw_slot(view.axes_of(slide.guide), _slot_ends(view, slide), view.size)
        view.labels.add_symbol(block, 1.5 * view.size)
        parts.draw_slider(view.axes_of(slide.moving), block, direction, view.size)
        return
    back, forth = _slide_range(view, slide)
    # A cam's follower is guided above its roller, or the rails would hide the cam.
    if any(contact.b == slide.moving for contact in view.mechanism.cam_contacts):
        _draw_stem(view, slide.moving, block, forth, direction)
        return
    room = 2.4 * view.size
    _draw_rails(view, block, (back - room, forth + room), direction)
    view.labels.add_symbol(block, 1.5 * view.size)
    parts.draw_slider(view.axes_of(slide.moving), block, direction, view.size)


def _draw_rails(view: View, block: Array, reach: tuple[float, float], direction: float) -> None:
    """Draw a slide's two hatched rails along a direction [rad] through a block."""
    parts.draw_rails(view.axes_of(GROUND), block, reach, direction, view.size)
    ends = block + np.outer(reach, parts.unit_vector(direction))
    half = 0.5 * (reach[1] - reach[0]), 0.25 * view.size
    for aside in (-1.4, 1.4):
        middle = ends.mean(axis=0) + aside * view.size * parts.unit_vector(direction + 0.5 * np.pi)
        view.labels.add_text(parts.Box(middle, half, direction))


def _draw_stem(view: View, follower: str, roller: Array, forth: float, direction: float) -> None:
    """Draw a follower's stem in rails above its roller, which still rises by `forth`."""
    along = parts.unit_vector(direction)
    foot = roller + 5.0 * view.size * along
    view.axes_of(follower).plot(*np.array([foot, roller]).T, color=parts.LINK, linewidth=4)
    top = forth + 9.0 * view.size
    _draw_rails(view, roller, (top - 5.0 * view.size, top), direction)
    tip = roller + (top + 1.5 * view.size) * along
    view.axes_of(follower).plot(*np.array([foot, tip]).T, color=parts.LINK, linewidth=4, alpha=0.75, zorder=4)
    view.labels.add_line(np.array([roller, tip]))


def _draw_cam(view: View, contact: CamContact) -> None:
    pose = view.poses[contact.a]
    outline = view.to_drawing(cam_outline(contact, view.poses[contact.a]))
    view.labels.add_line(outline)
    view.axes_of(contact.a).fill(*outline.T, facecolor="#dde6ec", edgecolor="none", zorder=1)
    view.axes_of(contact.a).plot(*outline.T, color=parts.INK, linewidth=1.4, zorder=5)
    for end, normal in zip(*contact.profile.segment_joints(), strict=True):
        place = view.place_of(contact.a, (float(end[0]), float(end[1])))
        outward = np.array(to_world((0.0, 0.0, pose[2]), (normal[0], normal[1])))
        ends = np.array([place - 0.4 * view.size * outward, place + 0.4 * view.size * outward])
        view.axes_of(contact.a).plot(*ends.T, color=parts.INK, linewidth=1.4, zorder=6)
    roller = view.place_of(contact.b, contact.roller_centre)
    ring = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = roller + MM * contact.roller_radius * np.column_stack([np.cos(ring), np.sin(ring)])
    view.axes_of(contact.b).fill(*circle.T, facecolor="white", edgecolor=parts.INK, linewidth=1.4, zorder=7)
    view.labels.add_line(circle)


def _draw_disc(view: View, name: str, slots: Sequence[Array]) -> None:
    """Draw a body's disc; in one pass of its driver a wheel with k slots turns by 2 pi / k, and has them all."""
    body = view.mechanism.body(name)
    centre, radius = view.place_of(name, body.centre_of_gravity), MM * view.discs[name]
    ring = np.linspace(0.0, 2.0 * np.pi, DISC_POINTS)
    rim = centre + radius * np.column_stack([np.cos(ring), np.sin(ring)])
    view.axes_of(name).fill(*rim.T, facecolor="#dde6ec", edgecolor=parts.LINK, linewidth=1.2, alpha=0.6, zorder=1)
    view.labels.add_line(rim)
    turned = abs(float(np.ptp(view.poses_over_turn(name)[:, 2])))
    count = round(2.0 * np.pi / turned) if view.mechanism.driver.span and turned else 1
    for ends in slots if abs(count * turned - 2.0 * np.pi) < SLOT_TOLERANCE else ():
        for k in range(1, count):
            cos, sin = np.cos(2.0 * np.pi * k / count), np.sin(2.0 * np.pi * k / count)
            other = centre + (ends - centre) @ np.array([[cos, sin], [-sin, cos]])
            parts.draw_slot(view.axes_of(name), other, view.size)


# -- shapes of links --------------------------------------------------------------------------------------------------


def link_outline(places: Sequence[Array]) -> Array:
    """Return the ends of a bar or the corners of a plate through places, (C, 2)."""
    own = list({tuple(np.round(place, PLACE_DIGITS)): place for place in reversed(places)}.values())[::-1]
    return _hull(own) if len(own) > 1 else np.empty((0, 2))


def _in_line(places: Sequence[Array]) -> bool:
    """True if places lie in one line."""
    ends = _farthest_pair(places)
    way = ends[1] - ends[0]
    arms = np.array(places) - ends[0]
    off = np.abs(way[0] * arms[:, 1] - way[1] * arms[:, 0]).max()
    return bool(off <= COLLINEAR_SHARE * (way @ way))


def _farthest_pair(places: Sequence[Array]) -> Array:
    """Return the two places that are farthest apart, in their order, (2, 2)."""
    points = np.array(places)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.asarray(points[sorted(np.unravel_index(int(apart.argmax()), apart.shape))])


def _hull(places: Sequence[Array]) -> Array:
    """Return the ends of places in line, else the corners of their convex hull."""
    if _in_line(places):
        return _farthest_pair(places)
    points = np.array(places)
    corners = points[ConvexHull(points).vertices]
    return np.roll(corners, -int(np.lexsort(corners.T[::-1])[0]), axis=0)


def _draw_body(view: View, name: str, corners: Array) -> None:
    """Draw a link as a bar, or as a plate with its edges."""
    edges = corners
    if len(corners) > 2:
        view.axes_of(name).add_patch(Polygon(corners, facecolor=parts.LINK, alpha=0.3, edgecolor="none", zorder=3))
        view.labels.add_plate(corners)
        edges = np.vstack([corners, corners[:1]])
    if len(corners):
        view.axes_of(name).plot(*edges.T, color=parts.LINK, linewidth=BAR_WIDTH, alpha=0.75, zorder=4)
        view.labels.add_line(edges)
