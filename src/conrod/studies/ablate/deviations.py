"""Deviations of a run from the exact motion, sample by sample: of the observed points and of the drive torque.

The deviations of two runs are subtracted, not the runs: where their samples lie at other instants, a deviation can be
interpolated at the cost of a small share of itself, and the motion cannot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.engines import engine_named
from conrod.engines.massless_rod import BODY
from conrod.engines.running import check_run
from conrod.exact.motion import Array
from conrod.runs.comparison import QUANTITIES as COMPARED
from conrod.runs.comparison import point_errors
from conrod.runs.outcome import Verdict, prevailing
from conrod.runs.trajectory import Outcome, Piece, Settings
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.limits.extremes import ExactTorque
from conrod.studies.limits.recorders import RunningSize
from conrod.studies.limits.stream_run import GONE


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
    """A run.

    Attributes:
        errors: point -> position, velocity, acceleration, total -> max, rms, final, as in a `Measurement`.
        motion: point -> position, velocity, acceleration -> by how much it is off at the nominal time.
        torque: by how much the drive torque is off that of the exact motion of the machine as it is described, over
            its peak, from the second sample on; None where the engine does not report it, and of a contact, whose
            force chatters.
        torque_error: the largest of it.
    """

    verdict: Verdict
    errors: Mapping[str, Mapping[str, Mapping[str, float]]]
    motion: Mapping[str, Mapping[str, Deviation]]
    torque: Deviation | None

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
    gathered, verdict = _Gathered(scene), Verdict(Outcome.COMPLETED)
    for piece in engine_named(settings.engine).run(scene, settings, revolutions, start_angle):
        verdict = prevailing(verdict, Verdict(piece.trajectory.outcome, piece.trajectory.reason))
        if verdict.outcome is Outcome.COMPLETED:
            gathered.add(piece)
        elif verdict.outcome in GONE:
            break
    return gathered.observed(verdict)


class _Gathered:
    """Deviations of a run that comes in pieces."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._sizes = {p: {q: RunningSize() for q in COMPARED} for p in scene.lengths}
        self._motion: dict[str, dict[str, list[Deviation]]] = {p: {q: [] for q in QUANTITIES} for p in scene.lengths}
        self._torque: list[Deviation] = []
        contact = bool(scene.kinematics.mechanism.cam_contacts)
        # Of the machine with its weight and all its links, whatever the settings leave out: that is what is asked for.
        self._exact = None if contact else ExactTorque(scene.kinematics, scene.speed, gravity=True, rod=BODY)

    def add(self, piece: Piece) -> None:
        """Take in a piece of a run that is in order so far."""
        scene, trajectory = self._scene, piece.trajectory
        for name, errors in point_errors(trajectory, scene).items():
            for quantity, size in self._sizes[name].items():
                size.add(getattr(errors, quantity).error)
        for name, tracks in trajectory.points.items():
            for k, quantity in enumerate(QUANTITIES):
                track = getattr(tracks, quantity)
                exact: Array = getattr(scene.reference(track.instants.times).point(name), quantity)
                off = (track.values - exact) / (scene.lengths[name] * abs(scene.speed) ** k)
                self._motion[name][quantity].append(Deviation(track.instants.times, off))
        if piece.drive_torque is not None and self._exact is not None:
            self._add_torque(piece, piece.drive_torque, self._exact)

    def _add_torque(self, piece: Piece, torque: Array, exact: ExactTorque) -> None:
        assert piece.trajectory.bodies is not None
        # At the very first sample an iterative solver has nothing to start from.
        rows = slice(int(piece.first_step == 0), None)
        at = piece.trajectory.bodies.acceleration.instants
        off = (torque[rows] - exact.at(at.angle[rows])) / exact.peak
        self._torque.append(Deviation(at.times[rows], off[:, None]))

    def observed(self, verdict: Verdict) -> Observed:
        """The whole of it; of a run that did not complete nothing but how it ended."""
        if verdict.outcome is not Outcome.COMPLETED:
            return Observed(verdict, {}, {}, None)
        return Observed(
            verdict,
            {p: {q: size.sizes() for q, size in sizes.items()} for p, sizes in self._sizes.items()},
            {p: {q: _concatenated(parts) for q, parts in found.items()} for p, found in self._motion.items()},
            _concatenated(self._torque) if self._torque else None,
        )


def _concatenated(parts: list[Deviation]) -> Deviation:
    return Deviation(np.concatenate([p.times for p in parts]), np.concatenate([p.values for p in parts]))
