"""A disc cam whose profile is made from a motion law of its translating roller follower.

The follower's line passes the shaft at `offset`. While the cam turns by the law's angle u against it, the roller's
centre goes, in the cam's own frame, through the points of the pitch curve

    C(u) = H d(u) + e n(u),    H = sqrt((base + roller)^2 - e^2) + s(u),

with d the direction of the follower, at begin - sense u, and n a quarter turn ahead of it. The profile is the roller's
envelope: the pitch curve moved inwards by the roller's radius along its normal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.mechanism.cam import DWELL, Array, CamProfile, Segment
from conrod.mechanism.units import REVOLUTION

JUMP_TOLERANCE = 1e-9  # jump of a derivative over its largest value; smaller jumps are rounding
CURVATURE_SAMPLES = 3600  # per revolution, to find extremes of the curvature
CONTACT_SAMPLES = 360  # per revolution, to find a second contact of the roller
CONTACT_TOLERANCE = 1e-9  # penetration over the roller's radius; smaller ones are rounding
MAX_HALVINGS, MAX_DOUBLINGS = 50, 80


class PitchCurve(NamedTuple):
    """Points of a pitch curve, the path of the roller's centre in the cam's frame."""

    points: Array  # (T, 2) [m] in the cam's frame
    normals: Array  # outward unit normals (T, 2)
    curvature: Array  # (T,) [1/m], positive where it is convex
    rate: Array  # arc length of the curve by the law's angle (T,) [m]


@dataclass(frozen=True)
class LawProfile:
    """Profile of a cam with a motion law, in the cam's frame with the shaft at the origin.

    Raises:
        InvalidInput: no pitch curve exists for the offset and the lifts.
    """

    base_radius: float  # least distance of the profile from the shaft, without an offset [m]
    roller_radius: float  # of the roller whose centre follows the law [m]
    segments: tuple[Segment, ...]  # in the order in which they come under the roller; they close, in angle and in lift
    begin: float = 0.0  # direction [rad] in the cam's frame that points along the follower as the first segment begins
    sense: int = 1  # +1 where the cam turns counter-clockwise as the segments follow each other, else -1
    offset: float = 0.0  # of the follower's line from the shaft, to the left of the follower's direction [m]

    def __post_init__(self) -> None:
        if not abs(self.offset) < self.prime_radius:
            raise InvalidInput(
                f"offset = {self.offset:g} m: the follower's line must pass the shaft by less than base_radius + "
                f"roller_radius = {self.prime_radius:g} m"
            )
        if min(self._start_lifts) + self.least_height <= 0.0:
            raise InvalidInput(
                f"the lift goes down to {min(self._start_lifts):g} m, where the roller's centre would reach the shaft: "
                f"more than {-self.least_height:g} m is possible"
            )

    # -- law -----------------------------------------------------------------------------------------------------

    @property
    def prime_radius(self) -> float:
        """Distance of the roller's centre from the shaft at lift 0 [m]."""
        return self.base_radius + self.roller_radius

    @property
    def least_height(self) -> float:
        """Position of the roller's centre along its line at lift 0 [m], from the point nearest the shaft."""
        return math.sqrt(self.prime_radius**2 - self.offset**2)

    @cached_property
    def begins(self) -> Array:
        """Law angle [rad] at which each segment begins."""
        return np.concatenate([[0.0], np.cumsum([s.over for s in self.segments])[:-1]])

    @cached_property
    def _start_lifts(self) -> Array:
        """Lift [m] at which each segment begins."""
        return np.concatenate([[0.0], np.cumsum([s.lift for s in self.segments])[:-1]])

    @property
    def lowest_angle(self) -> float:
        """Law angle [rad] of the least lift; the middle of a dwell if the follower dwells there."""
        least = self._start_lifts <= self._start_lifts.min() + JUMP_TOLERANCE * self.prime_radius
        low = [i for i in range(len(self.segments)) if least[i]]
        dwells = [i for i in low if self.segments[i].law == DWELL]
        return float(self.begins[dwells[0]] + 0.5 * self.segments[dwells[0]].over if dwells else self.begins[low[0]])

    def segment_at(self, angle: Array) -> NDArray[np.intp]:
        """Index of the segment at law angles [rad]; shape of `angle`."""
        return np.searchsorted(self.begins, np.remainder(angle, REVOLUTION), side="right") - 1

    def lift(self, angle: Array, order: int, segment: NDArray[np.intp] | None = None) -> list[Array]:
        """Lift [m] at law angles [rad] and its derivatives by the angle, up to an order; each of the shape of `angle`.

        Args:
            segment: segment in contact at each angle, if the angle does not determine it: at a segment's end, on one
                side.
        """
        angle = np.asarray(angle, dtype=float)
        index = np.broadcast_to(self.segment_at(angle) if segment is None else segment, angle.shape)
        found = [np.zeros(angle.shape) for _ in range(order + 1)]
        for i in np.unique(index):
            part, here = self.segments[i], index == i
            middle = self.begins[i] + 0.5 * part.over
            # A segment is evaluated slightly beyond its ends too; whole turns are removed.
            x = 0.5 + (np.remainder(angle[here] - middle + math.pi, REVOLUTION) - math.pi) / part.over
            for k in range(order + 1):
                found[k][here] = part.height(x, k) + (self._start_lifts[i] if k == 0 else 0.0)
        return found

    def law_angle(self, x: Array, y: Array) -> Array:
        """Law angle [rad] of a roller's centre (x, y) [m] in the cam's frame, up to whole turns."""
        height = np.sqrt(x * x + y * y - self.offset**2)
        return np.asarray(self.sense * (self.begin + np.arctan2(self.offset, height) - np.arctan2(y, x)))

    def active_arc(self, x: Array, y: Array) -> NDArray[np.intp]:
        """Index of the segment in contact for a roller's centre (x, y) [m] in the cam's frame; shape of x."""
        return np.asarray(self.segment_at(self.law_angle(x, y)))

    def jumps(self, first: int, second: int) -> bool:
        """True if acceleration or jerk jumps between two neighbouring segments."""
        following = [(i, (i + 1) % len(self.segments)) for i in (first, second)]
        return any(self._jumps_between(*pair) for pair in following if set(pair) == {first, second})

    def _jumps_between(self, first: int, second: int) -> bool:
        """True if the second or third derivative jumps from a segment to the following one."""
        last, following = self.segments[first], self.segments[second]
        for order in (2, 3):
            gap = last.height(np.array(1.0), order) - following.height(np.array(0.0), order)
            if abs(float(gap)) > JUMP_TOLERANCE * max(abs(s.lift) / s.over**order for s in (last, following)):
                return True
        return False

    # -- geometry ------------------------------------------------------------------------------------------------

    def pitch(self, angle: Array, segment: NDArray[np.intp] | None = None) -> PitchCurve:
        """Points, normals and curvature of the pitch curve at law angles (T,) [rad]; `segment` as in `lift`."""
        s, first, second = self.lift(angle, 2, segment)
        height, e, turned = self.least_height + s, self.offset, self.sense * first
        direction = self.begin - self.sense * np.asarray(angle)
        along = np.column_stack([np.cos(direction), np.sin(direction)])
        across = np.column_stack([-along[:, 1], along[:, 0]])
        rate = np.hypot(first + self.sense * e, height)
        normals = (height[:, None] * along + (turned + e)[:, None] * across) / rate[:, None]
        curvature = ((turned + e) * (2.0 * turned + e) + height * (height - second)) / rate**3
        return PitchCurve(height[:, None] * along + e * across, normals, curvature, rate)

    def points(self, angle: Array, segment: NDArray[np.intp] | None = None) -> Array:
        """Points (T, 2) [m] of the profile that touch the roller at law angles (T,) [rad]."""
        pitch = self.pitch(angle, segment)
        return pitch.points - self.roller_radius * pitch.normals

    def outline(self, count: int) -> Array:
        """Points (N, 2) [m] around the whole profile, counter-clockwise, the first one repeated at the end."""
        return self.points(-self.sense * np.linspace(0.0, REVOLUTION, count))

    def segment_joints(self) -> tuple[Array, Array]:
        """Points (N, 2) [m] of the profile where segments meet, and its outward normals there (N, 2)."""
        return self.points(self.begins), self.pitch(self.begins).normals

    @cached_property
    def _curvatures(self) -> Array:
        """Curvature [1/m] of the pitch curve, sampled in each segment with both ends, where most extremes lie."""
        found = []
        for i, (start, part) in enumerate(zip(self.begins, self.segments, strict=True)):
            count = 2 + math.ceil(CURVATURE_SAMPLES * part.over / REVOLUTION)
            found.append(self.pitch(np.linspace(start, start + part.over, count), np.full(count, i)).curvature)
        return np.concatenate(found)

    @property
    def is_convex(self) -> bool:
        """True if the profile has no hollow parts."""
        return bool(self._curvatures.min() >= 0.0)

    @property
    def least_radius(self) -> float:
        """Smallest radius of curvature of a convex profile [m]; negative if the roller undercuts it."""
        return 1.0 / float(self._curvatures.max()) - self.roller_radius


Profile: TypeAlias = CamProfile | LawProfile


def check_undercut(profile: LawProfile) -> None:
    """Refuse a profile that its roller cannot follow; InvalidInput names the least base radius."""
    if can_roll(profile):
        return
    second = profile.least_radius + profile.roller_radius
    why = (
        f"the pitch curve bends with a radius of {second:.4g} m"
        if profile.least_radius <= 0.0
        else "it meets the profile elsewhere, too"
    )
    raise InvalidInput(
        f"a roller of {profile.roller_radius:g} m undercuts the cam: {why}; a base_radius of at least "
        f"{least_base_radius(profile, can_roll):.6g} m or a smaller roller is needed"
    )


def can_roll(profile: LawProfile) -> bool:
    """True if the roller follows the pitch curve without undercutting or touching the profile elsewhere."""
    if profile.least_radius <= 0.0:
        return False
    angle = np.linspace(0.0, REVOLUTION, CONTACT_SAMPLES, endpoint=False)
    rim, centres = profile.points(angle), profile.pitch(angle).points
    nearest = np.hypot(*(rim[:, None, :] - centres[None, :, :]).transpose(2, 0, 1)).min()
    return bool(nearest >= profile.roller_radius * (1.0 - CONTACT_TOLERANCE))


def concave_reason(profile: Profile) -> str | None:
    """Reason why engines that collide convex shapes cannot have a profile; None if it is convex."""
    if isinstance(profile, CamProfile) or profile.is_convex:
        return None
    enough = least_base_radius(profile, lambda other: other.is_convex)
    return (
        "the cam's profile is hollow in places, and a collision shape is convex: a base_radius of at least "
        f"{enough:.6g} m makes it so"
    )


def least_base_radius(profile: LawProfile, accepts: Callable[[LawProfile], bool]) -> float:
    """Least base radius [m], rounded up, for which a profile of the same law is accepted.

    Args:
        profile: profile that is not accepted.
        accepts: condition on a profile.
    """
    low = high = profile.base_radius
    for _ in range(MAX_DOUBLINGS):
        high *= 2.0
        if accepts(replace(profile, base_radius=high)):
            break
    for _ in range(MAX_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if accepts(replace(profile, base_radius=middle)) else (middle, high)
    return high * (1.0 + 1e-6)
