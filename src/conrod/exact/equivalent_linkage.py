"""A cam of circular arcs by its equivalent linkage: while the roller rests on one arc, a linkage moves it alike.

The roller's centre keeps the distance arc radius + roller radius from the arc's centre, which is fixed on the cam. So
the cam is a crank from its shaft to the arc's centre, and a rod leads from there to the roller's centre; with a
follower on a slide that is a slider-crank (of crank length zero, a dwell, where the arc is about the shaft). At the
joint of two arcs one linkage hands over to the next: position and velocity agree there, the acceleration jumps.

It is not the cam: the rod pulls as well as pushes, so that no follower leaves it, and nothing touches.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import BREAK_WIDTH, Array, Side
from conrod.mechanism.cam import Arc, CamProfile
from conrod.mechanism.mechanism import (
    GROUND,
    Body,
    CamContact,
    Driver,
    Mechanism,
    Point,
    Pose,
    Prismatic,
    Revolute,
    to_world,
)

TURN = 2.0 * math.pi
CONTACT, EQUIVALENT_LINKAGE = "contact", "equivalent-linkage"
CAM_FORMS = (CONTACT, EQUIVALENT_LINKAGE)
ROD = "equivalent-rod"
# A crank this short against its rod is rounding of an arc about the shaft.
DWELL = 1e-12


@dataclass(frozen=True)
class ArcLinkage:
    """The linkage of one arc.

    Attributes:
        arc: index in the cam's profile.
        start, stop: the crank angles [rad] between which the roller is on the arc; start in [0, 2 pi), stop after it.
        crank: from the shaft to the arc's centre [m].
        rod: from there to the roller's centre [m].
        mechanism: with a rod as a further body, the last one, in place of the contact. Its crank angle counts from
            the middle of the interval, which the linkage reaches; angle 0 of the machine it may not.
    """

    arc: int
    start: float
    stop: float
    crank: float
    rod: float
    mechanism: Mechanism

    @property
    def middle(self) -> float:
        """Crank angle [rad] of the machine at which the linkage's own is 0."""
        return 0.5 * (self.start + self.stop)

    @property
    def extent(self) -> float:
        """Crank angle [rad] from start to stop."""
        return self.stop - self.start

    @property
    def dwells(self) -> bool:
        """Whether the follower rests: the arc is about the shaft."""
        return self.crank <= DWELL * self.rod


@dataclass(frozen=True)
class EquivalentLinkage:
    """A cam and its follower on a slide, as linkages that take turns.

    Attributes:
        whole: the mechanism with its contact.
        arcs: its linkages in order of crank angle, the first one that begins at an angle in [0, 2 pi).
    """

    whole: Mechanism
    arcs: tuple[ArcLinkage, ...]

    def active(self, angle: Array, side: Side = "right") -> NDArray[np.intp]:
        """Index in `arcs` of the linkage in force at crank angles (T,) [rad]; at a switch that of a side."""
        if len(self.arcs) == 1:
            return np.zeros(np.shape(angle), dtype=np.intp)
        nudge = BREAK_WIDTH if side == "right" else -BREAK_WIDTH
        starts = np.array([linkage.start for linkage in self.arcs])
        found = np.searchsorted(starts, np.remainder(angle + nudge, TURN), side="right") - 1
        return np.remainder(found, len(starts))

    def travel(self, angle: Array, side: Side = "right") -> Array:
        """Way (T,) [m] of the roller's centre along its slide, from the foot of the shaft: the slider-cranks' own.

        With the arc's centre a along the slide and b across it from the shaft, and the slide e from it, the rod l
        ends at a + sqrt(l^2 - (e - b)^2).
        """
        guide, index = self._guide, self.active(angle, side)
        cranks = np.array([guide.centre(arcs_of(self.whole)[linkage.arc]) for linkage in self.arcs])[index]
        rods = np.array([linkage.rod for linkage in self.arcs])[index]
        turn = self.whole.driver.start + self.whole.driver.sense * angle - guide.direction
        along = np.cos(turn) * cranks[:, 0] - np.sin(turn) * cranks[:, 1]
        across = np.sin(turn) * cranks[:, 0] + np.cos(turn) * cranks[:, 1]
        return np.asarray(along + guide.side * np.sqrt(rods**2 - (guide.offset - across) ** 2))

    @cached_property
    def _guide(self) -> _Guide:
        return _guide_of(self.whole)


def equivalent_linkage(mechanism: Mechanism) -> EquivalentLinkage:
    """The linkages of a mechanism with one cam that is its crank, and a follower that slides in the ground.

    Raises:
        InvalidInput: the mechanism is another one.
    """
    reason = linkage_refusal(mechanism)
    if reason:
        raise InvalidInput(f"{mechanism.name}: {reason}")
    contact, guide = mechanism.cam_contacts[0], _guide_of(mechanism)
    arcs, sense = arcs_of(mechanism), mechanism.driver.sense
    if len(arcs) == 1:
        return EquivalentLinkage(mechanism, (_arc_linkage(mechanism, guide, 0, (0.0, TURN)),))
    joints = [guide.crank_angle(mechanism, contact, arc) for arc in arcs]
    linkages = []
    for i in range(len(arcs)):
        # A cam that turns counter-clockwise brings its arcs to the roller clockwise.
        last, first = (joints[(i + k) % len(arcs)] for k in ((0, 1) if sense > 0 else (1, 0)))
        start = math.remainder(first, TURN) % TURN
        linkages.append(_arc_linkage(mechanism, guide, i, (start, start + (last - first) % TURN)))
    linkages.sort(key=lambda linkage: linkage.start)
    return EquivalentLinkage(mechanism, tuple(linkages))


def arcs_of(mechanism: Mechanism) -> tuple[Arc, ...]:
    """The arcs of the one cam of a mechanism that has an equivalent linkage."""
    profile = mechanism.cam_contacts[0].profile
    assert isinstance(profile, CamProfile)
    return profile.arcs


def linkage_refusal(mechanism: Mechanism) -> str | None:
    """None, or the reason why a mechanism has no equivalent linkage here."""
    if len(mechanism.cam_contacts) != 1:
        return f"it has {len(mechanism.cam_contacts)} cams; an equivalent linkage is made for one"
    contact = mechanism.cam_contacts[0]
    if not isinstance(contact.profile, CamProfile):
        return f"the cam {contact.a!r} is made from a motion law, and has no arcs to make an equivalent linkage of"
    if contact.a != mechanism.crank:
        return f"the cam {contact.a!r} is not the driven crank, which an equivalent linkage is made for"
    if _slide_of(mechanism) is None:
        return f"{contact.b!r} does not slide in the ground, which an equivalent linkage is made for"
    if mechanism.loads:
        return f"loads act on it ({mechanism.loads[0].name}), which runs of equivalent linkages leave out"
    return None


@dataclass(frozen=True)
class _Guide:
    """Where the roller's centre moves, seen from the shaft.

    Attributes:
        shaft: place of the shaft [m].
        pin: the shaft in the cam's frame [m].
        direction: of the slide [rad].
        offset: of the slide from the shaft, to the left of its direction [m].
        side: +1 where the roller is ahead of the shaft in this direction, else -1.
    """

    shaft: Point
    pin: Point
    direction: float
    offset: float
    side: float

    def centre(self, arc: Arc) -> Point:
        """An arc's centre from the shaft, in the cam's directions."""
        return arc.centre[0] - self.pin[0], arc.centre[1] - self.pin[1]

    def crank_angle(self, mechanism: Mechanism, contact: CamContact, arc: Arc) -> float:
        """Crank angle [rad] at which the roller is where an arc begins; up to whole turns."""
        reach, (x, y) = arc.radius + contact.roller_radius, self.centre(arc)
        x, y = x + reach * math.cos(arc.start), y + reach * math.sin(arc.start)
        along = self.side * math.sqrt(x * x + y * y - self.offset**2)
        turn = self.direction + math.atan2(self.offset, along) - math.atan2(y, x)
        return mechanism.driver.sense * (turn - mechanism.driver.start)

    def roller(self, turn: float, arc: Arc, reach: float) -> tuple[Point, Point]:
        """Places of an arc's centre and of the roller's [m], with the cam at a turn [rad]."""
        x, y = to_world((*self.shaft, turn), self.centre(arc))
        ux, uy = math.cos(self.direction), math.sin(self.direction)
        along = (x - self.shaft[0]) * ux + (y - self.shaft[1]) * uy
        across = (y - self.shaft[1]) * ux - (x - self.shaft[0]) * uy
        way = along + self.side * math.sqrt(reach**2 - (self.offset - across) ** 2)
        place = self.shaft[0] + way * ux - self.offset * uy, self.shaft[1] + way * uy + self.offset * ux
        return (x, y), place


def _guide_of(mechanism: Mechanism) -> _Guide:
    slide, contact, shaft = _slide_of(mechanism), mechanism.cam_contacts[0], mechanism.driven_joint
    assert slide is not None
    # The follower does not turn, so that its roller's centre is always as far from the slide's line.
    arm = contact.roller_centre[0] - slide.point_b[0], contact.roller_centre[1] - slide.point_b[1]
    x, y = to_world((*slide.point_a, slide.angle), arm)
    ux, uy = math.cos(slide.direction), math.sin(slide.direction)
    offset = (y - shaft.point_a[1]) * ux - (x - shaft.point_a[0]) * uy
    rx, ry = to_world(mechanism.poses[contact.b], contact.roller_centre)
    ahead = (rx - shaft.point_a[0]) * ux + (ry - shaft.point_a[1]) * uy
    return _Guide(shaft.point_a, shaft.point_b, slide.direction, offset, math.copysign(1.0, ahead))


def _slide_of(mechanism: Mechanism) -> Prismatic | None:
    """The slide of the follower in the ground."""
    follower = mechanism.cam_contacts[0].b
    slides = [j for j in mechanism.joints if isinstance(j, Prismatic) and (j.a, j.b) == (GROUND, follower)]
    return slides[0] if slides else None


def _arc_linkage(mechanism: Mechanism, guide: _Guide, index: int, between: tuple[float, float]) -> ArcLinkage:
    contact = mechanism.cam_contacts[0]
    arc = arcs_of(mechanism)[index]
    length = arc.radius + contact.roller_radius
    middle = mechanism.crank_turn(0.5 * (between[0] + between[1]))
    (cx, cy), (rx, ry) = guide.roller(middle, arc, length)
    rod: Pose = (cx, cy, math.atan2(ry - cy, rx - cx))
    mass = mechanism.body(contact.b).mass  # any: with the crank prescribed, the motion depends on no mass
    pins = (
        Revolute("arc-pin", contact.a, ROD, arc.centre, (0.0, 0.0)),
        Revolute("roller-pin", ROD, contact.b, (length, 0.0), contact.roller_centre),
    )
    made = replace(
        mechanism,
        name=f"{mechanism.name}, linkage of arc {index}",
        bodies=(*mechanism.bodies, Body(ROD, mass, mass * length**2 / 12.0, (0.5 * length, 0.0))),
        joints=tuple(j for joint in mechanism.joints for j in (pins if joint is contact else (joint,))),
        driver=Driver(mechanism.driver.joint, mechanism.driver.sense, middle),
        poses=_poses(mechanism, guide, middle, (rx, ry)) | {ROD: rod},
    )
    return ArcLinkage(index, *between, math.hypot(*guide.centre(arc)), length, made)


def _poses(mechanism: Mechanism, guide: _Guide, turn: float, roller: Point) -> dict[str, Pose]:
    """Of all bodies, with the cam at a turn and the roller's centre at a place."""
    contact, slide = mechanism.cam_contacts[0], _slide_of(mechanism)
    assert slide is not None
    back = to_world((0.0, 0.0, turn), guide.pin)
    arm = to_world((0.0, 0.0, slide.angle), contact.roller_centre)
    return dict(mechanism.poses) | {
        contact.a: (guide.shaft[0] - back[0], guide.shaft[1] - back[1], turn),
        contact.b: (roller[0] - arm[0], roller[1] - arm[1], slide.angle),
    }
