"""Cases of a study of ingredients: how much a variant's motion differs from another one's, and its cost over it.

The deviations of two runs from the exact motion are subtracted, not the runs: where their samples lie at other
instants, a deviation can be interpolated at the cost of a small share of itself, and the motion cannot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from conrod.engines import engine_named
from conrod.engines.capabilities import HasIngredients, required
from conrod.engines.massless_rod import BODY
from conrod.engines.running import check_run
from conrod.exact.motion import Array
from conrod.runs.comparison import Stretch
from conrod.runs.outcome import Verdict
from conrod.runs.plain import plain, restore
from conrod.runs.run_errors import PointSizes
from conrod.runs.trajectory import Outcome, Piece, Settings, Track, concatenate_pieces
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.paired_timing import ROUNDS, PairedTiming, time_pair
from conrod.studies.frame.run import RunCase, as_run, not_run
from conrod.studies.limits.recorders import ExactTorque
from conrod.studies.limits.stream_run import GONE

# Raised when what is kept of the same run comes out otherwise, or means something else, than before.
CHANGE_VERSION, COST_VERSION = 1, 1
COUNTED = 36  # crank angles of a turn at which a compiled model's constraints are counted


@dataclass(frozen=True)
class PairCase(RunCase):
    """A run that is compared with another one.

    Attributes:
        against: settings of the other one.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        against = {key: value for key, value in self.against.as_dict().items() if key != "preset"}
        return super()._identity(parameters) | {"against": against}


@dataclass(frozen=True)
class ChangeCase(PairCase):
    """A run, measured by how much it differs from another one."""

    def perform(self) -> Measurement:
        return measure_change(self)

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"change": CHANGE_VERSION}


@dataclass(frozen=True)
class CostCase(PairCase):
    """The cost of a revolution over that with other settings; see `conrod.studies.frame.paired_timing`.

    Attributes:
        machine: fingerprint of the machine that it is timed on: figures of different machines do not mix.
        rounds: how often both are timed.
    """

    machine: str = field(kw_only=True)
    rounds: int = field(kw_only=True, default=ROUNDS)

    def perform(self) -> Measurement:
        timing = time_pair(
            engine_named(self.settings.engine), self.scene, self.settings, self.against, rounds=self.rounds
        )
        return Measurement(Outcome.COMPLETED.slug, beside={"paired": plain(timing)})

    def _read(self, measurement: Measurement) -> None:
        if measurement.beside is not None:
            restore(PairedTiming, measurement.beside["paired"])

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        paired = {"cost": COST_VERSION, "machine": self.machine, "rounds": self.rounds}
        return super()._identity(parameters) | paired


def measure_change(case: ChangeCase) -> Measurement:
    """The motion of a case, by how much it differs from that of what it is compared with, and its constraints.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine, scene, case = engine_named(case.settings.engine), case.scene, as_run(case)
    if (unsupported := not_run(case, scene)) is not None:
        return unsupported
    turn = scene.kinematics.angles(COUNTED)
    count = required(engine, HasIngredients).mobility(scene, case.settings, turn)
    beside: dict[str, Any] = {"mobility": asdict(count)}
    settings: Any = case.settings  # settings of all engines are hashable, which their protocol cannot say
    against: Any = case.against
    run = _observed(scene, settings, case.revolutions, case.start_angle)
    if not run.completed:
        return Measurement(run.verdict.outcome.slug, run.verdict.reason, beside=beside)
    # A pass takes whole steps, whose length is that of the other settings.
    other_case = as_run(replace(case, settings=against))
    other = _observed(scene, against, other_case.revolutions, other_case.start_angle)
    beside |= {"torque": run.torque_error, **_changes(run, other)}
    return Measurement(run.verdict.outcome.slug, errors=run.errors, beside=beside)


def _changes(run: Observed, other: Observed) -> dict[str, Any]:
    """Largest differences of the observed points, and of the drive torque; None where there is nothing to compare."""
    if not other.completed:
        return {"change": None, "torque_change": None}
    return {
        "change": {
            quantity: max(run.motion[point][quantity].difference(other.motion[point][quantity]) for point in run.motion)
            for quantity in QUANTITIES
        },
        "torque_change": run.torque.difference(other.torque) if run.torque and other.torque else None,
    }


# -- deviations of a run from the exact motion -------------------------------------------------------------------------


@dataclass(frozen=True)
class Deviation:
    """Measured minus exact at the nominal times (T,) [s]; (T, k), normalised."""

    times: Array
    values: Array

    def difference(self, other: Deviation) -> float:
        """Largest Euclidean norm of the difference, at the instants of the one that has fewer."""
        few, many = sorted((self, other), key=lambda one: len(one.times))
        inside = (few.times >= many.times[0]) & (few.times <= many.times[-1])
        at = few.times[inside]
        columns = zip(few.values[inside].T, many.values.T, strict=True)
        off = [one - np.interp(at, many.times, two) for one, two in columns]
        return float(np.linalg.norm(off, axis=0).max())


@dataclass(frozen=True)
class Observed:
    """A run; of one that did not complete nothing but how it ended.

    Attributes:
        errors: point -> position, velocity, acceleration, total -> max, rms, final, as in a `Measurement`.
        motion: point -> position, velocity, acceleration -> by how much it is off at the nominal time.
        torque: by how much the drive torque is off that of the exact motion of the machine as it is described, over
            its peak, from the second sample on; None where the engine does not report it, and of a contact, whose
            force chatters.
    """

    verdict: Verdict
    errors: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)
    motion: Mapping[str, Mapping[str, Deviation]] = field(default_factory=dict)
    torque: Deviation | None = None

    @property
    def completed(self) -> bool:
        """True if there is anything to compare."""
        return self.verdict.outcome is Outcome.COMPLETED

    @property
    def torque_error(self) -> float | None:
        """Largest error of the drive torque over the exact peak."""
        return None if self.torque is None else float(np.abs(self.torque.values).max())


def observe(scene: Scene, settings: Settings, revolutions: float, start_angle: float = 0.0) -> Observed:
    """Run a scene from a crank angle [rad].

    Raises:
        InvalidInput: as `conrod.run`.
    """
    check_run(scene, settings, revolutions, start_angle)
    pieces, verdict = list[Piece](), Verdict(Outcome.COMPLETED)
    for piece in engine_named(settings.engine).run(scene, settings, revolutions, start_angle):
        verdict = Verdict(piece.trajectory.outcome, piece.trajectory.reason)
        if verdict.outcome in GONE:
            break
        pieces.append(piece)
    if verdict.outcome is not Outcome.COMPLETED:
        return Observed(verdict)
    whole = concatenate_pieces(pieces)
    errors = PointSizes()
    errors.add(Stretch(whole.trajectory, scene))
    motion = {
        point: {q: _deviation(scene, point, getattr(tracks, q), q, k) for k, q in enumerate(QUANTITIES)}
        for point, tracks in whole.trajectory.points.items()
    }
    return Observed(verdict, errors.errors, motion, _torque_deviation(scene, whole))


# Of the models that others are compared with there are two, and a process meets many of those others.
_observed = lru_cache(3)(observe)


def _deviation(scene: Scene, point: str, track: Track, quantity: str, k: int) -> Deviation:
    times = track.instants.times
    exact: Array = getattr(scene.reference(times).point(point), quantity)
    return Deviation(times, (track.values - exact) / (scene.lengths[point] * abs(scene.speed) ** k))


def _torque_deviation(scene: Scene, run: Piece) -> Deviation | None:
    if run.drive_torque is None or run.trajectory.bodies is None or scene.kinematics.mechanism.cam_contacts:
        return None
    # Of the machine with its weight and all its links, whatever the settings leave out: that is what is asked for.
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True, rod=BODY)
    at = run.trajectory.bodies.acceleration.instants
    off = (run.drive_torque - exact.at(at.angle)) / exact.peak
    # At the very first sample an iterative solver has nothing to start from.
    return Deviation(at.times[1:], off[1:, None])
