"""Classic quantities of a linkage: over one revolution, and the motion of all links at one crank angle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.centres import InstantCentre, instant_centres
from conrod.exact.linkage.crank_range import CrankRange, SampledMotion, bisect, crank_range, sample_motion
from conrod.exact.linkage.link_motion import LinkMotion as LinkMotion
from conrod.exact.linkage.relative_motion import RelativeMotion, SlidingMotion, relative_motions, sliding_motions
from conrod.exact.linkage.transmission import TransmissionAngle, transmission_angles
from conrod.exact.motion import Array, Motion
from conrod.mechanism.mechanism import GROUND, LowerPair, Prismatic
from conrod.mechanism.units import REVOLUTION

MAX_REST_RATE = 1e-11  # a link rests below this share of its largest rate
RETURN_TOLERANCE = 1e-9  # share of a link's stroke that rounding adds to a motion that returns
ANGLE_ROUNDING = 1e-9  # [rad], below a full turn: taken for angle 0


@dataclass(frozen=True)
class DeadCentre:
    """A position of a driven link at which it rests and turns back."""

    angle: float  # crank angle [rad] at which the link comes to rest; in [0, 2 pi) where the crank turns fully
    until: float  # crank angle [rad] at which it leaves again, `angle` unless it dwells; may pass 2 pi
    value: float  # where the link is then, [m] along its slide or its turn phi [rad]
    greatest: bool  # whether the link turns back from a greatest value, or from a least one


@dataclass(frozen=True)
class OutputLink:
    """Motion of a driven link that a slide or a pin guides in the ground.

    Attributes:
        gain: change of the link's displacement or rotation over a turn of the crank [m] or [rad]; 0 if it returns.
        forward: crank angle [rad] from the least to the greatest value without dwells; None unless each turn has
            exactly one stroke to and one fro.
    """

    link: str  # its name
    joint: str  # name of the joint that guides it
    unit: str  # "m" of a slide, "rad" of a pin
    dead_centres: tuple[DeadCentre, ...]  # in the order of the crank angle
    gain: float
    stroke: float | None  # greatest less least value [m] or [rad]; None for a link that does not come back
    forward: float | None
    backward: float | None  # the same from greatest to least

    @property
    def time_ratio(self) -> float | None:
        """Ratio of the slower stroke's time to the quicker one's at constant speed; 1 without a quick return."""
        if self.forward is None or self.backward is None:
            return None
        return max(self.forward, self.backward) / min(self.forward, self.backward)


def output_links(course: SampledMotion) -> tuple[OutputLink, ...]:
    """Motions of all driven links that the ground guides, by name."""
    mechanism = course.kinematics.mechanism
    links = sorted(name for name in mechanism.body_index if name != mechanism.crank)
    return tuple(_output(course, link, guide) for link in links if (guide := mechanism.guide(link)))


def _output(course: SampledMotion, link: str, joint: LowerPair) -> OutputLink:
    """Motion of one link that a joint guides in the ground."""
    weights = _weights(course, link, joint)
    values, rates, angles = course.samples @ weights, course.derivatives @ weights, course.angles
    full, count = course.kinematics.repeats, len(angles)
    gain = float(values[-1] - values[0]) if full else _steady_gain(course, weights, values)
    unit = "m" if isinstance(joint, Prismatic) else "rad"
    limit = MAX_REST_RATE * float(np.abs(rates).max())
    signs = np.where(np.abs(rates) <= limit, 0.0, np.sign(rates))
    if full:
        # Twice round, so that a rest across angle 0 is seen whole.
        angles, count = np.concatenate([angles[:-1], angles[:-1] + REVOLUTION]), count - 1
        signs = np.concatenate([signs[:-1], signs[:-1]])
    # At each change of sign the last sample before and the first after it; at rest over several lies a dwell.
    turns = [(i, j) for i, j in pairwise(np.flatnonzero(signs).tolist()) if signs[i] != signs[j] and i < count]
    found = (
        _dead_centre(course, weights, limit, (float(angles[i]), float(angles[j])), bool(signs[i] > 0.0), j > i + 3)
        for i, j in turns
    )
    centres = sorted(found, key=lambda centre: centre.angle)
    if abs(gain) > RETURN_TOLERANCE * float(np.ptp(values)):
        return OutputLink(link, joint.name, unit, tuple(centres), gain, None, None, None)
    reached = [*values, *(centre.value for centre in centres)]
    stroke, forward, backward = float(max(reached) - min(reached)), None, None
    if full and len(centres) == 2 and centres[0].greatest != centres[1].greatest:
        least, greatest = sorted(centres, key=lambda centre: centre.greatest)
        forward, backward = (greatest.angle - least.until) % REVOLUTION, (least.angle - greatest.until) % REVOLUTION
    return OutputLink(link, joint.name, unit, tuple(centres), 0.0, stroke, forward, backward)


def _steady_gain(course: SampledMotion, weights: Array, values: Array) -> float:
    """Gain of the first turn if the next one adds the same, as for a wheel of a gear train; else 0."""
    if not course.kinematics.turns_fully:
        return 0.0
    gain = float(values[-1] - values[0])
    after_next = float((course.kinematics.poses(np.array([2.0 * REVOLUTION])) @ weights)[0])
    return gain if abs(after_next - values[-1] - gain) <= RETURN_TOLERANCE * float(np.ptp(values)) else 0.0


def _weights(course: SampledMotion, link: str, joint: LowerPair) -> Array:
    """Weights w (3 n,) for which w . q is a link's displacement along its slide, or its rotation."""
    mechanism = course.kinematics.mechanism
    weights = np.zeros(3 * len(mechanism.bodies))
    first = 3 * mechanism.body_index[link]
    if isinstance(joint, Prismatic):
        # A slide declared the other way round has its line in the link, which does not turn.
        turn = 0.0 if joint.a == GROUND else float(course.samples[0, first + 2])
        weights[first : first + 2] = math.cos(turn + joint.direction), math.sin(turn + joint.direction)
    else:
        weights[first + 2] = 1.0
    return weights


def _dead_centre(
    course: SampledMotion, weights: Array, limit: float, between: tuple[float, float], greatest: bool, dwells: bool
) -> DeadCentre:
    """Locate the dead centre between two crank angles, and the end of its dwell."""

    def rate(at: float) -> float:
        return float((course.kinematics.derivatives(np.array([at]), 1)[1] @ weights)[0])

    first, last = between
    if dwells:
        stops = bisect(first, last, lambda at: abs(rate(at)) > limit)
        leaves = bisect(last, stops, lambda at: abs(rate(at)) > limit)
    else:
        stops = leaves = bisect(first, last, lambda at: rate(at) > 0.0 if greatest else rate(at) < 0.0)
    value = float((course.kinematics.poses(np.array([stops])) @ weights)[0])
    angle = stops
    if course.kinematics.repeats:
        # Rounding just below angle 0 is angle 0.
        angle = stops % REVOLUTION if REVOLUTION - stops % REVOLUTION > ANGLE_ROUNDING else 0.0
    return DeadCentre(angle, angle + (leaves - stops), value, greatest)


@dataclass(frozen=True)
class TurnQuantities:
    """Quantities of a linkage over one revolution, its driver's span, or all that it reaches.

    Attributes:
        transmission: transmission and pressure angles of links that a rod, a block or a cam pushes.
    """

    crank_range: CrankRange  # limits of the input
    outputs: tuple[OutputLink, ...]  # strokes, dead centres and time ratios of the links that are guided in the ground
    transmission: tuple[TransmissionAngle, ...]


@dataclass(frozen=True)
class InstantQuantities:
    """Motion of all links and observed points at one crank angle, with instant centres and relative motions."""

    angle: float  # of the crank [rad]
    speed: float  # of the crank [rad/s]
    links: tuple[LinkMotion, ...]  # that move
    points: Motion  # of the observed points; one row
    centres: tuple[InstantCentre, ...]  # of every pair of links, the ground included
    relative: tuple[RelativeMotion, ...]  # of every pair of pins and observed points on one moving link
    sliding: tuple[SlidingMotion, ...]  # of the blocks and rollers that slide along a moving link


def turn_quantities(kinematics: Kinematics) -> TurnQuantities:
    """Crank range, strokes, dead centres and transmission angles of a linkage."""
    course = sample_motion(kinematics)
    return TurnQuantities(crank_range(kinematics), output_links(course), transmission_angles(course))


def instant_quantities(kinematics: Kinematics, angle: float, speed: float) -> InstantQuantities:
    """Motion of all links, instant centres and parts of accelerations at one crank angle.

    Args:
        angle: of the crank [rad].
        speed: of the crank [rad/s], constant.

    Raises:
        InvalidInput: the linkage does not reach the angle.
    """
    at = np.array([angle])
    in_time = [d.reshape(-1, 3) * speed**k for k, d in enumerate(kinematics.derivatives(at, 2))]
    mechanism = kinematics.mechanism
    links = tuple(LinkMotion(body.name, *(rows[i] for rows in in_time)) for i, body in enumerate(mechanism.bodies))
    return InstantQuantities(
        angle,
        speed,
        links,
        kinematics.motion(at, speed),
        instant_centres(links, kinematics.size),
        relative_motions(mechanism, links),
        sliding_motions(mechanism, links),
    )
