"""Runs of a user's model against the exact motion: how each ended, and how far it was off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.exact.reference import ExactReference
from conrod.own.models.frame import Frame
from conrod.own.models.request import DrivenRun, Scan
from conrod.runs.comparison import PointErrors, signed_error, track_errors
from conrod.runs.outcome import LOST_GAP, OPEN_GAP, OUT_OF_REACH, STALL, Verdict
from conrod.runs.trajectory import Instants, Outcome, PointTracks, Track

QUANTITIES = ("position", "velocity", "acceleration")


@dataclass(frozen=True)
class JudgedRun:
    """A run with its errors.

    Attributes:
        label: what it is called.
        errors: of each observed point, at the angle reached; None where it did not complete.
        phase: largest deviation of the crank angle from the nominal one [rad].
        ripple: largest deviation of the rate, relative to it.
        gap: largest violation of a closure beyond that of the start, in the model's units.
    """

    label: str
    outcome: Outcome
    reason: str
    armature: float
    steps_per_revolution: float
    errors: Mapping[str, PointErrors] | None
    phase: float
    ripple: float
    gap: float
    warnings: Mapping[str, int]

    def worst(self, quantity: str, measure: str = "max") -> float | None:
        """The largest error of a quantity over all points; None where the run did not complete."""
        if self.errors is None:
            return None
        return max(float(getattr(getattr(e, quantity).size, measure)) for e in self.errors.values())


@dataclass(frozen=True)
class Reference:
    """What runs are compared with.

    Attributes:
        ruler: of the machine that the model is.
        speed: nominal, of the crank angle [rad/s].
        size: of the mechanism [m].
        roller_radius: of a machine whose follower may leave its cam [m].
        others: other assembly branches.
    """

    ruler: ExactReference
    speed: float
    size: float
    roller_radius: float | None
    others: tuple[Kinematics, ...]


def tracks_of(run: DrivenRun, frame: Frame, points: tuple[str, ...]) -> dict[str, PointTracks]:
    """A run's points in the document's frame."""
    instants = Instants(run.times, frame.angle(run.coordinate), frame.sense * run.rate, frame.sense * run.acceleration)
    return {
        name: PointTracks(
            Track(instants, frame.placed(run.positions[name])),
            Track(instants, frame.turned(run.velocities[name])),
            Track(instants, frame.turned(run.accelerations[name])),
        )
        for name in points
    }


def judged(label: str, run: DrivenRun, frame: Frame, points: tuple[str, ...], scan: Scan, to: Reference) -> JudgedRun:
    """A run with its outcome and its errors."""
    tracks = tracks_of(run, frame, points)
    verdict = _ending(run, frame, tracks, scan, to)
    completed = verdict.outcome is Outcome.COMPLETED
    angle = frame.angle(run.coordinate)
    phase = np.abs(angle - angle[0] - to.speed * run.times).max() if len(angle) else np.nan
    return JudgedRun(
        label=label,
        outcome=verdict.outcome,
        reason=verdict.reason,
        armature=run.armature,
        steps_per_revolution=2.0 * np.pi / abs(to.speed) / run.timestep,
        errors=track_errors(tracks, to.speed, to.ruler) if completed else None,
        phase=float(phase),
        ripple=run.ripple,
        gap=float((run.gap - run.gap[0]).max()) if len(run.gap) else np.nan,
        warnings=run.warnings,
    )


def difference(
    one: DrivenRun, other: DrivenRun, frame: Frame, points: tuple[str, ...], to: Reference
) -> dict[str, float]:
    """Largest difference of two runs' errors, each at the angle that it reached; normalised like errors."""
    speed, largest = abs(to.speed), dict.fromkeys(QUANTITIES, 0.0)
    first, second = tracks_of(one, frame, points), tracks_of(other, frame, points)
    for name in points:
        for power, quantity in enumerate(QUANTITIES):
            gone = signed_error(getattr(first[name], quantity), to.ruler, name, quantity)
            gone = gone - signed_error(getattr(second[name], quantity), to.ruler, name, quantity)
            size = float(np.linalg.norm(gone, axis=1).max()) / (to.ruler.lengths[name] * speed**power)
            largest[quantity] = max(largest[quantity], size)
    return largest


def _ending(run: DrivenRun, frame: Frame, tracks: Mapping[str, PointTracks], scan: Scan, to: Reference) -> Verdict:
    """How a run ended, told from its crank, its points and the violation of its closures; the first that applies."""
    if run.outcome is not Outcome.COMPLETED:
        return Verdict(run.outcome, run.reason)
    off = _off(tracks, to.ruler)
    endings = [
        _exploded(run, tracks, to.size),
        Verdict(Outcome.STALLED, "the drive was off its speed by half") if run.ripple > STALL else None,
        _contact(off, tracks, frame, to) if scan.touching is not None else None,
        _opened(run, frame, max(to.ruler.lengths.values())),
        _flipped(off, tracks, to),
    ]
    return next((verdict for verdict in endings if verdict is not None), Verdict(Outcome.COMPLETED))


def _exploded(run: DrivenRun, tracks: Mapping[str, PointTracks], size: float) -> Verdict | None:
    places = np.array([t.position.values for t in tracks.values()])
    away = np.abs(places - places[:, :1]).max(axis=(0, 2)) / size
    if away.max() <= OUT_OF_REACH:
        return None
    time = run.times[int(np.argmax(away > OUT_OF_REACH))]
    return Verdict(Outcome.EXPLODED, f"beyond {OUT_OF_REACH:g} sizes of the mechanism from {time:.6g} s on")


def _opened(run: DrivenRun, frame: Frame, travel: float) -> Verdict | None:
    opened = frame.unit * float((run.gap - run.gap[0]).max())
    if opened <= OPEN_GAP * travel:
        return None
    return Verdict(Outcome.OPENED, f"a closure is open by up to {opened:.3g} m")


def _off(tracks: Mapping[str, PointTracks], ruler: ExactReference) -> Array:
    """Positions minus exact ones (P, T, 2) [m]."""
    return np.array([signed_error(t.position, ruler, name, "position") for name, t in tracks.items()])


def _contact(off: Array, tracks: Mapping[str, PointTracks], frame: Frame, to: Reference) -> Verdict | None:
    """Whether the follower is further from the crank's axis than the cam would have it, or nearer by a roller."""
    places = np.array([t.position.values for t in tracks.values()]) - np.array(frame.shaft)
    outward = (off * places).sum(axis=2) / np.linalg.norm(places, axis=2)
    if to.roller_radius is not None and outward.min() < -to.roller_radius:
        return Verdict(Outcome.TUNNELLED, f"the roller is {-outward.min():.3g} m deep in the cam")
    if outward.max() > LOST_GAP * max(to.ruler.lengths.values()):
        return Verdict(Outcome.LOST_CONTACT, f"the follower is up to {outward.max():.3g} m off the cam")
    return None


def _flipped(off: Array, tracks: Mapping[str, PointTracks], to: Reference) -> Verdict | None:
    """Whether the run is nearer to another branch where it is furthest from its own."""
    away = np.linalg.norm(off, axis=2)
    if away.max() <= OPEN_GAP * max(to.ruler.lengths.values()):
        return None
    row, worst = np.unravel_index(int(np.argmax(away)), away.shape)
    name = list(tracks)[int(row)]
    position = tracks[name].position
    for other in to.others:
        there = other.motion(position.instants.angle[worst : worst + 1], to.speed).point(name).position[0]
        if np.linalg.norm(position.values[worst] - there) < 0.5 * away[row, worst]:
            degrees = float(np.degrees(position.instants.angle[worst]))
            return Verdict(Outcome.FLIPPED, f"{name} is on the other assembly branch at {degrees:.1f} deg")
    return None
