"""The dimensions of a drawing, read off the mechanism and placed where their texts have room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import GROUND, CamContact, Prismatic, Rack, Revolute, Rolling, pin_points
from conrod.mechanism.units import MM
from conrod.report import numbers
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.view import View

INK = "#8a2b2b"
# Distances of a dimension line from its link, as shares of the drawing's size; negative on the link's right side.
LINE_OFFSETS = (-0.07, 0.07, -0.13, 0.13, -0.19, 0.19)
TEXT_OFFSET = 0.03  # of a text from its dimension line, as a share of the drawing's size
RADIUS_DIRECTIONS = np.radians(np.arange(0.0, 360.0, 30.0))  # of a wheel's radius [rad], from the first choice
ARC_SHARES = np.array([0.5, 0.35, 0.65])  # of an arc, where the arrow of its radius may end
MAX_LINKS_WITH_FRAME = 3  # moving links, up to which the frame's length is drawn


@dataclass(frozen=True)
class Dimension:
    """A dimension of a drawing: its text, its arrow and its extension lines.

    Attributes:
        text: the text at the arrow.
        arrow: start and end (2, 2) [mm].
        style: matplotlib's name of the arrow's heads.
        at, angle: the text's centre (2,) [mm] and its angle [rad].
        extensions: lines from the measured points to the arrow, each (2, 2) [mm].
    """

    text: str
    arrow: Array
    style: str
    at: Array
    angle: float
    extensions: tuple[Array, ...] = ()

    def draw(self, view: View) -> None:
        """Draw the arrow, its extension lines and its text."""
        for extension in self.extensions:
            view.axes.plot(*extension.T, color=INK, linewidth=0.6, zorder=6)
        parts.draw_arrow(view.axes, self.arrow[0], self.arrow[1], INK, self.style, 0.8)
        parts.draw_note(view.axes, self.at, self.text, INK, math.degrees(self.angle))


def draw_dimensions(view: View) -> None:
    """Draw lengths of links, offsets, and radii of cams and wheels, each where it has room."""
    for wishes in dimensions(view):
        places = []
        for wish in wishes:
            box = view.labels.box(wish.at, wish.text, parts.TEXT_STYLE["fontsize"], wish.angle)
            places.append((box, (wish.arrow, *wish.extensions)))
        best = view.labels.best_place(places)
        box, lines = places[best]
        view.labels.add_text(box)
        for line in lines:
            view.labels.add_line(line)
        wishes[best].draw(view)


def dimensions(view: View) -> Iterator[Sequence[Dimension]]:
    """Yield the possible places of each dimension: of links, frame, slides, cams and wheels.

    The places of a dimension are in the order of preference."""
    mechanism = view.mechanism
    for body in mechanism.bodies:
        pins = [view.place_of(body.name, point) for point in dict.fromkeys(pin_points(mechanism, body.name))]
        if len(pins) == 2:
            yield _length_dimensions(view, body.name, *pins)
    fixed = [joint for joint in mechanism.joints if isinstance(joint, Revolute) and GROUND in (joint.a, joint.b)]
    places = list(dict.fromkeys(joint.point_a if joint.a == GROUND else joint.point_b for joint in fixed))
    if len(places) == 2 and len(mechanism.bodies) <= MAX_LINKS_WITH_FRAME:
        yield _length_dimensions(view, "frame", *map(view.to_drawing, places))
    radii: dict[str, Sequence[Dimension]] = {}
    for joint in mechanism.joints:
        match joint:
            case Prismatic() if joint.a == GROUND and not mechanism.cam_contacts:
                yield from _offset_dimensions(view, joint)
            case CamContact():
                radii |= _cam_dimensions(view, joint)
            case Rolling():
                radii |= _wheel_dimensions(view, joint.a, joint.point_a, joint.radius_a)
                radii |= _wheel_dimensions(view, joint.b, joint.point_b, joint.radius_b)
            case Rack():
                radii |= _wheel_dimensions(view, joint.a, joint.point_a, joint.radius)
            case _:
                pass
    # A wheel that rolls on two others, and a cam of two equal flanks, have each radius once.
    yield from radii.values()


# -- lengths -----------------------------------------------------------------------------------------------------------


def _length_dimensions(
    view: View, name: str, start: Array, stop: Array, seen_from: Array | None = None
) -> list[Dimension]:
    """Return places of the length from `start` to `stop` [mm].

    Args:
        view: the drawing.
        name: name of the length.
        start, stop: ends (2,) [mm].
        seen_from: where the second extension line begins, instead of `stop`."""
    way = stop - start
    length = math.hypot(*way)
    turn = _readable_angle(math.atan2(way[1], way[0]))
    left = view.extent * np.array([-way[1], way[0]]) / length
    found = []
    for aside in LINE_OFFSETS:
        arrow = np.array([start, stop]) + aside * left
        seen = (start, stop if seen_from is None else seen_from)
        extensions = [np.array([end, tip + 0.15 * aside * left]) for end, tip in zip(seen, arrow, strict=True)]
        at = arrow.mean(axis=0) + math.copysign(TEXT_OFFSET, aside) * left
        found.append(Dimension(f"{name} {_length_text(length)}", arrow, "<|-|>", at, turn, tuple(extensions)))
    return found


def _offset_dimensions(view: View, slide: Prismatic) -> Iterator[list[Dimension]]:
    """Yield places of the offset of a slide's line from the shaft; none if the offset is zero."""
    shaft = view.place_of(view.mechanism.crank, view.mechanism.driven_joint.point_b)
    slider = view.place_of(slide.b, slide.point_b)
    normal = parts.unit_vector(slide.direction + 0.5 * math.pi)
    away = (slider - shaft) @ normal
    if abs(away) > 1e-6 * view.extent:
        yield _length_dimensions(view, "offset", slider, slider - away * normal, shaft)


# -- radii -------------------------------------------------------------------------------------------------------------


def _radius_dimensions(view: View, text: str, centre: Array, radius: float, directions: Array) -> list[Dimension]:
    """Return places of a radius [mm] in some directions [rad], with its text on it or beyond."""
    width = view.labels.width(text, parts.TEXT_STYLE["fontsize"])
    found = []
    for direction in directions:
        along = parts.unit_vector(direction)
        arrow = np.array([centre, centre + radius * along])
        if radius > 1.2 * width:
            found.append(Dimension(text, arrow, "-|>", centre + 0.55 * radius * along, _readable_angle(direction)))
        else:
            at = arrow[1] + np.array([0.6 * width, 1.2 * view.size]) * along
            found.append(Dimension(text, arrow, "-|>", at, 0.0))
    return found


def _wheel_dimensions(view: View, body: str, centre: tuple[float, float], radius: float) -> dict[str, list[Dimension]]:
    text = f"{'fixed' if body == GROUND else body} r {_length_text(MM * abs(radius))}"
    directions = view.poses[body][2] + math.radians(210.0) + RADIUS_DIRECTIONS
    return {text: _radius_dimensions(view, text, view.place_of(body, centre), MM * abs(radius), directions)}


def _cam_dimensions(view: View, contact: CamContact) -> dict[str, list[Dimension]]:
    """Return places of the radii of a cam's arcs, or of its base circle, and of its roller."""
    turn, profile = view.poses[contact.a][2], contact.profile
    if isinstance(profile, LawProfile):
        lowest = profile.begin - profile.sense * profile.lowest_angle
        circles = [((0.0, 0.0), profile.base_radius, np.array([lowest]))]
    else:
        circles = [(arc.centre, arc.radius, arc.start + ARC_SHARES * arc.extent) for arc in profile.arcs]
    found = {}
    for centre, radius, directions in circles:
        text = f"r {_length_text(MM * radius)}"
        found[text] = _radius_dimensions(view, text, view.place_of(contact.a, centre), MM * radius, turn + directions)
    roller, text = (
        view.place_of(contact.b, contact.roller_centre),
        f"roller r {_length_text(MM * contact.roller_radius)}",
    )
    return found | {text: _radius_dimensions(view, text, roller, MM * contact.roller_radius, RADIUS_DIRECTIONS)}


def _length_text(length: float) -> str:
    return "{} {}".format(*numbers.in_shown_unit(length / MM, "m"))


def _readable_angle(turn: float) -> float:
    """Return a line's angle [rad] so that text along it reads from the left or from below."""
    return math.remainder(turn - 1e-9, math.pi) + 1e-9
