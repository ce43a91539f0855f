"""The links and joints of a mechanism at a crank angle, as a course draws them."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from conrod.exact.linkage.state import LinkageState
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Prismatic, Revolute, pins_of
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.link_shapes import link_shape
from conrod.report.drawing.slides import slide_of
from conrod.report.drawing.view import pitch_lines, profile
from conrod.report.linkage.sheet import Sheet

SYMBOL, RAIL = 8.0, 20.0  # of a joint, and half of a slide [pt]
COARSE = 20  # samples of a curve that labels take for a straight piece


def draw_links(sheet: Sheet, state: LinkageState) -> None:
    """Links as bars and plates, joints as symbols, cams and pitch lines."""
    mechanism, poses = state.mechanism, {name: link.pose for name, link in state.links.items()}
    for name in mechanism.body_index:
        shape = link_shape(_pins(sheet, state, name))
        parts.body(sheet.axes, shape, 5.0)
        for start, stop in pairwise(shape.edges):
            sheet.keep_clear(start, stop)
    for joint in mechanism.joints:
        match joint:
            case Revolute():
                point = sheet.at(state.links[joint.a].place(joint.point_a))
                place = (float(point[0]), float(point[1]))
                if GROUND in (joint.a, joint.b):
                    parts.bearing(sheet.axes, place, SYMBOL)
                parts.pin(sheet.axes, place, SYMBOL)
                sheet.keep_off(point, 0.5 * SYMBOL)
            case Prismatic():
                _slide(sheet, state, joint)
            case CamContact():
                line = np.array([sheet.at(np.array(p)) for p in profile(joint, poses[joint.a])])
                sheet.axes.plot(*np.round(line, 2).T, color=parts.INK, linewidth=1.2, zorder=5)
                _keep_clear(sheet, line)
                _circle(sheet, state.links[joint.b].place(joint.roller_centre), joint.roller_radius)
            case _:
                for rolled in pitch_lines(joint, poses):
                    line = np.array([sheet.at(point) for point in rolled])
                    sheet.axes.plot(*np.round(line, 2).T, color=parts.INK, linewidth=1.0, linestyle="-.", zorder=5)
                    _keep_clear(sheet, line)


def _circle(sheet: Sheet, centre: Array, radius: float) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    ring = sheet.at(centre) + radius * sheet.scale * np.column_stack([np.cos(turn), np.sin(turn)])
    sheet.axes.plot(*np.round(ring, 2).T, color=parts.INK, linewidth=1.2, zorder=6)
    _keep_clear(sheet, ring)


def _keep_clear(sheet: Sheet, line: Array) -> None:
    """Labels avoid a curve (N, 2) [pt], in straight pieces."""
    for start, stop in pairwise(line[:: min(len(line) - 1, COARSE)]):
        sheet.keep_clear(start, stop)


def _slide(sheet: Sheet, state: LinkageState, joint: Prismatic) -> None:
    """A block between rails; on a moving link it slides on a bar from that link's own pin."""
    slide = slide_of(state.mechanism, joint)
    block = sheet.at(state.links[slide.moving].place(slide.point))
    direction = state.links[slide.guide].pose[2] + slide.direction
    if slide.guide == GROUND:
        for contact in state.mechanism.cam_contacts:
            if contact.b == slide.moving:
                # Above its roller, where it does not hide the cam.
                foot, way = block, contact.roller_radius * sheet.scale + 2.5 * SYMBOL
                block = block + way * parts.unit(direction)
                sheet.axes.plot(*np.round([foot, block], 2).T, color=parts.LINK, linewidth=4.0, zorder=4)
        parts.guide(sheet.axes, block, (-RAIL, RAIL), direction, SYMBOL)
        ends = block + np.outer([-RAIL, RAIL], parts.unit(direction))
        for aside in (-1.6, -1.15, 1.15, 1.6):
            sheet.keep_clear(*(ends + aside * SYMBOL * parts.unit(direction + 0.5 * math.pi)))
    else:
        # As far as the block, and as far beyond it as the link's nearest pin is before it.
        along = parts.unit(direction)
        ways = [float((pin - block) @ along) for pin in _pins(sheet, state, slide.guide)] or [0.0]
        ends = np.array([min(*ways, -RAIL), max(*ways, RAIL)])
        bar = block + np.outer(ends, along)
        sheet.axes.plot(*np.round(bar, 2).T, color=parts.LINK, linewidth=4.0, alpha=0.6, zorder=3)
        sheet.keep_clear(*bar)
    parts.slider(sheet.axes, block, direction, 0.8 * SYMBOL)
    sheet.keep_off(block, SYMBOL)


def _pins(sheet: Sheet, state: LinkageState, name: str) -> list[Array]:
    return [sheet.at(state.links[name].place(point)) for point in pins_of(state.mechanism, name)]


def middle(sheet: Sheet, state: LinkageState, name: str) -> Array:
    """Place of a link's number [pt]: between its pins and what slides in it."""
    held = _pins(sheet, state, name)
    for joint in state.mechanism.joints:
        if isinstance(joint, Prismatic):
            slide = slide_of(state.mechanism, joint)
            if slide.guide == name:
                held.append(sheet.at(state.links[slide.moving].place(slide.point)))
    place = np.mean(held, axis=0) if held else sheet.at(np.array(state.links[name].pose[:2]))
    return np.asarray(place)


def draw_arm(sheet: Sheet, state: LinkageState, name: str, place: Array) -> None:
    """A thin line to a point of a link that is only looked at, from the pin next to it."""
    point = sheet.at(place)
    pins = _pins(sheet, state, name) or [sheet.at(np.array(state.links[name].pose[:2]))]
    near = min(pins, key=lambda pin: float(np.linalg.norm(pin - point)))
    parts.arm(sheet.axes, np.round([near, point], 2))
    sheet.keep_clear(near, point)
