"""The study of a user's model against a scene: its paths, its own run, and its runs along its exact motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact import ExactReference
from conrod.exact.motion import Array
from conrod.exact.space.laws import law_of
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.loops.driving import Recording, driven_run, recorded
from conrod.mjcf.loops.results import LABELS
from conrod.mjcf.loops.runs import with_settings
from conrod.mjcf.loops.turning import Turning, prepare, scan
from conrod.own.files import of_file
from conrod.own.models.frame import Frame, GivenFrame
from conrod.own.models.identity import identify
from conrod.own.models.loading import data_at_start
from conrod.own.models.references import other_branches
from conrod.own.models.request import Question
from conrod.own.models.results import AS_GIVEN, QUANTITIES, CrankMotion, JudgedRun, ModelStudy
from conrod.runs.comparison import ExactMotions, size_of, track_errors
from conrod.runs.outcome import LOST_GAP, OPEN_GAP, OUT_OF_REACH, Verdict
from conrod.runs.trajectory import Instants, Outcome, PointTracks, Track
from conrod.scenes import Scene
from conrod.studies.frame.resolve_arguments import MOST_SAMPLES
from conrod.studies.validation.results import RefinementPoint

FINER = (0.5, 2.0, 4.0)  # steps that take the place of one, where a model is refined
# A model whose points are further off than this, with all lengths fitted, is another machine: its runs say nothing.
COMPARABLE = 0.05


def study(
    path: Path,
    scene: tuple[str, Scene],
    question: Question,
    given: GivenFrame,
    revolutions: float,
    tolerance: Mapping[str, float] | None,
    refine: bool = False,
) -> ModelStudy:
    """Judge a model file; to be called in a process of its own, see `conrod.studies.execution.local`.

    Args:
        scene: its name and itself.
        refine: whether the runs that conrod drives are made at other steps, too.

    Raises:
        InvalidInput: the model cannot be used, its plane of motion or its frame cannot be determined, or its runs
            cannot be made.
    """
    with of_file(path):
        name, machine = scene
        turning = prepare(path, question)
        turn = scan(turning, question)
        facts, (identity, moving) = turn.facts, identify(machine, turn, given)
        misplaced = identity.explanations[0].misplaced if identity.explanations else ()
        wrong = {one.point for one in misplaced}
        # Compared are points that are where they should be on their links; all, where none is.
        points = tuple(point for point in turn.points if point not in wrong) or turn.points
        found = ModelStudy(str(path), name, machine, question, facts, identity, tolerance, revolutions, {}, {}, points)
        if identity.left > COMPARABLE:
            return found
        branches = other_branches(machine) if isinstance(moving, Scene) else (machine,)
        touching = facts.touching is not None
        to = RunReference(moving, machine.speed, branches, turning, identity.frame, points, touching)
        runs_of = _Runs(turning, to, question, revolutions)
        refused = {"hardened": "hardening does not apply to contact"} if question.contacts else {}
        at_steps = {label: [runs_of.driven(label)] for label in LABELS if label not in refused}
        for finer in FINER if refine else ():
            if finer * revolutions * machine.period <= MOST_SAMPLES * facts.timestep:
                for label, same in at_steps.items():
                    same.append(runs_of.driven(label, finer))
        own_run, crank = runs_of.as_given()
        refined = {label: _points(same) for label, same in at_steps.items() if len(same) > 1}
        runs = {label: same[0] for label, same in at_steps.items()}
        return replace(found, own_run=own_run, crank=crank, runs=runs, refused=refused, refined=refined)


class _Runs:
    """Runs of a model whose crank turns at a scene's speed, or that its own file drives.

    Raises:
        InvalidInput: the model's time step needs more samples than can be kept.
    """

    def __init__(self, turning: Turning, to: RunReference, question: Question, turns: float) -> None:
        self.turning, self.to, self.question, self.turns = turning, to, question, turns
        self.step = float(turning.model.opt.timestep)
        if (samples := len(self._times(self.step))) > MOST_SAMPLES:
            raise InvalidInput(
                f"its timestep of {self.step:g} s makes {samples} samples of {turns:g} turns: "
                f"at most {MOST_SAMPLES} are kept; fewer --revolutions"
            )
        elapsed, rate = float(np.remainder(to.frame.zero - turning.first, 2.0 * np.pi)), to.frame.sense * to.speed
        law = law_of(f"{rate!r}rad/s", "rad", turning.first + elapsed, turning.crank.name)
        self.machine = DrivenTree(turning.machine.tree, {turning.crank.name: law})
        coordinates, rates = turning.state(elapsed)
        self.start = coordinates[:, None], rate * np.array([rates, 0.0 * rates, 0.0 * rates])[:, :, None]

    def _times(self, step: float) -> Array:
        """The model's own timesteps need not divide a turn."""
        duration = self.turns * 2.0 * math.pi / abs(self.to.speed)
        return np.asarray(step * np.arange(max(2, math.ceil(duration / step - 1e-9)) + 1), dtype=float)

    def driven(self, label: str, finer: float = 1.0) -> JudgedRun:
        """With its own settings or a preset's, at so many steps in place of one."""
        step = self.step / finer
        model = with_settings(
            self.turning.model, label, step, 2.0 * math.pi / abs(self.to.speed), False, bool(self.question.contacts)
        )
        motion = SpatialMotion(self._times(step), *self.start, {})
        return judged(label, driven_run(self.machine, model, motion, self.turning.points, 1, False), self.to, step)

    def as_given(self) -> tuple[JudgedRun, CrankMotion | None]:
        """The run of the file: its own start, actuators and controls, autoreset as it is; nothing is prescribed."""
        model, turning = self.turning.model, self.turning
        data, _ = data_at_start(model, self.question.keyframe, self.question.controls)
        run, _ = recorded(turning.machine.tree, model, data, turning.points, self._times(self.step))
        found = judged(AS_GIVEN, run, self.to, self.step)
        return found, crank_motion(run, self.to, self.step) if found.outcome is Outcome.COMPLETED else None


def _points(runs: list[JudgedRun]) -> tuple[RefinementPoint, ...]:
    """Errors of runs of one kind, from coarse to fine."""
    ordered = sorted(runs, key=lambda run: run.steps_per_revolution)
    return tuple(
        RefinementPoint(round(run.steps_per_revolution), run.outcome.slug, *(run.worst(name) for name in QUANTITIES))
        for run in ordered
    )


# -- one run -----------------------------------------------------------------------------------------------------------


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
    turning: Turning
    frame: Frame
    points: tuple[str, ...]
    touching: bool


def tracks_of(run: Recording, to: RunReference) -> dict[str, PointTracks]:
    """A run's points in the document's frame."""
    frame, crank = to.frame, to.turning.crank
    rates, sense = (run.rates[crank.rate], run.accelerations[crank.rate]), frame.sense
    instants = Instants(run.times, frame.angle(run.coordinates[crank.coordinate]), *(sense * one for one in rates))
    placed = (frame.placed, frame.turned, frame.turned)
    return {
        name: PointTracks(*(Track(instants, seen(v)) for seen, v in zip(placed, run.points[name], strict=True)))
        for name in to.points
    }


def judged(label: str, run: Recording, to: RunReference, step: float) -> JudgedRun:
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
        steps_per_revolution=2.0 * np.pi / abs(to.speed) / step,
        errors=errors,
        phase=float(np.abs(at.angle - at.angle[0] - to.speed * at.times).max()) if len(at.times) else np.nan,
    )


def crank_motion(run: Recording, to: RunReference, step: float) -> CrankMotion:
    """Motion of the crank in the last turn's time of a run, or in all of it where that is less."""
    crank, period = to.turning.crank, 2.0 * np.pi / abs(to.speed)
    angle, rate = to.frame.angle(run.coordinates[crank.coordinate]), to.frame.sense * run.rates[crank.rate]
    last = run.times >= run.times[-1] - period * (1.0 + 1e-9)
    angle, rate = angle[last], rate[last]
    mean = float(angle[-1] - angle[0]) / max(step * (len(angle) - 1), 1e-300)
    return CrankMotion(mean, float(rate.min()), float(rate.max()))


def _endings(run: Recording, tracks: Mapping[str, PointTracks], to: RunReference) -> Iterator[Verdict]:
    """Outcomes that the crank, the points and the violation of the closures show; the first one counts."""
    travel = max(to.exact.lengths.values())
    places = np.array([t.position.values for t in tracks.values()])
    exact = ExactMotions(to.exact)
    off = np.array([exact.error(t.position, name, "position") for name, t in tracks.items()])
    away = np.abs(places - places[:, :1]).max(axis=(0, 2)) / to.exact.kinematics.size
    if away.max() > OUT_OF_REACH:
        time = run.times[int(np.argmax(away > OUT_OF_REACH))]
        yield Verdict(Outcome.EXPLODED, f"beyond {OUT_OF_REACH:g} sizes of the mechanism from {time:.6g} s on")
    if to.touching:
        # A follower further from the crank's axis than the cam would have it, or nearer by a roller.
        from_axis = places - np.array(to.frame.shaft)
        outward = (off * from_axis).sum(axis=2) / np.linalg.norm(from_axis, axis=2)
        contacts = to.exact.mechanism().cam_contacts
        if contacts and outward.min() < -contacts[0].roller_radius:
            yield Verdict(Outcome.TUNNELLED, f"the roller is {-outward.min():.3g} m deep in the cam")
        if outward.max() > LOST_GAP * travel:
            yield Verdict(Outcome.LOST_CONTACT, f"the follower is up to {outward.max():.3g} m off the cam")
    opened = to.frame.unit * max((float((gap - gap[0]).max()) for gap in run.gaps.values()), default=0.0)
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
