"""Dynamic mode: Box2D steps, conrod records. Nothing is written after the start but the crank's own angle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.engines.box2d.library import Box2D
from conrod.engines.box2d.settings import Box2DSettings
from conrod.engines.box2d.stepping import Stepper
from conrod.engines.centres import body_states
from conrod.engines.engine import PIECE, Machine, summed_clock
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.outcome import Verdict, judge
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, Outcome, Piece, PointTracks, Track, Trajectory

KEPT = 2  # samples before a stretch of a run, from which its velocities and accelerations follow


def run(
    machine: Machine, settings: Box2DSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    stepper, kinematics, h = Stepper(machine, settings, start_angle), machine.kinematics, settings.timestep
    whole, begun = round(settings.steps_per_revolution * revolutions), start_angle / machine.speed
    known, clock, verdict = [part[None] for part in stepper.state()], begun, Verdict(Outcome.COMPLETED)
    for first in (0, *range(steps + 1, whole + 1, steps)):
        last, old = min(max(first, 1) + steps, whole + 1), len(known[0])
        fresh = stepper.recorded(last - max(first, 1))
        centres, rates = (np.concatenate(pair) for pair in zip(known, fresh, strict=True))
        times = np.asarray(begun + h * np.arange(max(first, 1) - old, last), dtype=float)
        # A state that is not finite any more stays so; how the run ended is judged from it.
        with np.errstate(all="ignore"):
            bodies, points = tracks(machine, stepper.made.mechanism, h, times, centres, rates, old if first else 0)
            verdict = judge(kinematics, bodies, machine.speed, verdict)
        known = [centres[-KEPT:], rates[-KEPT:]]
        clocks = summed_clock(clock, h, last - first, begins=first == 0)
        clock = float(clocks[-1])
        trajectory = Trajectory(
            settings.engine, Box2D.__version__, settings, machine.speed, revolutions, verdict.outcome,
            verdict.reason, points, bodies,
        )  # fmt: skip
        yield Piece(trajectory, first, clocks, warnings={}, solver=None, drive_torque=None)


def tracks(
    machine: Machine, mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array, old: int
) -> tuple[BodyTracks, dict[str, PointTracks]]:
    """States of the bodies and motion of the observed points, each at the instants that it belongs to.

    A step makes the velocities fit the joints where the bodies are, and then moves these: v_n fits x_(n-1), and belongs
    to t_(n-1), a whole step before it is read. What then closes the joints again (the positions' iteration) moves the
    bodies alone. Acceleration is the difference of two velocities and belongs to the middle between their instants.

    Args:
        mechanism: whose bodies' centres of gravity these are.
        times: (T,) [s], of the samples.
        centres, rates: as read at the samples (T, 3 n), of which the first `old` ones are of the stretch before.
    """
    kinematics, driver, crank = machine.kinematics, mechanism.driver, 3 * mechanism.body_index[mechanism.crank] + 2

    def at(times: Array, poses: Array, rates: Array, bends: Array) -> BodyStates:
        turn, spin, gain = (values[:, crank] for values in (poses, rates, bends))
        instants = Instants(times, driver.sense * (turn - driver.start), driver.sense * spin, driver.sense * gain)
        return BodyStates(instants, poses, rates, bends)

    poses, speeds = body_states(mechanism, centres[:-1], rates[1:])  # at one instant each
    bends = np.diff(speeds, axis=0) / h
    middle = 0.5 * (times[:-2] + times[1:-1]), 0.5 * (poses[:-1] + poses[1:]), 0.5 * (speeds[:-1] + speeds[1:])
    here = body_states(mechanism, centres[old:], rates[old:])
    known = max(old - 1, 0)  # velocities that the stretch before has
    bodies = BodyTracks(
        at(times[old:], *here, np.zeros_like(here[0])),
        at(times[:-1][known:], poses[known:], speeds[known:], np.zeros_like(poses[known:])),
        at(*middle, bends),
    )
    places = kinematics.point_derivatives([here[0]])
    velocities = kinematics.point_derivatives([poses, speeds])
    return bodies, {
        name: PointTracks(
            Track(bodies.position.instants, place),
            Track(bodies.velocity.instants, velocities[name][1][known:]),
            Track(bodies.acceleration.instants, np.diff(velocities[name][1], axis=0) / h),
        )
        for name, (place,) in places.items()
    }
