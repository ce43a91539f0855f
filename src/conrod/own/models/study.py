"""The study of a user's model: its paths, its own run, and its runs with conrod's drive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from conrod.engines import engine_named
from conrod.exact import ExactReference
from conrod.exact.motion import Array
from conrod.own.files import of_file
from conrod.own.models.assembly import prepare
from conrod.own.models.driving import CrankDrive, changed
from conrod.own.models.frame import Frame, GivenFrame
from conrod.own.models.identity import identify
from conrod.own.models.references import other_branches
from conrod.own.models.request import DrivenRun, Question
from conrod.own.models.results import AS_GIVEN, OWN, QUANTITIES, CrankMotion, JudgedRun, ModelStudy
from conrod.own.models.scanning import scan
from conrod.runs.comparison import ExactMotions, size_of, track_errors
from conrod.runs.outcome import LOST_GAP, OPEN_GAP, OUT_OF_REACH, STALL, Verdict
from conrod.runs.trajectory import Instants, Outcome, PointTracks, Track
from conrod.scenes import Scene
from conrod.studies.frame.resolve_arguments import MOST_SAMPLES
from conrod.studies.validation.results import RefinementPoint

PRESETS = ("tuned", "hardened")
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
        assembly = prepare(path, question)
        turn = scan(assembly, question)
        facts, (identity, moving) = turn.facts, identify(machine, turn, given)
        misplaced = identity.explanations[0].misplaced if identity.explanations else ()
        wrong = {one.point for one in misplaced}
        # Compared are points that are where they should be on their links; all, where none is.
        points = tuple(point for point in turn.points if point not in wrong) or turn.points
        found = ModelStudy(str(path), name, machine, question, facts, identity, tolerance, revolutions, {}, {}, points)
        if identity.left > COMPARABLE:
            return found
        frame, first = identity.frame, float(turn.coordinate[0])
        start = first + float(np.remainder(frame.zero - first, 2.0 * np.pi))
        drive = CrankDrive(assembly, turn, frame.sense * machine.speed, start, revolutions)
        branches = other_branches(machine) if isinstance(moving, Scene) else (machine,)
        to = RunReference(moving, machine.speed, branches, frame, points, facts.touching is not None)
        as_given = drive.as_given(question)
        models, refused = _models(machine, assembly.original)
        driven = {label: drive.driven(model) for label, model in models.items()}
        runs = {label: judged(label, one, to) for label, one in driven.items()}
        at_steps = {label: [run] for label, run in runs.items()}
        for finer in FINER if refine else ():
            if finer * revolutions * machine.period <= MOST_SAMPLES * facts.timestep:
                for label, model in _models(machine, assembly.original, finer)[0].items():
                    at_steps[label].append(judged(label, drive.driven(model), to))
        own_run = judged(AS_GIVEN, as_given, to)
        crank = crank_motion(as_given, to) if own_run.outcome is Outcome.COMPLETED else None
        refined = {label: _points(same) for label, same in at_steps.items() if len(same) > 1}
        return replace(found, own_run=own_run, crank=crank, runs=runs, refused=refused, refined=refined)


def _models(
    scene: Scene, model: mujoco.MjModel, finer: float = 1.0
) -> tuple[dict[str, mujoco.MjModel], dict[str, str]]:
    """The model as it is, and with each preset's settings at its own step; presets that are refused.

    A heavy flywheel weighs in the cost by which the solver measures its tolerance: it goes on to the end.
    """
    engine, refused = engine_named("mujoco"), dict[str, str]()
    models = {OWN: changed(model, tolerance=0.0, finer=finer)}
    steps = max(2, round(finer * scene.period / float(model.opt.timestep)))
    for preset in PRESETS:
        settings: Any = engine.presets[preset](scene, steps)
        if (reason := engine.refusal(scene, settings)) is None:
            models[preset] = changed(model, settings, finer=finer)
        else:
            refused[preset] = reason
    return models, refused


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
