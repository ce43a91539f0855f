"""Dynamic mode: step MuJoCo, and record states, sensors and warnings. Nothing is written after the start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache, partial
from typing import TYPE_CHECKING, Protocol

import numpy as np

from conrod.comparison.outcome import RunVerdict
from conrod.comparison.trajectory import BodyStates, BodyTracks, Outcome, Piece, PointTracks, Track
from conrod.engines.engine import PIECE_STEPS, DeferredLibrary, Machine
from conrod.engines.mujoco import MuJoCoSettings, compat
from conrod.engines.mujoco.model import MuJoCoModel, apply_load_laws, build
from conrod.engines.run import RecordedPiece, record_pieces
from conrod.exact.motion import Array, Instants, cache_blocks

if TYPE_CHECKING:
    import mujoco
else:
    mujoco = DeferredLibrary("mujoco")

BLOCK_SAMPLES = 4096  # looked at together, so that intermediate arrays stay in a core's cache
# Warnings at which MuJoCo resets the state, unless `autoreset` is off.
BAD_NUMBER_WARNINGS = ("BADQPOS", "BADQVEL", "BADQACC")


def detect_engine_stop(
    clock: Array, first: int, before: float, warnings: Mapping[str, int], settings: MuJoCoSettings
) -> RunVerdict | None:
    """Return the verdict if MuJoCo reset or stopped the run after a warning, else None.

    A reset sets the engine's clock back to 0; a stop leaves the clock standing.

    Args:
        clock: the engine's clock at consecutive samples (T,) [s].
        first: index in the run of the first of these samples.
        before: the engine's clock at the sample before them [s].
        warnings: number of the engine's warnings up to the last sample, by name.
    """
    if not np.all(np.isfinite(clock)):
        return None
    # The clock sums its steps, so over a long run it is off by many of them: each step is judged by itself.
    steps = np.diff(clock, prepend=before)
    off = np.abs(steps - settings.timestep) > 0.5 * settings.timestep
    if not off.any():
        return None
    at = int(np.argmax(off))
    if steps[at] < 0.0:
        return RunVerdict(Outcome.RESET, f"the engine reset its state at step {first + at}")
    if compat.resets_by_itself(settings) and any(name in warnings for name in BAD_NUMBER_WARNINGS):
        # In the first step there is nothing yet that a clock could fall back from.
        return RunVerdict(Outcome.RESET, f"the engine reset its state at step {first + at - 1}")
    return RunVerdict(Outcome.DIVERGED, f"the engine warned of bad numbers and stopped at step {first + at}")


@cache
def warning_kinds() -> dict[str, int]:
    """Numbers of the engine's warnings in MjData, by name."""
    kinds = {name.removeprefix("mjWARN_"): int(kind) for name, kind in mujoco.mjtWarning.__members__.items()}
    del kinds["mjNWARNING"]
    return kinds


def warning_counts(data: mujoco.MjData) -> dict[str, int]:
    """Number of the engine's warnings since the start, by name; only warnings that occurred."""
    counted = {name: int(data.warning[kind].number) for name, kind in warning_kinds().items()}
    return {name: number for name, number in counted.items() if number}


def bad_number_warnings(data: mujoco.MjData) -> list[str]:
    """Names of the warnings that have occurred after which a run's numbers are meaningless."""
    warnings, kinds = data.warning, warning_kinds()
    if not any(warnings.number.tolist()):  # after nearly all steps
        return []
    return [name for name in BAD_NUMBER_WARNINGS if warnings[kinds[name]].number]


class SampleSource(Protocol):
    """Steps a machine and returns its samples, as `MuJoCoRecorder` does."""

    @property
    def warnings(self) -> Mapping[str, int]:
        """Number of warnings of the engine so far, by name."""
        ...

    def next_samples(self, samples: int) -> tuple[Array, Array]:
        """The next T samples: states (T, nstate), from the present one on, and sensor data (T, nsensordata)."""
        ...


class MuJoCoRecorder:
    """Steps a machine from a state of its model and returns its samples, any number at a time.

    After the engine's first warning the state stays as it is, as in MuJoCo's own rollouts.

    Args:
        begin: the machine's time [s] at the start, where the engine's clock is 0.
        rounded: whether coordinates and rates are rounded to single precision after each step.
    """

    def __init__(
        self, made: MuJoCoModel, coordinates: Array, rates: Array, begin: float = 0.0, *, rounded: bool = False
    ) -> None:
        self._made, self._begin, self._rounded = made, begin, rounded
        self._model, self._data = made.model, mujoco.MjData(made.model)
        self._data.qpos[:], self._data.qvel[:] = coordinates, rates
        full = mujoco.mjtState.mjSTATE_FULLPHYSICS  # time, coordinates, rates
        self._state = np.empty(mujoco.mj_stateSize(self._model, full))  # from which the next step starts
        mujoco.mj_getState(self._model, self._data, self._state, full)

    @property
    def warnings(self) -> Mapping[str, int]:
        """Number of warnings since the start, by name."""
        return warning_counts(self._data)

    def next_samples(self, samples: int) -> tuple[Array, Array]:
        """The next T samples: states (T, nstate), from the present one on, and sensor data (T, nsensordata).

        Sensor data after a step belong to the instant before it. So a sample's sensors come from the step that follows,
        and the engine is one step ahead of the samples returned.
        """
        if self._rounded and samples > 1:
            steps = [self.next_samples(1) for _ in range(samples)]
            return np.vstack([states for states, _ in steps]), np.vstack([sensors for _, sensors in steps])
        states = np.empty((1, samples + 1, len(self._state)))
        sensors = np.empty((1, samples, self._model.nsensordata))
        states[0, 0] = self._state
        with silence_warnings(), apply_load_laws(self._model, self._made.tree, self._begin):
            if self.warnings:
                # Another rollout would clear the counters and go on.
                states[0, 1:], sensors[0] = states[0, 0], self._data.sensordata
            else:
                # The accelerations of the last step are the solver's first guess in the next: without them a run made
                # in pieces would not be the same to the last bit.
                guess = self._data.qacc_warmstart[None].copy()
                compat.roll_out(self._model, self._data, states[:, 0], guess, states[:, 1:], sensors)
        self._state = states[0, -1].copy()
        if self._rounded:
            with np.errstate(over="ignore"):  # too large a value becomes infinite, which the run's outcome reports
                self._state[1:] = self._state[1:].astype(np.float32)
        return states[0, :-1], sensors[0]


@contextmanager
def silence_warnings() -> Iterator[None]:
    """Keep MuJoCo from writing a log file into the working folder at a warning."""
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
    """Run a machine at constant crank speed, and yield its pieces of `steps` steps."""
    made = build(machine, settings)
    begin, rounded = start_angle / machine.speed, settings.rounded_state
    recorder = MuJoCoRecorder(made, *made.start_state(machine, start_angle), begin, rounded=rounded)
    return record_run(made, recorder, machine, settings, revolutions, start_angle, steps, mujoco.__version__)


def record_run(
    made: MuJoCoModel,
    recorder: SampleSource,
    machine: Machine,
    settings: MuJoCoSettings,
    revolutions: float,
    start_angle: float,
    steps: int,
    version: str,
) -> Iterator[Piece]:
    """Yield the pieces of a run whose samples come from a recorder at its start, MuJoCo's or MJX's."""
    clock, end, poses = -settings.timestep, None, None  # of the sample before

    def record(first: int, times: Array) -> RecordedPiece:
        """Read the next samples at times (T,) [s]; `first` is the index of the first."""
        nonlocal clock, end, poses
        states, sensors = recorder.next_samples(len(times))
        instants = sample_instants(made, times, states, sensors)
        bodies = body_states(made, instants, states, sensors, poses)
        poses = bodies.poses[-1]
        points = point_tracks(made, instants, sensors)
        end = end or detect_engine_stop(states[:, 0], first, clock, recorder.warnings, settings)
        if end is None and (body := made.find_tilted_body(states[:, 1 : 1 + made.model.nq])):
            end = RunVerdict(Outcome.OPENED, f"{body}: out of the plane of motion, in which its pins hold it")
        clock = float(states[-1, 0])
        return RecordedPiece(
            BodyTracks(bodies, bodies, bodies), points, states[:, 0], recorder.warnings,
            drive_torque(settings, instants), partial(combine_verdicts, ended=end),
        )  # fmt: skip

    return record_pieces(machine, settings, version, revolutions, start_angle, steps, record)


def simulate(
    made: MuJoCoModel, machine: Machine, settings: MuJoCoSettings, steps: int, start_angle: float
) -> tuple[Array, Array, Array]:
    """Simulate a run: times (T,), states (T, nstate) and sensor data (T, nsensordata), T = steps + 1."""
    begin = start_angle / machine.speed
    states, sensors = MuJoCoRecorder(made, *made.start_state(machine, start_angle), begin).next_samples(steps + 1)
    return begin + settings.timestep * np.arange(steps + 1, dtype=float), states, sensors


def combine_verdicts(judged: RunVerdict, ended: RunVerdict | None) -> RunVerdict:
    """Return the verdict on the motion, unless the engine's own verdict outranks it.

    A reset outranks every verdict on the motion; a stop only `completed`.
    """
    if ended is None or (judged.outcome is not Outcome.COMPLETED and ended.outcome is not Outcome.RESET):
        return judged
    return ended


def drive_torque(settings: MuJoCoSettings, instants: Instants) -> Array | None:
    """Torque of the drive on the machine (T,) [N m], in the sense of the crank angle; None without a drive.

    The drive is a flywheel, so the torque is -armature x crank acceleration.
    """
    return -settings.armature * instants.acceleration if settings.armature > 0.0 else None


def sample_instants(made: MuJoCoModel, times: Array, states: Array, sensors: Array) -> Instants:
    """Times (T,) [s] of the samples, with the crank angle, rate and acceleration that the engine reached."""
    angle, rate, mechanism = 1 + made.crank_coordinate, 1 + made.model.nq + made.crank_dof, made.tree.mechanism
    turn = made.sensor_values(sensors, f"{mechanism.crank}.angular_acceleration")[:, 2]
    return Instants(times, states[:, angle], states[:, rate], mechanism.driver.sense * turn)


def point_tracks(made: MuJoCoModel, instants: Instants, sensors: Array) -> dict[str, PointTracks]:
    """Motion of the observed points, from their sensors."""
    return {
        p.name: PointTracks(
            Track(instants, made.sensor_values(sensors, f"{p.name}.position")[:, :2]),
            Track(instants, made.sensor_values(sensors, f"{p.name}.velocity")[:, :2]),
            Track(instants, _acceleration(made, sensors, p.name)),
        )
        for p in made.tree.mechanism.observed
    }


def _acceleration(made: MuJoCoModel, sensors: Array, name: str) -> Array:
    """Acceleration (T, 2) of a point or a body, from its sensor.

    The sensor is an accelerometer: a body at rest reads the reaction to its weight, so gravity is put back.
    """
    fall: Array = made.model.opt.gravity[:2]
    return made.sensor_values(sensors, f"{name}.acceleration")[:, :2] + fall


def body_states(
    made: MuJoCoModel, instants: Instants, states: Array, sensors: Array, before: Array | None = None
) -> BodyStates:
    """Poses, rates and accelerations (T, 3 n) of all bodies.

    Args:
        before: poses (3 n,) of the sample before; those of crank angle 0 by default.
    """
    nq, nv, bodies = made.model.nq, made.model.nv, made.tree.mechanism.bodies
    poses, speeds, accelerations = (np.empty((len(states), 3 * len(bodies))) for _ in range(3))
    read = [
        made.sensor_column(f"{body.name}.{name}", axis)
        for body in bodies
        for name, axis in (("acceleration", 0), ("acceleration", 1), ("angular_acceleration", 2))
    ]
    fall = np.tile([*made.model.opt.gravity[:2], 0.0], len(bodies))  # put back, as in `_acceleration`
    for rows in cache_blocks(len(states), BLOCK_SAMPLES):
        coordinates, rates = states[rows, 1 : 1 + nq], states[rows, 1 + nq : 1 + nq + nv]
        poses[rows], speeds[rows] = made.forward_kinematics(coordinates, rates, before)
        before = poses[rows][-1]
        accelerations[rows] = sensors[rows][:, read] + fall
    return BodyStates(instants, poses, speeds, accelerations)
