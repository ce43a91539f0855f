"""Runs of a user's model against the exact motion: outcomes and errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.reference import ExactReference
from conrod.own.error_curve import ErrorCurve, error_curve
from conrod.own.models.frame import Frame
from conrod.own.models.request import DrivenRun
from conrod.runs.comparison import signed_error, track_errors
from conrod.runs.outcome import LOST_GAP, OPEN_GAP, OUT_OF_REACH, STALL, Verdict
from conrod.runs.trajectory import Instants, Outcome, PointTracks, Track

QUANTITIES = ("position", "velocity", "acceleration")


@dataclass(frozen=True)
class JudgedRun:
    """A run with its errors.

    Attributes:
        errors: by observed point and by quantity, over the crank angle [rad]; None where it did not complete.
        phase: largest deviation of the crank angle from the nominal one [rad].
        ripple: largest deviation of the rate, relative to it.
        gap: largest violation of a closure beyond that of the start, in the model's units.
    """

    label: str
    outcome: Outcome
    reason: str
    armature: float
    steps_per_revolution: float
    errors: Mapping[str, Mapping[str, ErrorCurve]] | None
    phase: float
    ripple: float
    gap: float
    warnings: Mapping[str, int]

    def worst(self, quantity: str, measure: str = "max") -> float | None:
        """The largest error of a quantity over all points; None where the run did not complete."""
        if self.errors is None:
            return None
        return max(float(getattr(curves[quantity].size, measure)) for curves in self.errors.values())


@dataclass(frozen=True)
class RunReference:
    """The machine that a model's runs are compared with, and the frame in which they are seen.

    Attributes:
        exact: the machine that the model is.
        speed: nominal, of the crank angle [rad/s].
        others: other assembly branches.
        touching: whether a contact of the model places its follower.
    """

    exact: ExactReference
    speed: float
    others: tuple[ExactReference, ...]
    frame: Frame
    points: tuple[str, ...]
    touching: bool

    @property
    def travel(self) -> float:
        """Largest length of a point [m]."""
        return max(self.exact.lengths.values())


def tracks_of(run: DrivenRun, to: RunReference) -> dict[str, PointTracks]:
    """A run's points in the document's frame."""
    frame = to.frame
    instants = Instants(run.times, frame.angle(run.coordinate), frame.sense * run.rate, frame.sense * run.acceleration)
    return {
        name: PointTracks(
            Track(instants, frame.placed(run.positions[name])),
            Track(instants, frame.turned(run.velocities[name])),
            Track(instants, frame.turned(run.accelerations[name])),
        )
        for name in to.points
    }


def judged(label: str, run: DrivenRun, to: RunReference) -> JudgedRun:
    """A run with its outcome and its errors."""
    tracks = tracks_of(run, to)
    verdict = _ending(run, tracks, to)
    completed = verdict.outcome is Outcome.COMPLETED
    angle = to.frame.angle(run.coordinate)
    phase = np.abs(angle - angle[0] - to.speed * run.times).max() if len(angle) else np.nan
    return JudgedRun(
        label=label,
        outcome=verdict.outcome,
        reason=verdict.reason,
        armature=run.armature,
        steps_per_revolution=2.0 * np.pi / abs(to.speed) / run.timestep,
        errors=_curves(tracks, to) if completed else None,
        phase=float(phase),
        ripple=run.ripple,
        gap=float((run.gap - run.gap[0]).max()) if len(run.gap) else np.nan,
        warnings=run.warnings,
    )


def _curves(tracks: Mapping[str, PointTracks], to: RunReference) -> dict[str, dict[str, ErrorCurve]]:
    return {
        name: {q: error_curve(getattr(errors, q).angle, getattr(errors, q).error) for q in (*QUANTITIES, "total")}
        for name, errors in track_errors(tracks, to.speed, to.exact).items()
    }


def difference(one: DrivenRun, other: DrivenRun, to: RunReference) -> dict[str, float]:
    """Largest difference of two runs' errors, each at the angle that it reached; normalised like errors."""
    first, second = tracks_of(one, to), tracks_of(other, to)
    largest = dict.fromkeys(QUANTITIES, 0.0)
    for name in to.points:
        for power, quantity in enumerate(QUANTITIES):
            errors = [signed_error(getattr(run[name], quantity), to.exact, name, quantity) for run in (first, second)]
            norm = to.exact.lengths[name] * abs(to.speed) ** power
            size = float(np.linalg.norm(errors[0] - errors[1], axis=1).max()) / norm
            largest[quantity] = max(largest[quantity], size)
    return largest


def _ending(run: DrivenRun, tracks: Mapping[str, PointTracks], to: RunReference) -> Verdict:
    """The outcome of a run, from its crank, its points and the violation of its closures; the first that applies."""
    if run.outcome is not Outcome.COMPLETED:
        return Verdict(run.outcome, run.reason)
    off = np.array([signed_error(t.position, to.exact, name, "position") for name, t in tracks.items()])
    endings = [
        _exploded(run, tracks, to),
        Verdict(Outcome.STALLED, "the drive was off its speed by half") if run.ripple > STALL else None,
        _contact(off, tracks, to) if to.touching else None,
        _opened(run, to),
        _flipped(off, tracks, to),
    ]
    return next((verdict for verdict in endings if verdict is not None), Verdict(Outcome.COMPLETED))


def _exploded(run: DrivenRun, tracks: Mapping[str, PointTracks], to: RunReference) -> Verdict | None:
    places = np.array([t.position.values for t in tracks.values()])
    away = np.abs(places - places[:, :1]).max(axis=(0, 2)) / to.exact.kinematics.size
    if away.max() <= OUT_OF_REACH:
        return None
    time = run.times[int(np.argmax(away > OUT_OF_REACH))]
    return Verdict(Outcome.EXPLODED, f"beyond {OUT_OF_REACH:g} sizes of the mechanism from {time:.6g} s on")


def _opened(run: DrivenRun, to: RunReference) -> Verdict | None:
    opened = to.frame.unit * float((run.gap - run.gap[0]).max())
    if opened <= OPEN_GAP * to.travel:
        return None
    return Verdict(Outcome.OPENED, f"a closure is open by up to {opened:.3g} m")


def _contact(off: Array, tracks: Mapping[str, PointTracks], to: RunReference) -> Verdict | None:
    """Verdict on a follower further from the crank's axis than the cam would have it, or nearer by a roller.

    Args:
        off: positions minus exact ones (P, T, 2) [m].
    """
    places = np.array([t.position.values for t in tracks.values()]) - np.array(to.frame.shaft)
    outward = (off * places).sum(axis=2) / np.linalg.norm(places, axis=2)
    contacts = to.exact.mechanism().cam_contacts
    if contacts and outward.min() < -contacts[0].roller_radius:
        return Verdict(Outcome.TUNNELLED, f"the roller is {-outward.min():.3g} m deep in the cam")
    if outward.max() > LOST_GAP * to.travel:
        return Verdict(Outcome.LOST_CONTACT, f"the follower is up to {outward.max():.3g} m off the cam")
    return None


def _flipped(off: Array, tracks: Mapping[str, PointTracks], to: RunReference) -> Verdict | None:
    """Verdict on a run nearer to another branch where it is furthest from its own; arguments as `_contact`."""
    away = np.linalg.norm(off, axis=2)
    if away.max() <= OPEN_GAP * to.travel:
        return None
    row, worst = np.unravel_index(int(np.argmax(away)), away.shape)
    name = list(tracks)[int(row)]
    position = tracks[name].position
    angle = position.instants.angle[worst : worst + 1]
    for other in to.others:
        there = other.motion(angle, to.speed).point(name).position[0]
        if np.linalg.norm(position.values[worst] - there) < 0.5 * away[row, worst]:
            return Verdict(
                Outcome.FLIPPED, f"{name} is on the other assembly branch at {float(np.degrees(angle[0])):.1f} deg"
            )
    return None
