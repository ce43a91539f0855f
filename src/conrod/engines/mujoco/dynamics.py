"""Dynamic mode: MuJoCo steps, conrod records. Nothing is written into the engine after the start."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
from mujoco import rollout

from conrod.engines.engine import Machine
from conrod.engines.mujoco.model import Build, build
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.motion import Array
from conrod.outcome import Verdict, judge
from conrod.trajectory import BodyStates, BodyTracks, Instants, Outcome, PointTracks, Track, Trajectory

STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


def run(machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float) -> Trajectory:
    """One run at constant crank speed, sampled at every step."""
    made = build(machine, settings)
    steps = round(settings.steps_per_revolution * revolutions)
    times, states, sensors = advance(made, machine, settings, steps, start_angle)
    instants = instants_of(made, times, states, sensors)
    points = point_tracks(made, instants, sensors)
    bodies = body_states(made, instants, states, sensors)
    points |= unseen_points(machine, made, bodies)
    tracks = BodyTracks(bodies, bodies, bodies)
    verdict = _ended_by_engine(states, settings)
    if verdict is None or verdict.outcome is not Outcome.RESET:
        seen = judge(machine.kinematics, tracks, machine.speed)
        verdict = seen if verdict is None or seen.outcome is not Outcome.COMPLETED else verdict
    return Trajectory(
        engine="mujoco",
        engine_version=mujoco.__version__,
        settings=settings,
        speed=machine.speed,
        revolutions=revolutions,
        outcome=verdict.outcome,
        reason=verdict.reason,
        points=points,
        bodies=tracks,
    )


def advance(
    made: Build, machine: Machine, settings: MuJoCoSettings, steps: int, start_angle: float
) -> tuple[Array, Array, Array]:
    """Nominal times (T,), full states (T, nstate) and sensor data (T, nsensordata), T = steps + 1."""
    model, data = made.model, mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(machine, start_angle)
    # After a step, sensor data belongs to the instant before it: one step more than needed gives the last sample its
    # sensors, and pairs sensors[k] with the state before step k.
    states = np.empty((1, steps + 2, mujoco.mj_stateSize(model, STATE)))
    sensors = np.empty((1, steps + 1, model.nsensordata))
    mujoco.mj_getState(model, data, states[0, 0], STATE)
    with warnings_kept_quiet():
        rollout.rollout(model, [data], states[:, 0], nstep=steps + 1, state=states[:, 1:], sensordata=sensors)
    # Time from the step index: a clock that sums its steps drifts.
    times = np.asarray(start_angle / machine.speed + settings.timestep * np.arange(steps + 1), dtype=float)
    return times, states[0, :-1], sensors[0]


@contextmanager
def warnings_kept_quiet() -> Iterator[None]:
    """MuJoCo writes a log file into the working folder at a warning; a run's outcome says more, and litters nothing."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def instants_of(made: Build, times: Array, states: Array, sensors: Array) -> Instants:
    """When samples were taken and where the crank was then."""
    nq, crank, mechanism = made.model.nq, made.crank_dof, made.form.whole
    turn = made.sensor(sensors, f"{mechanism.crank}.angular_acceleration")[:, 2]
    return Instants(times, states[:, 1 + crank], states[:, 1 + nq + crank], mechanism.driver.sense * turn)


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


def body_states(made: Build, instants: Instants, states: Array, sensors: Array) -> BodyStates:
    """States of all links."""
    nq, nv = made.model.nq, made.model.nv
    poses, speeds = made.forward(states[:, 1 : 1 + nq], states[:, 1 + nq : 1 + nq + nv])
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
    told = machine.kinematics.point_derivatives([bodies.poses, bodies.rates, bodies.accelerations])
    return {
        name: PointTracks(*(Track(bodies.instants, values) for values in derivatives))
        for name, derivatives in told.items()
        if name not in seen
    }


def _ended_by_engine(states: Array, settings: MuJoCoSettings) -> Verdict | None:
    """What MuJoCo did after a warning, told from its clock: its own reset starts it again, a stop lets it stand."""
    clock = states[:, 0]
    if not np.all(np.isfinite(clock)):
        return None
    expected = settings.timestep * np.arange(len(clock))
    off = np.abs(clock - expected) > 0.5 * settings.timestep
    if not off.any():
        return None
    first = int(np.argmax(off))
    if clock[first] < clock[first - 1]:
        return Verdict(Outcome.RESET, f"the engine reset its state at step {first}")
    return Verdict(Outcome.DIVERGED, f"the engine warned of bad numbers and stopped at step {first}")
