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

# Of the largest derivative of its order: a jump below this is rounding.
ROUNDING = 1e-9
SAMPLES = 3600  # of a profile, where its extremes are looked for
PLACES = 360  # of a profile, where the roller might meet it a second time
# Of the roller's radius: less than this between roller and profile is rounding.
TOUCHING = 1e-9
HALVINGS, DOUBLINGS = 50, 80


class Pitch(NamedTuple):
    """Points of a pitch curve."""

    points: Array  # (T, 2) [m] in the cam's frame
    normals: Array  # outward unit normals (T, 2)
    curvature: Array  # (T,) [1/m], positive where it is convex
    rate: Array  # way along the curve by the law's angle (T,) [m]


@dataclass(frozen=True)
class LawProfile:
    """The profile in the cam's frame: shaft at the origin; raises InvalidInput where there is no such pitch curve."""

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
        if min(self._starts_at) + self.least_height <= 0.0:
            raise InvalidInput(
                f"the lift goes down to {min(self._starts_at):g} m, where the roller's centre would reach the shaft: "
                f"more than {-self.least_height:g} m is possible"
            )

    # -- law -----------------------------------------------------------------------------------------------------

    @property
    def prime_radius(self) -> float:
        """Distance of the roller's centre from the shaft at lift 0 [m]."""
        return self.base_radius + self.roller_radius

    @property
    def least_height(self) -> float:
        """Way of the roller's centre along its line, from the foot of the shaft, at lift 0 [m]."""
        return math.sqrt(self.prime_radius**2 - self.offset**2)

    @cached_property
    def begins(self) -> Array:
        """Law angle [rad] at which each segment begins."""
        return np.concatenate([[0.0], np.cumsum([s.over for s in self.segments])[:-1]])

    @cached_property
    def _starts_at(self) -> Array:
        """Lift [m] at which each segment begins."""
        return np.concatenate([[0.0], np.cumsum([s.lift for s in self.segments])[:-1]])

    @property
    def lowest_angle(self) -> float:
        """A law angle [rad] where the lift is least: the middle of a dwell, where there is one."""
        least = self._starts_at <= self._starts_at.min() + ROUNDING * self.prime_radius
        low = [i for i in range(len(self.segments)) if least[i]]
        dwells = [i for i in low if self.segments[i].law == DWELL]
        return float(self.begins[dwells[0]] + 0.5 * self.segments[dwells[0]].over if dwells else self.begins[low[0]])

    def segment_at(self, angle: Array) -> NDArray[np.intp]:
        """Index of the segment at law angles [rad]; shape of `angle`."""
        return np.searchsorted(self.begins, np.remainder(angle, REVOLUTION), side="right") - 1

    def lift(self, angle: Array, order: int, segment: NDArray[np.intp] | None = None) -> list[Array]:
        """Lift [m] at law angles [rad] and its derivatives by the angle, up to an order; each of the shape of `angle`.

        Args:
            segment: the segment in force at each angle, where it does not follow from the angle: one of a side.
        """
        angle = np.asarray(angle, dtype=float)
        index = np.broadcast_to(self.segment_at(angle) if segment is None else segment, angle.shape)
        found = [np.zeros(angle.shape) for _ in range(order + 1)]
        for i in np.unique(index):
            part, here = self.segments[i], index == i
            middle = self.begins[i] + 0.5 * part.over
            # A segment that is in force may be asked a little beyond its ends; whole turns mean nothing.
            x = 0.5 + (np.remainder(angle[here] - middle + math.pi, REVOLUTION) - math.pi) / part.over
            for k in range(order + 1):
                found[k][here] = part.height(x, k) + (self._starts_at[i] if k == 0 else 0.0)
        return found

    def law_angle(self, x: Array, y: Array) -> Array:
        """Law angle [rad] of a roller's centre (x, y) [m] in the cam's frame, up to whole turns."""
        height = np.sqrt(x * x + y * y - self.offset**2)
        return np.asarray(self.sense * (self.begin + np.arctan2(self.offset, height) - np.arctan2(y, x)))

    def active_arc(self, x: Array, y: Array) -> NDArray[np.intp]:
        """Index of the segment in force where the roller's centre is at (x, y) [m] in the cam's frame; shape of x."""
        return np.asarray(self.segment_at(self.law_angle(x, y)))

    def jumps(self, first: int, second: int) -> bool:
        """True where acceleration or jerk jump between two neighbouring segments."""
        following = [(i, (i + 1) % len(self.segments)) for i in (first, second)]
        return any(self._jumps(*pair) for pair in following if set(pair) == {first, second})

    def _jumps(self, first: int, second: int) -> bool:
        last, following = self.segments[first], self.segments[second]
        for order in (2, 3):
            gap = last.height(np.array(1.0), order) - following.height(np.array(0.0), order)
            if abs(float(gap)) > ROUNDING * max(abs(s.lift) / s.over**order for s in (last, following)):
                return True
        return False

    # -- geometry ------------------------------------------------------------------------------------------------

    def pitch(self, angle: Array, segment: NDArray[np.intp] | None = None) -> Pitch:
        """The pitch curve at law angles (T,) [rad]; `segment` as in `lift`."""
        s, slope, bend = self.lift(angle, 2, segment)
        height, e, turned = self.least_height + s, self.offset, self.sense * slope
        direction = self.begin - self.sense * np.asarray(angle)
        along = np.column_stack([np.cos(direction), np.sin(direction)])
        across = np.column_stack([-along[:, 1], along[:, 0]])
        rate = np.hypot(slope + self.sense * e, height)
        normals = (height[:, None] * along + (turned + e)[:, None] * across) / rate[:, None]
        curvature = ((turned + e) * (2.0 * turned + e) + height * (height - bend)) / rate**3
        return Pitch(height[:, None] * along + e * across, normals, curvature, rate)

    def points(self, angle: Array, segment: NDArray[np.intp] | None = None) -> Array:
        """Points (T, 2) [m] of the profile that touch the roller at law angles (T,) [rad]."""
        pitch = self.pitch(angle, segment)
        return pitch.points - self.roller_radius * pitch.normals

    def outline(self, count: int) -> Array:
        """Points (N, 2) [m] of the profile all the way round, counter-clockwise, the first one again at the end."""
        return self.points(-self.sense * np.linspace(0.0, REVOLUTION, count))

    def joints(self) -> tuple[Array, Array]:
        """Points (N, 2) [m] of the profile where segments meet, and its outward normals there (N, 2)."""
        return self.points(self.begins), self.pitch(self.begins).normals

    @cached_property
    def _curvatures(self) -> Array:
        """Of the pitch curve, segment by segment with both ends, which is where most extremes are [1/m]."""
        found = []
        for i, (start, part) in enumerate(zip(self.begins, self.segments, strict=True)):
            count = 2 + math.ceil(SAMPLES * part.over / REVOLUTION)
            found.append(self.pitch(np.linspace(start, start + part.over, count), np.full(count, i)).curvature)
        return np.concatenate(found)

    @property
    def is_convex(self) -> bool:
        """True of a profile without hollow parts."""
        return bool(self._curvatures.min() >= 0.0)

    @property
    def least_radius(self) -> float:
        """Least radius of curvature of the profile where it is convex [m]; negative where it would be undercut."""
        return 1.0 / float(self._curvatures.max()) - self.roller_radius


Profile: TypeAlias = CamProfile | LawProfile


def check_cut(profile: LawProfile) -> None:
    """Refuse a profile that its roller cannot roll on; raises InvalidInput, which names the least base radius."""
    if can_roll(profile):
        return
    bend = profile.least_radius + profile.roller_radius
    why = (
        f"the pitch curve bends with a radius of {bend:.4g} m"
        if profile.least_radius <= 0.0
        else "it meets the profile elsewhere, too"
    )
    raise InvalidInput(
        f"a roller of {profile.roller_radius:g} m undercuts the cam: {why}; a base_radius of at least "
        f"{least_base_radius(profile, can_roll):.6g} m or a smaller roller is needed"
    )


def can_roll(profile: LawProfile) -> bool:
    """True where the pitch curve bends less than the roller, and the roller nowhere reaches into the profile."""
    if profile.least_radius <= 0.0:
        return False
    angle = np.linspace(0.0, REVOLUTION, PLACES, endpoint=False)
    rim, centres = profile.points(angle), profile.pitch(angle).points
    nearest = np.hypot(*(rim[:, None, :] - centres[None, :, :]).transpose(2, 0, 1)).min()
    return bool(nearest >= profile.roller_radius * (1.0 - TOUCHING))


def concave_reason(profile: Profile) -> str | None:
    """None, or why a profile cannot be given to engines that collide convex shapes."""
    if isinstance(profile, CamProfile) or profile.is_convex:
        return None
    enough = least_base_radius(profile, lambda other: other.is_convex)
    return (
        "the cam's profile is hollow in places, and a collision shape is convex: a base_radius of at least "
        f"{enough:.6g} m makes it so"
    )


def least_base_radius(profile: LawProfile, good: Callable[[LawProfile], bool]) -> float:
    """The least base radius [m], rounded up, from which on a profile of the same law is good; it is not yet."""
    low = high = profile.base_radius
    for _ in range(DOUBLINGS):
        high *= 2.0
        if good(replace(profile, base_radius=high)):
            break
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if good(replace(profile, base_radius=middle)) else (middle, high)
    return high * (1.0 + 1e-6)
