"""Dynamic mode: MuJoCo steps, conrod records. Nothing is written into the engine after the start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Protocol

import mujoco
import numpy as np

from conrod.engines.engine import PIECE, Machine
from conrod.engines.mujoco.model import Build, build
from conrod.engines.mujoco.recorder import Recorder, ended_by_engine
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.recording import Recorded, pieces
from conrod.exact.motion import Array
from conrod.runs.outcome import Verdict
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, Outcome, Piece, PointTracks, Track


class Recording(Protocol):
    """A machine that is stepped and recorded, as `Recorder` does it."""

    @property
    def warnings(self) -> Mapping[str, int]: ...

    def next(self, samples: int) -> tuple[Array, Array]: ...


def run(
    machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    made = build(machine, settings)
    recorder = Recorder(made, *made.start_state(machine, start_angle), start_angle / machine.speed)
    return recorded(made, recorder, machine, settings, revolutions, start_angle, steps, mujoco.__version__)


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
    clock, end = -settings.timestep, None  # up to the sample before

    def record(first: int, times: Array) -> Recorded:
        nonlocal clock, end
        states, sensors = recorder.next(len(times))
        instants = instants_of(made, times, states, sensors)
        bodies = body_states(made, instants, states, sensors)
        points = point_tracks(made, instants, sensors)
        end = end or ended_by_engine(states[:, 0], first, clock, recorder.warnings, settings)
        clock = float(states[-1, 0])
        return Recorded(
            BodyTracks(bodies, bodies, bodies), points, states[:, 0], recorder.warnings,
            drive_torque(settings, instants), partial(verdict_of, ended=end),
        )  # fmt: skip

    return pieces(machine, settings, version, revolutions, start_angle, steps, record)


def advance(
    made: Build, machine: Machine, settings: MuJoCoSettings, steps: int, start_angle: float
) -> tuple[Array, Array, Array]:
    """Nominal times (T,), full states (T, nstate) and sensor data (T, nsensordata), T = steps + 1."""
    begin = start_angle / machine.speed
    states, sensors = Recorder(made, *made.start_state(machine, start_angle), begin).next(steps + 1)
    return begin + settings.timestep * np.arange(steps + 1, dtype=float), states, sensors


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
    angle, rate, mechanism = 1 + made.crank_coordinate, 1 + made.model.nq + made.crank_dof, made.tree.mechanism
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
        for p in made.tree.mechanism.observed
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
        for body in made.tree.mechanism.bodies
        for column in (
            _acceleration(made, sensors, body.name),
            made.sensor(sensors, f"{body.name}.angular_acceleration")[:, 2:],
        )
    ]
    return BodyStates(instants, poses, speeds, np.hstack(read))
