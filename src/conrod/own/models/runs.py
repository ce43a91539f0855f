"""Runs of a user's model against the exact motion: outcomes and errors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.reference import ExactReference
from conrod.own.models.frame import Frame
from conrod.own.models.request import DrivenRun
from conrod.runs.comparison import ExactMotions, Size, size_of, track_errors
from conrod.runs.outcome import LOST_GAP, OPEN_GAP, OUT_OF_REACH, STALL, Verdict
from conrod.runs.trajectory import Instants, Outcome, PointTracks, Track

QUANTITIES = ("position", "velocity", "acceleration")
# A mean speed that is off by more than a per cent is another speed; `conrod lint` drives no worse. The roughest drives
# that handbooks allow, those of crushers, swing by a fifth of their speed from the slowest to the fastest.
STRAYED, UNEVEN = 0.01, 0.1


@dataclass(frozen=True)
class JudgedRun:
    """A run with its errors.

    Attributes:
        errors: by observed point and by quantity; None where it did not complete.
        phase: largest deviation of the crank angle from the nominal one [rad].
    """

    label: str
    outcome: Outcome
    reason: str
    steps_per_revolution: float
    errors: Mapping[str, Mapping[str, Size]] | None
    phase: float

    def worst(self, quantity: str, measure: str = "max") -> float | None:
        """The largest error of a quantity over all points; None where the run did not complete."""
        if self.errors is None:
            return None
        return float(np.max([getattr(sizes[quantity], measure) for sizes in self.errors.values()]))

    def judged_error(self, name: str) -> float:
        """The error that a tolerance of this name is compared with; not a number where the run did not complete."""
        quantity, _, measure = name.partition("_")
        found = self.phase if quantity == "phase" else self.worst(quantity, measure or "max")
        return math.nan if found is None else found


@dataclass(frozen=True)
class CrankMotion:
    """Motion of a crank in the last turn's time of a run, at the scene's speed.

    Attributes:
        mean, least, most: of its speed [rad/s].
    """

    mean: float
    least: float
    most: float

    def strays(self, speed: float) -> bool:
        """True if its mean speed is not the commanded one [rad/s], or it was off that by a tenth at any time."""
        mean, *ends = (abs(own / speed - 1.0) for own in (self.mean, self.least, self.most))
        return mean > STRAYED or max(ends) > UNEVEN


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


def tracks_of(run: DrivenRun, to: RunReference) -> dict[str, PointTracks]:
    """A run's points in the document's frame."""
    frame = to.frame
    instants = Instants(run.times, frame.angle(run.coordinate), frame.sense * run.rate, frame.sense * run.acceleration)
    placed = (frame.placed, frame.turned, frame.turned)
    return {
        name: PointTracks(*(Track(instants, seen(v)) for seen, v in zip(placed, run.motion[name], strict=True)))
        for name in to.points
    }


def judged(label: str, run: DrivenRun, to: RunReference) -> JudgedRun:
    """A run with its outcome and its errors."""
    tracks, verdict = tracks_of(run, to), Verdict(run.outcome, run.reason)
    if run.outcome is Outcome.COMPLETED:
        verdict = next(_endings(run, tracks, to), verdict)
    errors = None
    if verdict.outcome is Outcome.COMPLETED:
        errors = {
            name: {quantity: size_of(series.error) for quantity, series in vars(found).items()}
            for name, found in track_errors(tracks, to.speed, ExactMotions(to.exact)).items()
        }
    at = next(iter(tracks.values())).position.instants
    return JudgedRun(
        label=label,
        outcome=verdict.outcome,
        reason=verdict.reason,
        steps_per_revolution=2.0 * np.pi / abs(to.speed) / run.timestep,
        errors=errors,
        phase=float(np.abs(at.angle - at.angle[0] - to.speed * at.times).max()) if len(at.times) else np.nan,
    )


def crank_motion(run: DrivenRun, to: RunReference) -> CrankMotion:
    """Motion of the crank in the last turn's time of a run, or in all of it where that is less."""
    angle, rate, period = to.frame.angle(run.coordinate), to.frame.sense * run.rate, 2.0 * np.pi / abs(to.speed)
    last = run.times >= run.times[-1] - period * (1.0 + 1e-9)
    angle, rate = angle[last], rate[last]
    mean = float(angle[-1] - angle[0]) / max(run.timestep * (len(angle) - 1), 1e-300)
    return CrankMotion(mean, float(rate.min()), float(rate.max()))


def _endings(run: DrivenRun, tracks: Mapping[str, PointTracks], to: RunReference) -> Iterator[Verdict]:
    """Outcomes that the crank, the points and the violation of the closures show; the first one counts."""
    travel = max(to.exact.lengths.values())
    places = np.array([t.position.values for t in tracks.values()])
    exact = ExactMotions(to.exact)
    off = np.array([exact.error(t.position, name, "position") for name, t in tracks.items()])
    away = np.abs(places - places[:, :1]).max(axis=(0, 2)) / to.exact.kinematics.size
    if away.max() > OUT_OF_REACH:
        time = run.times[int(np.argmax(away > OUT_OF_REACH))]
        yield Verdict(Outcome.EXPLODED, f"beyond {OUT_OF_REACH:g} sizes of the mechanism from {time:.6g} s on")
    if run.ripple > STALL:
        yield Verdict(Outcome.STALLED, "the drive was off its speed by half")
    if to.touching:
        # A follower further from the crank's axis than the cam would have it, or nearer by a roller.
        from_axis = places - np.array(to.frame.shaft)
        outward = (off * from_axis).sum(axis=2) / np.linalg.norm(from_axis, axis=2)
        contacts = to.exact.mechanism().cam_contacts
        if contacts and outward.min() < -contacts[0].roller_radius:
            yield Verdict(Outcome.TUNNELLED, f"the roller is {-outward.min():.3g} m deep in the cam")
        if outward.max() > LOST_GAP * travel:
            yield Verdict(Outcome.LOST_CONTACT, f"the follower is up to {outward.max():.3g} m off the cam")
    opened = to.frame.unit * float((run.gap - run.gap[0]).max())
    if opened > OPEN_GAP * travel:
        yield Verdict(Outcome.OPENED, f"a closure is open by up to {opened:.3g} m")
    yield from _flipped(np.linalg.norm(off, axis=2), OPEN_GAP * travel, tracks, to)


def _flipped(away: Array, near: float, tracks: Mapping[str, PointTracks], to: RunReference) -> Iterator[Verdict]:
    """A verdict on a run that is nearer to another branch where it is furthest from its own.

    Args:
        away: distances from the exact places (P, T) [m]; `near` is none.
    """
    row, worst = np.unravel_index(int(np.argmax(away)), away.shape)
    name = list(tracks)[int(row)]
    position = tracks[name].position
    angle = position.instants.angle[worst : worst + 1]
    for other in to.others if away.max() > near else ():
        there = other.motion(angle, to.speed).point(name).position[0]
        if np.linalg.norm(position.values[worst] - there) < 0.5 * away[row, worst]:
            where = f"at {float(np.degrees(angle[0])):.1f} deg"
            yield Verdict(Outcome.FLIPPED, f"{name} is on the other assembly branch {where}")
