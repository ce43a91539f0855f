"""A run at constant crank speed in pieces: what an engine records of each stretch, with its clock and the verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from conrod.engines.engine import Machine
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.outcome import Verdict, judge
from conrod.runs.trajectory import (
    BodyStates,
    BodyTracks,
    FieldByField,
    Instants,
    Outcome,
    Piece,
    PointTracks,
    Settings,
    Track,
    Trajectory,
)


@dataclass(frozen=True)
class Recorded:
    """Recording of a stretch of a run; samples of the stretch before may come first.

    Attributes:
        clock: of the engine, at the stretch's own samples [s]; None where it has none.
        ended: the verdict on the run so far, from the one on its motion alone.
    """

    bodies: BodyTracks
    points: Mapping[str, PointTracks]
    clock: Array | None = None
    warnings: Mapping[str, int] = field(default_factory=dict)
    drive_torque: Array | None = None
    ended: Callable[[Verdict], Verdict] = lambda judged: judged


def pieces(
    machine: Machine,
    settings: Settings,
    version: str,
    revolutions: float,
    start_angle: float,
    steps: int,
    record: Callable[[int, Array], Recorded],
    kept: int = 0,
) -> Iterator[Piece]:
    """A run in pieces of so many steps; the first one has the start beside its steps.

    Args:
        version: of the engine.
        record: steps on to the last of some samples, of which it gets the number of the first one in the run and the
            nominal times (T,) [s], and tells what the engine has there.
        kept: samples of the stretch before, at most, that come first among them.
    """
    begun, samples = start_angle / machine.speed, round(settings.steps_per_revolution * revolutions) + 1
    clock, judged = begun, Verdict(Outcome.COMPLETED)
    for first in (0, *range(steps + 1, samples, steps)):
        last = min(max(first, 1) + steps, samples)
        # From the step index: a clock that sums its steps drifts.
        known = max(0, first - kept)
        times = np.asarray(begun + settings.timestep * np.arange(known, last), dtype=float)
        # A state that is not finite any more stays so; how the run ended is judged from it.
        with np.errstate(all="ignore"):
            found = record(known, times)
            new = _last(last - first)
            bodies, points = new(found.bodies), {name: new(tracks) for name, tracks in found.points.items()}
            judged = judge(machine.kinematics, bodies, machine.speed, judged)
        verdict = found.ended(judged)
        ticks = found.clock
        if ticks is None:
            # The clock that a user keeps of an engine that has none: step by step, with its rounding.
            ticks = np.full(last - first + (first > 0), settings.timestep)
            ticks[0] = clock
            ticks = np.add.accumulate(ticks)[first - last :]
        clock = float(ticks[-1])
        trajectory = Trajectory(
            settings.engine, version, settings, machine.speed, revolutions,
            verdict.outcome, verdict.reason, points, bodies,
        )  # fmt: skip
        yield Piece(trajectory, first, ticks, found.warnings, found.drive_torque)


def _last(samples: int) -> FieldByField:
    """Cuts off all but so many samples of each track."""
    return FieldByField(lambda parts: parts[0][-samples:])


def crank_states(mechanism: Mechanism, times: Array, poses: Array, rates: Array, accelerations: Array) -> BodyStates:
    """States of all bodies (T, 3 n) at times (T,) [s], with where the crank was by the engine's own account."""
    driver, k = mechanism.driver, 3 * mechanism.body_index[mechanism.crank] + 2
    turn, rate, acceleration = poses[:, k] - driver.start, rates[:, k], accelerations[:, k]
    at = Instants(times, driver.sense * turn, driver.sense * rate, driver.sense * acceleration)
    return BodyStates(at, poses, rates, accelerations)


def points_of(kinematics: Kinematics, states: BodyStates) -> dict[str, PointTracks]:
    """Motion of the observed points that belongs to states of one instant each."""
    motion = kinematics.point_derivatives([states.poses, states.rates, states.accelerations])
    return {name: PointTracks(*(Track(states.instants, values) for values in of)) for name, of in motion.items()}
