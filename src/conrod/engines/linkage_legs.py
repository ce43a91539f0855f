"""A run of a cam by its equivalent linkage: legs, in each of which one linkage is stepped. Imports no engine.

The steps of a turn are shared among the arcs in proportion to their angle, so that a step ends at every switch. A step
that is cut there instead would be short by any factor, and pymunk, which mends a gap within one step whatever its
length, would mend it at a speed larger by the same factor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from conrod.engines.engine import Machine
from conrod.errors import InvalidInput
from conrod.exact.equivalent_linkage import ROD, TURN, ArcLinkage, EquivalentLinkage, arcs_of
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import BREAK_WIDTH, Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, PointTracks, Track

# So many steps on an arc leave an acceleration of a scheme that tells the first one from four samples.
LEAST_STEPS = 4
ENDLESS = 1 << 62  # steps of a run whose end is not known when it begins


@dataclass(frozen=True)
class LinkageMachine:
    """One linkage as engines take it."""

    speed: float
    kinematics: Kinematics

    @classmethod
    def of(cls, linkage: ArcLinkage, speed: float) -> LinkageMachine:
        """A linkage at a crank speed [rad/s]."""
        return cls(speed, Kinematics(linkage.mechanism))


@dataclass(frozen=True)
class Leg:
    """Consecutive steps with one linkage.

    Attributes:
        index: of the linkage in `EquivalentLinkage.arcs`.
        linkage: itself.
        machine: the same, as engines take it.
        whole: the mechanism with its contact.
        begin: crank angle of the machine at its start [rad].
        turns: whole turns that the crank has behind it.
        offset: crank angle of the machine at which the linkage's own is zero [rad].
        steps: number of steps.
        step: length of each [s].
        switches: whether another linkage follows.
        from_switch, to_switch: whether it begins at a joint of two arcs, and whether it reaches one. There the
            acceleration jumps, and that of neither side is told.
    """

    index: int
    linkage: ArcLinkage
    machine: LinkageMachine
    whole: Mechanism
    begin: float
    turns: int
    offset: float
    steps: int
    step: float
    switches: bool
    from_switch: bool
    to_switch: bool

    @property
    def first_turn(self) -> float:
        """Turn of the cam's body at the start [rad], by the linkage's own count."""
        return self.linkage.mechanism.crank_turn(self.begin - self.offset)

    def entered(self, poses: Array, rates: Array) -> tuple[Array, Array]:
        """Poses and rates (3 m,) of the linkage from those of the machine's bodies (3 n,): the rod is between its pins.

        They are taken as they are: what an engine left of a gap stays a gap, between the rod and the roller.
        """
        contact, index = self.whole.cam_contacts[0], self.whole.body_index
        local = poses.copy()
        local[3 * index[contact.a] + 2] -= self._behind
        first = _pin(local, rates, 3 * index[contact.a], arcs_of(self.whole)[self.linkage.arc].centre)
        last = _pin(local, rates, 3 * index[contact.b], contact.roller_centre)
        (dx, dy), (vx, vy) = last[0] - first[0], last[1] - first[1]
        near = self.linkage.mechanism.poses[ROD][2]
        turn = near + math.remainder(math.atan2(dy, dx) - near, TURN)
        spin = (dx * vy - dy * vx) / (dx * dx + dy * dy)
        return np.array([*local, *first[0], turn]), np.array([*rates, *first[1], spin])

    def left(self, poses: Array, rates: Array) -> tuple[Array, Array]:
        """Poses and rates (3 n,) of the machine's bodies from those of the linkage (3 m,)."""
        columns = 3 * len(self.whole.bodies)
        own = poses[:columns].copy()
        own[3 * self.whole.body_index[self.whole.crank] + 2] += self._behind
        return own, rates[:columns].copy()

    @property
    def _behind(self) -> float:
        return self.whole.driver.sense * TURN * self.turns

    # -- from the linkage's own account to the machine's ---------------------------------------------------------------

    def instants(self, own: Instants) -> Instants:
        """Instants with the machine's crank angle and time."""
        return replace(own, times=own.times + self.offset / self.machine.speed, angle=own.angle + self.offset)

    def states(self, own: BodyStates, keep: slice) -> BodyStates:
        """States of the machine's bodies."""
        columns = 3 * len(self.whole.bodies)
        poses = own.poses[keep, :columns].copy()
        poses[:, 3 * self.whole.body_index[self.whole.crank] + 2] += self._behind
        return BodyStates(
            self.instants(own.instants[keep]), poses, own.rates[keep, :columns], own.accelerations[keep, :columns]
        )

    def points(self, own: PointTracks, keep: tuple[slice, slice, slice]) -> PointTracks:
        """Tracks of an observed point; of positions, velocities and accelerations those that are kept."""
        tracks = (own.position, own.velocity, own.acceleration)
        told = (Track(self.instants(t.instants[k]), t.values[k]) for t, k in zip(tracks, keep, strict=True))
        return PointTracks(*told)

    def bodies(self, own: BodyTracks, keep: tuple[slice, slice, slice]) -> BodyTracks:
        """States at all instants; of each, those that are kept."""
        tracks = (own.position, own.velocity, own.acceleration)
        return BodyTracks(*(self.states(t, k) for t, k in zip(tracks, keep, strict=True)))


def _pin(poses: Array, rates: Array, body: int, point: tuple[float, float]) -> tuple[Array, Array]:
    """Place and velocity of a point of the body whose columns begin at an index."""
    c, s, spin = math.cos(poses[body + 2]), math.sin(poses[body + 2]), rates[body + 2]
    arm = np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])
    return poses[body : body + 2] + arm, rates[body : body + 2] + spin * np.array([-arm[1], arm[0]])


def linkages_at(linkage: EquivalentLinkage, machine: Machine, angle: Array) -> Iterator[tuple[LinkageMachine, Array]]:
    """The linkages that crank angles (T,) [rad] of a machine are on, with their own crank angles there."""
    active = linkage.active(angle)
    for index in np.unique(active):
        arc = linkage.arcs[index]
        # Within half a turn of the middle, which the linkage need not be able to leave.
        yield LinkageMachine.of(arc, machine.speed), _near(angle[active == index] - arc.middle)


def _near(angle: Array) -> Array:
    return np.asarray(np.remainder(angle + np.pi, TURN) - np.pi)


def legs(linkage: EquivalentLinkage, machine: Machine, turn: int, steps: int, start: float) -> Iterator[Leg]:
    """The legs of a run.

    Args:
        turn: steps in a turn of the crank.
        steps: of the whole run; it ends with them, wherever the crank is then.
        start: crank angle [rad] of the beginning.

    Raises:
        InvalidInput: the steps are too few for so many arcs.
    """
    shared, sense, several = shared_steps(linkage, turn), math.copysign(1.0, machine.speed), len(linkage.arcs) > 1
    machines = [LinkageMachine.of(arc, machine.speed) for arc in linkage.arcs]
    index = int(linkage.active(np.array([start]), "right" if sense > 0 else "left")[0])
    begin, turns = start, _turns(linkage.arcs[index], start, sense)
    while steps > 0:
        arc = linkage.arcs[index]
        first, last = (edge + TURN * turns for edge in (arc.start, arc.stop)[:: int(sense)])
        whole = several and abs(begin - first) <= BREAK_WIDTH
        # Of a whole arc the extent itself, so that its steps are the same in every turn to the last bit.
        left = arc.extent if whole else abs(last - begin)
        count = max(1, round(shared[index] * left / arc.extent)) if several else steps
        yield Leg(
            index,
            arc,
            machines[index],
            linkage.whole,
            begin,
            turns,
            arc.middle + TURN * turns,
            min(count, steps),
            (left / count if several else TURN / turn) / abs(machine.speed),
            switches=count < steps,
            from_switch=whole,
            to_switch=several and count <= steps,
        )
        steps -= count
        following = (index + int(sense)) % len(linkage.arcs)
        begin, index = last, following
        turns = _turns(linkage.arcs[index], begin, sense)


def _turns(arc: ArcLinkage, angle: float, sense: float) -> int:
    """Whole turns that the interval of an arc lies ahead, which a crank at an angle is in, or enters."""
    return math.floor((angle + sense * BREAK_WIDTH - arc.start) / TURN)


def shared_steps(linkage: EquivalentLinkage, turn: int) -> list[int]:
    """Steps of a turn on each arc, in proportion to its angle as nearly as whole numbers are, even ones if possible.

    Even ones have a step end in the middle of the dwell, where runs begin: a turn is then a whole number of steps from
    there.

    Raises:
        InvalidInput: the steps are too few for so many arcs.
    """
    least, each = LEAST_STEPS * len(linkage.arcs), 2 - turn % 2
    if turn < least:
        raise InvalidInput(
            f"steps_per_revolution = {turn} is too few for an equivalent linkage of {len(linkage.arcs)} arcs: at least "
            f"{least}, {LEAST_STEPS} for each"
        )
    wanted = [turn / each * arc.extent / TURN for arc in linkage.arcs]
    shared = [max(LEAST_STEPS // each, math.floor(share)) for share in wanted]
    while (missing := turn // each - sum(shared)) != 0:
        lacks = [share - given for share, given in zip(wanted, shared, strict=True)]
        spare = [given > LEAST_STEPS // each for given in shared]
        # The one that lacks most gets one more; where the least number took too many, the one that has most gives one.
        best = (
            max(range(len(shared)), key=lambda i: lacks[i])
            if missing > 0
            else min((i for i in range(len(shared)) if spare[i]), key=lambda i: lacks[i])
        )
        shared[best] += 1 if missing > 0 else -1
    return [each * given for given in shared]
