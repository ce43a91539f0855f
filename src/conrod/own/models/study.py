"""The study of a user's model: its paths, its own run, and its runs with conrod's drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from conrod.engines import engine_named
from conrod.own.files import of_file
from conrod.own.models.assembly import prepare
from conrod.own.models.driving import CrankDrive, changed
from conrod.own.models.frame import GivenFrame
from conrod.own.models.identity import identify
from conrod.own.models.references import other_branches
from conrod.own.models.request import Question
from conrod.own.models.results import AS_GIVEN, OWN, ModelStudy
from conrod.own.models.runs import QUANTITIES, JudgedRun, RunReference, crank_motion, judged
from conrod.own.models.scanning import scan
from conrod.runs.trajectory import Outcome
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
    """Judge a model file; to be called in a process of its own, see `conrod.studies.execution.isolation`.

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
