"""Dynamic mode: MuJoCo steps, its states are kept, with its warnings. Nothing is written into it after the start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Protocol

import mujoco
import numpy as np

from conrod.engines.engine import PIECE_STEPS, Machine
from conrod.engines.mujoco import MuJoCoSettings, older
from conrod.engines.mujoco.model import Build, build, laws_acting
from conrod.engines.run import RecordedStretch, record_pieces
from conrod.exact.motion import Array
from conrod.runs.outcome import RunVerdict
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, Outcome, Piece, PointTracks, Track

# What MuJoCo warns of where it resets the state, if it may.
BAD_NUMBERS = ("BADQPOS", "BADQVEL", "BADQACC")


def ended_by_engine(
    clock: Array, first: int, before: float, warnings: Mapping[str, int], settings: MuJoCoSettings
) -> RunVerdict | None:
    """The end that MuJoCo made after a warning, by its clock: its own reset starts it again, a stop lets it stand.

    Args:
        clock: of the engine at consecutive samples (T,) [s].
        first: index in the run of the first of them.
        before: the clock at the sample before that.
        warnings: of the engine, by name, up to the last sample.
    """
    if not np.all(np.isfinite(clock)):
        return None
    # The clock sums its steps, so over a long run it is off by many of them: each is judged by itself.
    steps = np.diff(clock, prepend=before)
    off = np.abs(steps - settings.timestep) > 0.5 * settings.timestep
    if not off.any():
        return None
    at = int(np.argmax(off))
    if steps[at] < 0.0:
        return RunVerdict(Outcome.RESET, f"the engine reset its state at step {first + at}")
    if older.resets_by_itself(settings) and any(name in warnings for name in BAD_NUMBERS):
        # In the first step there is nothing yet that a clock could fall back from.
        return RunVerdict(Outcome.RESET, f"the engine reset its state at step {first + at - 1}")
    return RunVerdict(Outcome.DIVERGED, f"the engine warned of bad numbers and stopped at step {first + at}")


STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS  # time, coordinates, rates
WARNINGS = {name.removeprefix("mjWARN_"): int(kind) for name, kind in mujoco.mjtWarning.__members__.items()}
del WARNINGS["mjNWARNING"]


def warnings_of(data: mujoco.MjData) -> dict[str, int]:
    """Warnings of the engine, by name, and how often each came."""
    counted = {name: int(data.warning[kind].number) for name, kind in WARNINGS.items()}
    return {name: number for name, number in counted.items() if number}


def bad_numbers(data: mujoco.MjData) -> list[str]:
    """Warnings after which the numbers of a run mean nothing, that there were."""
    return [name for name in BAD_NUMBERS if data.warning[WARNINGS[name]].number]


class Recording(Protocol):
    """A machine that is stepped and recorded, as `Recorder` does it."""

    @property
    def warnings(self) -> Mapping[str, int]: ...

    def next(self, samples: int) -> tuple[Array, Array]: ...


class Recorder:
    """A machine that is stepped from a state of its model, by as many samples at a time as one likes.

    At the engine's first warning it stands still, as MuJoCo's own rollouts do.

    Args:
        begin: the time [s] of the start, at which the engine's clock is 0.
        rounded: coordinates and rates go to single precision after each step.
    """

    def __init__(
        self, made: Build, coordinates: Array, rates: Array, begin: float = 0.0, *, rounded: bool = False
    ) -> None:
        self._made, self._begin, self._rounded = made, begin, rounded
        self._model, self._data = made.model, mujoco.MjData(made.model)
        self._data.qpos[:], self._data.qvel[:] = coordinates, rates
        self._state = np.empty(mujoco.mj_stateSize(self._model, STATE))  # that the next step starts from
        mujoco.mj_getState(self._model, self._data, self._state, STATE)

    @property
    def warnings(self) -> Mapping[str, int]:
        """Warnings of the engine since the start, and how often each came."""
        return warnings_of(self._data)

    def next(self, samples: int) -> tuple[Array, Array]:
        """The next T samples, at least one: states (T, nstate), the first of which is that of now, sensor data (T, ..).

        After a step, sensor data belongs to the instant before it: the step that leaves a sample gives its sensors, so
        that the engine is one step ahead of the reported samples.
        """
        if self._rounded and samples > 1:
            steps = [self.next(1) for _ in range(samples)]
            return np.vstack([states for states, _ in steps]), np.vstack([sensors for _, sensors in steps])
        states = np.empty((1, samples + 1, len(self._state)))
        sensors = np.empty((1, samples, self._model.nsensordata))
        states[0, 0] = self._state
        with warnings_kept_quiet(), laws_acting(self._model, self._made.tree, self._begin):
            if self.warnings:
                # Another rollout would clear the counters and go on.
                states[0, 1:], sensors[0] = states[0, 0], self._data.sensordata
            else:
                # The accelerations of the last step are the solver's first guess in the next: without them a run made
                # in pieces would not be the same to the last bit.
                guess = self._data.qacc_warmstart[None].copy()
                older.roll_out(self._model, self._data, states[:, 0], guess, states[:, 1:], sensors)
        self._state = states[0, -1].copy()
        if self._rounded:
            with np.errstate(over="ignore"):  # what is too large becomes infinite, which the run's outcome tells
                self._state[1:] = self._state[1:].astype(np.float32)
        return states[0, :-1], sensors[0]


@contextmanager
def warnings_kept_quiet() -> Iterator[None]:
    """MuJoCo writes a log file into the working folder at a warning; a run's outcome says more, and litters nothing."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


# -- runs at constant speed --------------------------------------------------------------------------------------------


def run(
    machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    made = build(machine, settings)
    begin, rounded = start_angle / machine.speed, settings.rounded_state
    recorder = Recorder(made, *made.start_state(machine, start_angle), begin, rounded=rounded)
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

    def record(first: int, times: Array) -> RecordedStretch:
        nonlocal clock, end
        states, sensors = recorder.next(len(times))
        instants = instants_of(made, times, states, sensors)
        bodies = body_states(made, instants, states, sensors)
        points = point_tracks(made, instants, sensors)
        end = end or ended_by_engine(states[:, 0], first, clock, recorder.warnings, settings)
        clock = float(states[-1, 0])
        return RecordedStretch(
            BodyTracks(bodies, bodies, bodies), points, states[:, 0], recorder.warnings,
            drive_torque(settings, instants), partial(verdict_of, ended=end),
        )  # fmt: skip

    return record_pieces(machine, settings, version, revolutions, start_angle, steps, record)


def advance(
    made: Build, machine: Machine, settings: MuJoCoSettings, steps: int, start_angle: float
) -> tuple[Array, Array, Array]:
    """Nominal times (T,), full states (T, nstate) and sensor data (T, nsensordata), T = steps + 1."""
    begin = start_angle / machine.speed
    states, sensors = Recorder(made, *made.start_state(machine, start_angle), begin).next(steps + 1)
    return begin + settings.timestep * np.arange(steps + 1, dtype=float), states, sensors


def verdict_of(judged: RunVerdict, ended: RunVerdict | None) -> RunVerdict:
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
    poses, speeds = made.forward_kinematics(states[:, 1 : 1 + nq], states[:, 1 + nq : 1 + nq + nv])
    read = [
        column
        for body in made.tree.mechanism.bodies
        for column in (
            _acceleration(made, sensors, body.name),
            made.sensor(sensors, f"{body.name}.angular_acceleration")[:, 2:],
        )
    ]
    return BodyStates(instants, poses, speeds, np.hstack(read))
