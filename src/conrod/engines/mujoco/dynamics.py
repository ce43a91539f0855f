"""Dynamic mode: MuJoCo steps, conrod records. Nothing is written into the engine after the start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

import mujoco
import numpy as np

from conrod.engines.engine import PIECE, Machine
from conrod.engines.mujoco.model import Build, build
from conrod.engines.mujoco.recorder import Recorder, ended_by_engine
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.exact.motion import Array
from conrod.runs.outcome import Verdict, judge
from conrod.runs.trajectory import (
    BodyStates,
    BodyTracks,
    Instants,
    Outcome,
    Piece,
    PointTracks,
    SolverState,
    Track,
    Trajectory,
)


class Recording(Protocol):
    """A machine that is stepped and recorded, as `Recorder` does it."""

    @property
    def warnings(self) -> Mapping[str, int]: ...

    @property
    def solver(self) -> SolverState | None: ...

    def next(self, samples: int) -> tuple[Array, Array]: ...


def run(
    machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    made = build(machine, settings)
    recorder = Recorder(made, settings, *made.start_state(machine, start_angle), start_angle / machine.speed)
    yield from recorded(made, recorder, machine, settings, revolutions, start_angle, steps, mujoco.__version__)


def recorded(
    made: Build,
    recorder: Recording,
    machine: Machine,
    settings: MuJoCoSettings,
    revolutions: float,
    start_angle: float,
    steps: int,
    version: str,
) -> Iterator[Piece]:
    """The run of a recorder that has just been started; it may be another engine's, of some version."""
    samples = round(settings.steps_per_revolution * revolutions) + 1
    poses, clock, ended, judged = None, -settings.timestep, None, Verdict(Outcome.COMPLETED)  # up to the sample before
    for first in (0, *range(steps + 1, samples, steps)):
        last = min(max(first, 1) + steps, samples)
        states, sensors = recorder.next(last - first)
        instants = instants_of(made, _times(machine, settings, start_angle, first, last), states, sensors)
        # A state that is not finite any more stays so; how the run ended is judged from it.
        with np.errstate(invalid="ignore", over="ignore"):
            bodies = body_states(made, instants, states, sensors, poses)
            points = point_tracks(made, instants, sensors) | unseen_points(machine, made, bodies)
        tracks = BodyTracks(bodies, bodies, bodies)
        ended = ended or ended_by_engine(states[:, 0], first, clock, recorder.warnings, settings)
        judged = judge(machine.kinematics, tracks, machine.speed, judged)
        verdict = verdict_of(judged, ended)
        yield Piece(
            trajectory=Trajectory(
                engine=settings.engine,
                engine_version=version,
                settings=settings,
                speed=machine.speed,
                revolutions=revolutions,
                outcome=verdict.outcome,
                reason=verdict.reason,
                points=points,
                bodies=tracks,
            ),
            first_step=first,
            clock=states[:, 0],
            warnings=recorder.warnings,
            solver=recorder.solver,
            drive_torque=drive_torque(settings, instants),
        )
        poses, clock = bodies.poses[-1], float(states[-1, 0])


def advance(
    made: Build, machine: Machine, settings: MuJoCoSettings, steps: int, start_angle: float
) -> tuple[Array, Array, Array]:
    """Nominal times (T,), full states (T, nstate) and sensor data (T, nsensordata), T = steps + 1."""
    begin = start_angle / machine.speed
    states, sensors = Recorder(made, settings, *made.start_state(machine, start_angle), begin).next(steps + 1)
    return _times(machine, settings, start_angle, 0, steps + 1), states, sensors


def _times(machine: Machine, settings: MuJoCoSettings, start_angle: float, first: int, last: int) -> Array:
    """Nominal times of the samples from one to before another."""
    # From the step index: a clock that sums its steps drifts.
    return start_angle / machine.speed + settings.timestep * np.arange(first, last, dtype=float)


def verdict_of(judged: Verdict, ended: Verdict | None) -> Verdict:
    """The verdict on the motion, unless the engine's own end says more."""
    if ended is None or (judged.outcome is not Outcome.COMPLETED and ended.outcome is not Outcome.RESET):
        return judged
    return ended


def drive_torque(settings: MuJoCoSettings, instants: Instants) -> Array | None:
    """Torque of the drive on the machine (T,) [N m], in the sense of the crank angle; None without a drive.

    The drive is a flywheel: what it gives is what it loses.
    """
    return -settings.armature * instants.acceleration if settings.armature > 0.0 else None


def instants_of(made: Build, times: Array, states: Array, sensors: Array) -> Instants:
    """Times of the samples and crank angles at these times."""
    angle, rate, mechanism = 1 + made.crank_coordinate, 1 + made.model.nq + made.crank_dof, made.form.whole
    turn = made.sensor(sensors, f"{mechanism.crank}.angular_acceleration")[:, 2]
    return Instants(times, states[:, angle], states[:, rate], mechanism.driver.sense * turn)


def point_tracks(made: Build, instants: Instants, sensors: Array) -> dict[str, PointTracks]:
    """Motion of the observed points, read by their sensors."""
    return {
        p.name: PointTracks(
            Track(instants, made.sensor(sensors, f"{p.name}.position")[:, :2]),
            Track(instants, made.sensor(sensors, f"{p.name}.velocity")[:, :2]),
            Track(instants, _acceleration(made, sensors, p.name)),
        )
        for p in made.form.mechanism.observed
    }


def _acceleration(made: Build, sensors: Array, name: str) -> Array:
    """Acceleration (T, 2) of a point or a body.

    The sensor is an accelerometer: a body at rest reads the reaction to its weight, so gravity is put back.
    """
    fall: Array = made.model.opt.gravity[:2]
    return made.sensor(sensors, f"{name}.acceleration")[:, :2] + fall


def body_states(
    made: Build, instants: Instants, states: Array, sensors: Array, after: Array | None = None
) -> BodyStates:
    """States of all links.

    Args:
        after: poses (3 n,) that these follow in a run reported in pieces; None at its beginning.
    """
    nq, nv = made.model.nq, made.model.nv
    poses, speeds = made.forward(states[:, 1 : 1 + nq], states[:, 1 + nq : 1 + nq + nv], after)
    read = [
        column
        for body in made.form.mechanism.bodies
        for column in (
            _acceleration(made, sensors, body.name),
            made.sensor(sensors, f"{body.name}.angular_acceleration")[:, 2:],
        )
    ]
    accelerations = made.form.completed([made.form.kept(poses), made.form.kept(speeds), np.hstack(read)])[2]
    return BodyStates(instants, poses, speeds, accelerations)


def unseen_points(machine: Machine, made: Build, bodies: BodyStates) -> dict[str, PointTracks]:
    """Observed points on links that the engine does not have, and so no sensor reads."""
    seen = {point.name for point in made.form.mechanism.observed}
    if len(seen) == len(made.form.whole.observed):
        return {}
    computed = machine.kinematics.point_derivatives([bodies.poses, bodies.rates, bodies.accelerations])
    return {
        name: PointTracks(*(Track(bodies.instants, values) for values in derivatives))
        for name, derivatives in computed.items()
        if name not in seen
    }
