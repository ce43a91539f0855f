"""The dimensions of a drawing, read off the mechanism: each on that side of its link where its text has room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from conrod.exact.motion import Array
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import (
    GROUND,
    CamContact,
    Mechanism,
    Point,
    Pose,
    Prismatic,
    Rack,
    Revolute,
    Rolling,
    pins_of,
    to_world,
)
from conrod.report import numbers
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.view import MM, View

INK = "#8a2b2b"
# Of the usual distance of a dimension line from its link; negative on the other side.
DISTANCES = (1.0, -1.0, 1.8, -1.8, 2.6, -2.6)
ALONG = (0.5, 0.35, 0.65)  # where a text may stand on its line
DIRECTIONS = np.radians([0.0, 60.0, 120.0, 180.0, 240.0, 300.0])  # of a wheel's radius, from its usual one
ONE_LOOP = 3  # moving links
SYMMETRIC = 4  # arcs of a symmetric cam

Poses = Mapping[str, Pose]


@dataclass(frozen=True)
class Length:
    """A dimension line beside the line from `start` to `stop` [m]; `aside` of the drawing's size to its left.

    Its second extension line begins at `stop_from`, where that is not `stop`; its text stands at `text_at` of the line.
    """

    text: str
    start: Point
    stop: Point
    aside: float
    stop_from: Point | None = None
    text_at: float = 0.5

    def wishes(self) -> list[Length]:
        """The dimension in other places, the best first."""
        return [replace(self, aside=d * self.aside, text_at=along) for d in DISTANCES for along in ALONG]

    def lines(self, extent: float) -> list[Array]:
        """The dimension line and its two extension lines [mm], each (2, 2)."""
        start, stop = MM * np.array(self.start), MM * np.array(self.stop)
        shift = self.aside * extent * _left(start, stop)
        origin = stop if self.stop_from is None else MM * np.array(self.stop_from)
        extensions = [np.array([seen_from, end + 1.15 * shift]) for end, seen_from in ((start, start), (stop, origin))]
        return [np.array([start + shift, stop + shift]), *extensions]

    def label(self, view: View) -> tuple[Array, float]:
        """Centre of the text [mm], and its angle [deg]."""
        start, stop = MM * np.array(self.start), MM * np.array(self.stop)
        aside = (self.aside + math.copysign(0.03, self.aside)) * view.extent * _left(start, stop)
        along = stop - start
        return start + self.text_at * along + aside, _readable(math.degrees(math.atan2(along[1], along[0])))

    def draw(self, view: View) -> None:
        """The line with arrow heads, its extension lines and its text."""
        line, *extensions = self.lines(view.extent)
        for extension in extensions:
            view.axes.plot(*extension.T, color=INK, linewidth=0.6, zorder=6)
        parts.arrow(view.axes, line[0], line[1], INK, "<|-|>", 0.8)
        centre, turned = self.label(view)
        parts.note(view.axes, centre, self.text, INK, turned)


@dataclass(frozen=True)
class Radius:
    """An arrow from a centre [m] to its circle, in a direction [rad]; `text_at` of the radius from the centre."""

    text: str
    centre: Point
    radius: float
    direction: float
    text_at: float = 0.55
    turns: tuple[float, ...] = (0.0,)  # by which the direction may be another [rad]

    def wishes(self) -> list[Radius]:
        """The arrow in other directions, the best first."""
        return [replace(self, direction=self.direction + turn) for turn in self.turns]

    def lines(self, extent: float) -> list[Array]:
        """The arrow [mm]; (2, 2)."""
        centre = MM * np.array(self.centre)
        return [np.array([centre, centre + MM * self.radius * parts.unit(self.direction)])]

    def label(self, view: View) -> tuple[Array, float]:
        """Centre of the text [mm], and its angle [deg]: level outside, where the text begins at its place."""
        centre = MM * np.array(self.centre) + self.text_at * MM * self.radius * parts.unit(self.direction)
        if self.text_at <= 1.0:
            return centre, _readable(math.degrees(self.direction))
        half = 0.5 * view.labels.width(f"  {self.text}", parts.TEXT["fontsize"])
        return centre + np.array([math.copysign(half, math.cos(self.direction)), 0.0]), 0.0

    def draw(self, view: View) -> None:
        """The arrow from a marked centre and its text."""
        ((centre, tip),) = self.lines(view.extent)
        view.axes.plot(*centre, marker="+", color=INK, markersize=7, markeredgewidth=0.9, zorder=9)
        parts.arrow(view.axes, centre, tip, INK, "-|>", 0.8)
        at, turned = self.label(view)
        parts.note(view.axes, at, self.text, INK, turned)


Dimension = Length | Radius


def draw_dimensions(view: View) -> None:
    """Lengths of links and offsets, and radii of cams and wheels, each where it has room."""
    for dimension in dimensions(view.mechanism, view.poses):
        if isinstance(dimension, Length) and MM * math.dist(dimension.start, dimension.stop) <= 1e-6 * view.extent:
            continue
        wishes: Sequence[Dimension] = dimension.wishes()
        places = []
        for wish in wishes:
            centre, turned = wish.label(view)
            places.append((view.labels.box(centre, wish.text, parts.TEXT["fontsize"], turned), wish.lines(view.extent)))
        best = view.labels.best(places)
        box, lines = places[best]
        view.labels.take(box)
        for line in lines:
            view.labels.draw(line)
        wishes[best].draw(view)


def dimensions(mechanism: Mechanism, poses: Poses) -> Iterator[Dimension]:
    """Lengths of links between their pins, of the frame, offsets of slides, radii of cams and wheels."""
    for body in mechanism.bodies:
        yield from _link(body.name, mechanism, poses)
    yield from _frame(mechanism)
    wheels: dict[tuple[str, float], Radius] = {}
    for joint in mechanism.joints:
        match joint:
            case Prismatic() if joint.a == GROUND and not mechanism.cam_contacts:
                yield from _offset(joint, mechanism, poses)
            case CamContact():
                yield from _cam(joint, poses)
            case Rolling() | Rack():
                # A wheel that rolls on two others has one radius.
                wheels |= {(wheel.text, wheel.radius): wheel for wheel in _wheels(joint, poses)}
            case _:
                pass
    yield from wheels.values()


def _link(name: str, mechanism: Mechanism, poses: Poses) -> Iterator[Length]:
    """The length of a link with two pins."""
    # Several links may share a pin.
    held = list(dict.fromkeys(pins_of(mechanism, name)))
    if len(held) == 1 and any(isinstance(joint, Prismatic) and joint.a == name for joint in mechanism.joints):
        # Of what turns about one pin and guides a slider, to the point that is observed on it.
        held += [point.point for point in mechanism.observed if point.body == name]
    pins = [to_world(poses[name], point) for point in held]
    if len(pins) != 2 or math.dist(*pins) == 0.0:
        return
    text = f"{name} {_mm(math.dist(*pins))}"
    if name == mechanism.crank:
        # On the side that the crank angle leaves free.
        yield Length(text, pins[0], pins[1], 0.07 * mechanism.driver.sense)
        return
    # On the outer side of the link's bend with the line to the shaft.
    shaft = to_world(poses[mechanism.crank], mechanism.driven_joint.point_b)
    bend = (pins[0][0] - shaft[0]) * (pins[1][1] - pins[0][1]) - (pins[0][1] - shaft[1]) * (pins[1][0] - pins[0][0])
    yield Length(text, pins[0], pins[1], -0.07 if bend > 0.0 else 0.07)


def _frame(mechanism: Mechanism) -> Iterator[Length]:
    """The frame's length between two pins on the ground, of a machine of one loop."""
    if len(mechanism.bodies) > ONE_LOOP:
        return
    held = [joint for joint in mechanism.joints if isinstance(joint, Revolute) and GROUND in (joint.a, joint.b)]
    places = list(dict.fromkeys(joint.point_a if joint.a == GROUND else joint.point_b for joint in held))
    if len(places) == 2:
        yield Length(f"frame {_mm(math.dist(*places))}", places[0], places[1], -0.1)


def _offset(slide: Prismatic, mechanism: Mechanism, poses: Poses) -> Iterator[Length]:
    """The distance of a slide's line from the shaft, drawn at the slider; nothing where the line passes through it."""
    shaft = to_world(poses[mechanism.crank], mechanism.driven_joint.point_b)
    slider = to_world(poses[slide.b], slide.point_b)
    nx, ny = -math.sin(slide.direction), math.cos(slide.direction)
    away = (slider[0] - shaft[0]) * nx + (slider[1] - shaft[1]) * ny
    if abs(away) > 1e-9 * math.dist(slider, shaft):
        foot = (slider[0] - away * nx, slider[1] - away * ny)
        yield Length(f"offset {_mm(abs(away))}", slider, foot, -0.08, stop_from=shaft)


def _wheels(mesh: Rolling | Rack, poses: Poses) -> Iterator[Radius]:
    """Radii of what rolls: of two wheels or a wheel and a ring; of a wheel on a rack."""
    ends = [(mesh.a, mesh.point_a, mesh.radius if isinstance(mesh, Rack) else mesh.radius_a)]
    if isinstance(mesh, Rolling):
        ends.append((mesh.b, mesh.point_b, mesh.radius_b))
    for body, point, radius in ends:
        text = f"{'fixed' if body == GROUND else body} r {_mm(abs(radius))}"
        turn = poses[body][2] + math.radians(210.0)
        yield Radius(text, to_world(poses[body], point), abs(radius), turn, turns=tuple(DIRECTIONS))


def _cam(contact: CamContact, poses: Poses) -> Iterator[Dimension]:
    """Radii of a profile of one arc, of nose, flank, base and flank, or of a law's base circle; and the roller's."""
    cam, profile = poses[contact.a], contact.profile
    if isinstance(profile, LawProfile):
        direction = cam[2] + profile.begin - profile.sense * profile.lowest_angle
        yield Radius(f"base {_mm(profile.base_radius)}", (cam[0], cam[1]), profile.base_radius, direction)
    elif len(profile.arcs) == 1:
        (arc,) = profile.arcs
        yield Radius(f"one circle {_mm(arc.radius)}", to_world(cam, arc.centre), arc.radius, cam[2])
    elif len(profile.arcs) == SYMMETRIC:
        nose, flank, base, _ = profile.arcs
        # The flank's arrow ends in the middle of the flank turned away from the roller.
        away, middle = (flank.centre[0], -flank.centre[1]), -0.5 * (flank.start + flank.stop)
        for name, arc, centre, turn, text_at in (
            ("base", base, base.centre, math.radians(130.0), 0.55),
            ("nose", nose, nose.centre, 0.0, 0.55),
            ("flank", flank, away, middle, 0.6),
        ):
            yield Radius(f"{name} {_mm(arc.radius)}", to_world(cam, centre), arc.radius, cam[2] + turn, text_at)
        apart = f"centre distance {_mm(math.hypot(*nose.centre))}"
        yield Length(apart, (cam[0], cam[1]), to_world(cam, nose.centre), -0.32)
    roller = to_world(poses[contact.b], contact.roller_centre)
    yield Radius(
        f"roller {_mm(contact.roller_radius)}",
        roller,
        contact.roller_radius,
        math.radians(30.0),
        1.9,
        tuple(DIRECTIONS),
    )


def _mm(length: float) -> str:
    return "{} {}".format(*numbers.in_shown_unit(length, "m"))


def _left(start: Array, stop: Array) -> Array:
    along = (stop - start) / np.linalg.norm(stop - start)
    return np.array([-along[1], along[0]])


def _readable(degrees: float) -> float:
    """The same line, read from the left or from below."""
    turned = (degrees + 180.0) % 360.0 - 180.0
    return turned - 180.0 if turned > 90.0 else turned + 180.0 if turned <= -90.0 else turned
