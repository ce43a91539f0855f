"""Box2D, as one of conrod's engines: it steps, conrod records.

Nothing is written into the engine after the start but the crank's own angle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice

import numpy as np

from conrod.engines.box2d.model import LIBRARY_VERSION, build, refusal
from conrod.engines.box2d.settings import PRESETS, Box2DSettings
from conrod.engines.centres import body_states
from conrod.engines.engine import PIECE, Engine, Machine, run_of
from conrod.engines.recording import Recorded, crank_states, pieces
from conrod.engines.reference_loop import REFERENCE
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism, Prismatic
from conrod.runs.trajectory import BodyTracks, Piece, PointTracks, Track

TURN = 2.0 * math.pi
KEPT = 2  # samples before a stretch of a run, from which its velocities and accelerations follow


class Stepper:
    """A machine in the exact state of a crank angle [rad]; calling it advances it by so many steps.

    The engine sums speed x step, in single precision; counted steps keep the crank where it belongs. Its angle is
    written without whole turns, which would take digits from it, unless a slide holds another link's turn to it.
    """

    def __init__(self, machine: Machine, settings: Box2DSettings, angle: float) -> None:
        poses, slopes = machine.kinematics.derivatives(np.array([angle]), 1)
        self.made = build(machine.kinematics.mechanism, settings, poses[0], slopes[0] * machine.speed)
        mechanism = self.made.mechanism
        self._start, self._spin = mechanism.crank_turn(angle), mechanism.driver.sense * machine.speed
        self._settings, self._steps, self._whole = settings, 0, 0.0
        self._counted = not any(isinstance(joint, Prismatic) for joint in mechanism.joints_on(mechanism.crank))
        self._crank = mechanism.body_index[mechanism.crank]

    def __call__(self, steps: int) -> None:
        crank, step, settings = self.made.crank, self.made.world.Step, self._settings
        length, iterations = settings.timestep, (settings.velocity_iterations, settings.position_iterations)
        for _ in range(steps):
            turn = self._start + self._spin * length * self._steps
            self._whole = TURN * round(turn / TURN) if self._counted else 0.0
            crank.angle = turn - self._whole
            self._steps += 1
            step(length, *iterations)

    def states(self) -> Iterator[Array]:
        """Centres of gravity with turns [m, rad], and their rates (2, 3 n), as they are now and after every step.

        They are not numbers where the engine did not get to.
        """
        try:
            while True:
                yield self._state()
                self(1)
        except AssertionError:  # which Box2D's own checks are raised as
            while True:
                yield np.full((2, 3 * len(self.made.bodies)), math.nan)

    def _state(self) -> Array:
        scale, states = self.made.scale, list[tuple[float, ...]]()
        for body in self.made.bodies:
            place, rate = body.worldCenter, body.linearVelocity
            states.append(
                (place[0] / scale, place[1] / scale, body.angle, rate[0] / scale, rate[1] / scale, body.angularVelocity)
            )
        found = np.array(states)
        found[self._crank, 2] += self._whole
        return np.array([found[:, :3].ravel(), found[:, 3:].ravel()])


def tracks(machine: Machine, mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array) -> Recorded:
    """States of the bodies and motion of the observed points, each at the instants that it belongs to.

    A step makes the velocities fit the joints where the bodies are, and then moves these: v_n fits x_(n-1), and belongs
    to t_(n-1), a whole step before it is read. What then closes the joints again (the positions' iteration) moves the
    bodies alone. Acceleration is the difference of two velocities and belongs to the middle between their instants.

    Args:
        mechanism: whose bodies' centres of gravity these are.
        times: (T,) [s], of the samples.
        centres, rates: as read at the samples (T, 3 n).
    """
    poses, speeds = body_states(mechanism, centres[:-1], rates[1:])  # at one instant each
    bends = np.diff(speeds, axis=0) / h
    middle = 0.5 * (times[:-2] + times[1:-1]), 0.5 * (poses[:-1] + poses[1:]), 0.5 * (speeds[:-1] + speeds[1:])
    here = body_states(mechanism, centres, rates)
    bodies = BodyTracks(
        crank_states(mechanism, times, *here, np.zeros_like(here[0])),
        crank_states(mechanism, times[:-1], poses, speeds, np.zeros_like(poses)),
        crank_states(mechanism, *middle, bends),
    )
    places = machine.kinematics.point_derivatives([here[0]])
    velocities = machine.kinematics.point_derivatives([poses, speeds])
    points = {
        name: PointTracks(
            Track(bodies.position.instants, place),
            Track(bodies.velocity.instants, velocities[name][1]),
            Track(bodies.acceleration.instants, np.diff(velocities[name][1], axis=0) / h),
        )
        for name, (place,) in places.items()
    }
    return Recorded(bodies, points)


class Box2DEngine(Engine[Box2DSettings]):
    """Box2D by way of its `b2World`, in single precision: impulses for velocities, then an iteration of positions."""

    name = "box2d"
    version = LIBRARY_VERSION
    presets = PRESETS
    refusal = staticmethod(refusal)

    def run(
        self,
        machine: Machine,
        settings: Box2DSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE,
    ) -> Iterator[Piece]:
        stepper, known = Stepper(machine, settings, start_angle), list[Array]()
        states = stepper.states()

        def record(_: int, times: Array) -> Recorded:
            known[:] = known[-KEPT:]
            known.extend(islice(states, len(times) - len(known)))
            read = np.array(known).swapaxes(0, 1)
            return tracks(machine, stepper.made.mechanism, settings.timestep, times, *read)

        return pieces(machine, settings, self.version, revolutions, start_angle, steps, record, KEPT)

    def stepper(self, machine: Machine, settings: Box2DSettings) -> Stepper:
        return Stepper(machine, settings, run_of(machine, 1, 1.0)[0])

    def reference_loop(self) -> Stepper:
        """The slider-crank at its start, 1000 steps a turn."""
        return Stepper(REFERENCE, Box2DSettings.stock(REFERENCE, 1000), 0.0)


ENGINE = Box2DEngine()
