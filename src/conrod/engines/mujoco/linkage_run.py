"""A cam by its equivalent linkage in MuJoCo: one model for each arc, and the state carried from one to the next.

Position and velocity of cam and follower go over as the engine has them, the rod's follow from its pins; nothing else
is written. All steps of an arc have one length, so that its last one ends at the switch.

Which instants are told: positions and velocities at every step. At a switch the acceleration jumps, and is not told:
which side a sample stands for would be a matter of rounding.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.linkage_legs import ENDLESS, LEAST_STEPS, Leg, legs
from conrod.engines.mujoco.dynamics import body_states, instants_of, point_tracks, verdict_of
from conrod.engines.mujoco.model import Build, build
from conrod.engines.mujoco.recorder import Recorder, ended_by_engine
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.timing import BareRun
from conrod.exact.cache_blocks import chunks
from conrod.exact.equivalent_linkage import EquivalentLinkage, equivalent_linkage
from conrod.exact.motion import Array
from conrod.runs.outcome import Verdict
from conrod.runs.trajectory import BodyStates, BodyTracks, Outcome, Piece, PointTracks, Track, Trajectory, joined


def run(machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float) -> Trajectory:
    """One run at constant crank speed, sampled at every step."""
    steps = max(round(settings.steps_per_revolution * revolutions), 1)
    told = list(pieces(machine, settings, revolutions, start_angle, steps))
    whole = joined(told).trajectory
    assert whole.bodies is not None
    ended = next((t for t in (p.trajectory for p in told) if t.outcome is not Outcome.COMPLETED), None)
    verdict = verdict_of(machine, whole.bodies, None if ended is None else Verdict(ended.outcome, ended.reason))
    return replace(whole, outcome=verdict.outcome, reason=verdict.reason)


def pieces(
    machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float, length: int
) -> Iterator[Piece]:
    """The same run in pieces of at most so many steps, which end at every switch."""
    models = Models(machine, settings)
    poses, slopes = machine.kinematics.derivatives(np.array([start_angle]), 1)
    carried = poses[0], slopes[0] * machine.speed
    steps, told = round(settings.steps_per_revolution * revolutions), _Told()
    for leg in legs(models.linkage, machine, settings.steps_per_revolution, steps, start_angle):
        made, own = models.of(leg), replace(settings, timestep=leg.step)
        stretch = _Stretch(machine, leg, made, own, *leg.entered(*carried))
        # The last sample of a leg is the first one of the next.
        samples = range(leg.steps if leg.switches else leg.steps + 1)
        for part in chunks(len(samples), max(length, LEAST_STEPS)):
            yield stretch.told(settings, revolutions, told, samples[part])
        carried = leg.left(*stretch.left())
        told.clock += stretch.clock


class Models:
    """A model for each arc of a machine's cam and each length of a step, compiled when it is first asked for."""

    def __init__(self, machine: Machine, settings: MuJoCoSettings, sensors: bool = True) -> None:
        self.linkage: EquivalentLinkage = equivalent_linkage(machine.kinematics.mechanism)
        self._settings, self._sensors = settings, sensors
        self._built: dict[tuple[int, float], Build] = {}

    def of(self, leg: Leg) -> Build:
        """The model of a leg."""
        key = leg.index, leg.step
        if key not in self._built:
            self._built[key] = build(leg.machine, replace(self._settings, timestep=leg.step), sensors=self._sensors)
        return self._built[key]


@dataclass
class _Told:
    """What a run has told so far: samples, the clock at the start of the leg [s], how the engine ended it, warnings."""

    samples: int = 0
    clock: float = 0.0
    ended: Verdict | None = None


class _Stretch:
    """A leg as it is recorded."""

    def __init__(
        self, machine: Machine, leg: Leg, made: Build, settings: MuJoCoSettings, poses: Array, rates: Array
    ) -> None:
        self._machine, self._leg, self._made, self._settings = machine, leg, made, settings
        coordinates, speeds = made.coordinates(poses[None])[0], made.rates(poses[None], rates[None])[0]
        self._recorder = Recorder(made, settings, coordinates, speeds)
        self._clock = -settings.timestep  # of the sample before
        self._poses: Array | None = None

    def told(self, settings: MuJoCoSettings, revolutions: float, told: _Told, samples: range) -> Piece:
        """The next samples, which are these of the leg, as a piece of the whole run."""
        leg, made, recorder = self._leg, self._made, self._recorder
        states, sensors = recorder.next(len(samples))
        times = np.asarray((leg.begin - leg.offset) / leg.machine.speed + leg.step * np.array(samples), dtype=float)
        instants = instants_of(made, times, states, sensors)
        smooth = self._smooth(samples)
        # A state that is not finite any more stays so; how the run ended is told from it.
        with np.errstate(invalid="ignore", over="ignore"):
            own = body_states(made, instants, states, sensors, self._poses)
            bodies, points = self._of_machine(own, point_tracks(made, instants, sensors), smooth)
        told.ended = told.ended or ended_by_engine(
            states[:, 0], told.samples, self._clock, recorder.warnings, self._settings
        )
        verdict = verdict_of(self._machine, bodies, told.ended)
        trajectory = Trajectory(
            engine="mujoco",
            engine_version=mujoco.__version__,
            settings=settings,
            speed=self._machine.speed,
            revolutions=revolutions,
            outcome=verdict.outcome,
            reason=verdict.reason,
            points=points,
            bodies=bodies,
        )
        first, told.samples = told.samples, told.samples + len(samples)
        self._clock, self._poses = float(states[-1, 0]), own.poses[-1]
        # The drive turns the rods too, which the machine has not: its torque is another one (by 1.5 % of the peak).
        return Piece(trajectory, first, told.clock + states[:, 0], recorder.warnings, recorder.solver, None)

    def _smooth(self, samples: range) -> slice:
        """Of some samples, those at which the acceleration does not jump."""
        leg = self._leg
        return slice(
            int(samples.start == 0 and leg.from_switch),
            len(samples) - int(samples.stop > leg.steps and leg.to_switch),
        )

    def _of_machine(
        self, own: BodyStates, points: dict[str, PointTracks], smooth: slice
    ) -> tuple[BodyTracks, dict[str, PointTracks]]:
        """In the machine's own account; what was one object is one object."""
        states = self._leg.states(own, slice(None))
        accelerations = self._leg.states(own, smooth)
        tracks = {
            point.name: PointTracks(
                Track(states.instants, points[point.name].position.values),
                Track(states.instants, points[point.name].velocity.values),
                Track(accelerations.instants, points[point.name].acceleration.values[smooth]),
            )
            for point in self._leg.whole.observed
        }
        return BodyTracks(states, states, accelerations), tracks

    @property
    def clock(self) -> float:
        """The engine's clock now, from the beginning of the leg [s]."""
        return float(self._recorder.state[0])

    def left(self) -> tuple[Array, Array]:
        """Poses and rates (3 m,) of the linkage after the samples that were told."""
        state, nq, nv = self._recorder.state, self._made.model.nq, self._made.model.nv
        poses, rates = self._made.forward(state[None, 1 : 1 + nq], state[None, 1 + nq : 1 + nq + nv], self._poses)
        return poses[0], rates[0]


class LinkageRun:
    """The machine from the exact state of crank angle 0; calling it advances it by so many steps.

    Where a linkage takes over, a call of it hands the state on, which is part of what a run costs; the models are
    compiled before. One turn after the other, without end.
    """

    def __init__(self, machine: Machine, settings: MuJoCoSettings) -> None:
        self._models, turn = Models(machine, settings, sensors=False), settings.steps_per_revolution
        self._rounded = settings.rounded_state
        for leg in legs(self._models.linkage, machine, turn, 2 * turn, 0.0):
            self._models.of(leg)
        self._legs = legs(self._models.linkage, machine, turn, ENDLESS, 0.0)
        self._data: dict[tuple[int, float], mujoco.MjData] = {}
        poses, slopes = machine.kinematics.derivatives(np.zeros(1), 1)
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
        data = self._bare.data
        poses, rates = self._made.forward(data.qpos[None], data.qvel[None])
        return self._leg.left(poses[0], rates[0])

    def _enter(self, poses: Array, rates: Array) -> None:
        self._leg = next(self._legs)
        self._left, self._made = self._leg.steps, self._models.of(self._leg)
        own, speeds = self._leg.entered(poses, rates)
        key = self._leg.index, self._leg.step
        if key not in self._data:
            self._data[key] = mujoco.MjData(self._made.model)
        data = self._data[key]
        data.qpos[:] = self._made.coordinates(own[None])[0]
        data.qvel[:] = self._made.rates(own[None], speeds[None])[0]
        data.qacc_warmstart[:] = 0.0  # what the linkage ended with a turn before is no guess for its beginning
        self._bare = BareRun(self._made.model, data, self._rounded)
