"""A cam by its equivalent linkage in pymunk: one space for each arc, and the state carried from one to the next.

Position and velocity of cam and follower go over as the engine has them, a rod's follow from its pins; nothing else is
written but the cam's own angle, as in every run.

Which instants are told: positions at every step. A velocity belongs to half a step after it, see `Staggered`; that of
the last step on an arc belongs to an instant at which another linkage drives the follower, and is not told, nor is the
acceleration that is made of it. Accelerations begin anew with the third step on every arc, as at the start of a run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.linkage_legs import ENDLESS, LEAST_STEPS, Leg, legs
from conrod.engines.pymunk.built import Build
from conrod.engines.pymunk.dynamics import Stretch, body_states, stretches, trajectory_of
from conrod.engines.pymunk.pieces import piece_of
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import build
from conrod.engines.pymunk.stepping import state
from conrod.engines.pymunk.timing import BareRun
from conrod.exact.equivalent_linkage import EquivalentLinkage, equivalent_linkage
from conrod.exact.motion import Array
from conrod.runs.outcome import judge
from conrod.runs.trajectory import Piece, Trajectory, joined


def run(machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float) -> Trajectory:
    """One run at constant crank speed, sampled at every step; see the module for the instants."""
    steps = max(round(settings.steps_per_revolution * revolutions), 1)
    whole = joined(list(pieces(machine, settings, revolutions, start_angle, steps))).trajectory
    assert whole.bodies is not None
    verdict = judge(machine.kinematics, whole.bodies, machine.speed)
    return replace(whole, outcome=verdict.outcome, reason=verdict.reason)


def pieces(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float, length: int
) -> Iterator[Piece]:
    """The same run in pieces of about so many steps, which end at every switch."""
    spaces = Spaces(machine, settings)
    steps, done = round(settings.steps_per_revolution * revolutions), 0
    clock = start_angle / machine.speed
    poses, slopes = machine.kinematics.derivatives(np.array([start_angle]), 1)
    poses, rates = poses[0], slopes[0] * machine.speed
    for leg in legs(spaces.linkage, machine, settings.steps_per_revolution, steps, start_angle):
        made, own = spaces.entered(leg, poses, rates), replace(settings, timestep=leg.step)
        begin = leg.begin - leg.offset
        for stretch in stretches(leg.machine, made, own, begin, leg.steps, piece_length(leg.steps, length)):
            told = _told(leg, stretch, done)
            trajectory = trajectory_of(machine, settings, revolutions, told)
            piece = piece_of(trajectory, made.form, own, told, clock)
            clock = float(piece.clock[-1])
            yield piece
        poses, rates = spaces.left(leg, made)
        done += leg.steps


def piece_length(steps: int, length: int) -> int:
    """Steps of a piece of so many, such that none is left with too few to have an acceleration."""
    length = max(length, LEAST_STEPS)
    while 0 < steps % length < LEAST_STEPS and length < steps:
        length += 1
    return length


class Spaces:
    """A space for each arc of a machine's cam, built when it is first entered."""

    def __init__(self, machine: Machine, settings: PymunkSettings) -> None:
        self.linkage: EquivalentLinkage = equivalent_linkage(machine.kinematics.mechanism)
        self._settings = settings
        self._built: dict[int, Build] = {}

    def entered(self, leg: Leg, poses: Array, rates: Array) -> Build:
        """The space of a leg, with poses and rates (3 n,) of the machine's bodies taken over."""
        if leg.index not in self._built:
            self._built[leg.index] = build(leg.machine, self._settings)
        made = self._built[leg.index]
        made.place(*leg.entered(poses, rates))
        return made

    def left(self, leg: Leg, made: Build) -> tuple[Array, Array]:
        """Poses and rates (3 n,) of the machine's bodies, as a space has them now."""
        poses, rates = made.form.completed(body_states(made.mechanism, *state(made)))
        return leg.left(poses[0], rates[0])


def _told(leg: Leg, stretch: Stretch, done: int) -> Stretch:
    """What a run tells of a leg's stretch, in the machine's own account; so many steps were done before."""
    last = stretch.first + len(stretch.bodies.position.poses) > leg.steps
    # The first sample of a leg is the last one of the leg before.
    doubled = int(done > 0 and stretch.first == 0)
    beyond = -1 if leg.to_switch and last else None
    keep = (slice(doubled, None), slice(0, beyond), slice(0, beyond))
    observed = [point.name for point in leg.whole.observed]
    return replace(
        stretch,
        first=done + stretch.first + doubled,
        bodies=leg.bodies(stretch.bodies, keep),
        points={name: leg.points(stretch.points[name], keep) for name in observed},
    )


class LinkageRun:
    """The machine from the exact state of crank angle 0; calling it advances it by so many steps.

    Where a linkage takes over, a call of it hands the state on, which is part of what a run costs; the spaces are
    built before. One turn after the other, without end.
    """

    def __init__(self, machine: Machine, settings: PymunkSettings) -> None:
        self._spaces = Spaces(machine, settings)
        self._settings = settings
        self._speed = machine.speed
        turn = settings.steps_per_revolution
        self._legs = legs(self._spaces.linkage, machine, turn, ENDLESS, 0.0)
        poses, slopes = machine.kinematics.derivatives(np.zeros(1), 1)
        for leg in legs(self._spaces.linkage, machine, turn, turn, 0.0):
            self._spaces.entered(leg, poses[0], slopes[0] * machine.speed)
        self._enter(poses[0], slopes[0] * machine.speed)

    def __call__(self, steps: int) -> None:
        while steps > 0:
            now = min(steps, self._left)
            self._bare(now)
            steps -= now
            self._left -= now
            if self._left == 0:
                self._enter(*self.state())

    def state(self) -> tuple[Array, Array]:
        """Poses and rates (3 n,) of the machine's bodies."""
        return self._spaces.left(self._leg, self._made)

    def _enter(self, poses: Array, rates: Array) -> None:
        self._leg = next(self._legs)
        self._left = self._leg.steps
        self._made = self._spaces.entered(self._leg, poses, rates)
        substeps = self._settings.substeps
        self._bare = BareRun(
            self._made.space,
            self._made.crank,
            self._made.pushed,
            timestep=self._leg.step / substeps,
            turn=self._leg.first_turn,
            spin=self._made.mechanism.driver.sense * self._speed,
            substeps=substeps,
        )
