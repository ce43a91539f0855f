"""`conrod validate` of scenes: motion at constant crank speed, the forces in it, or motion without a drive."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from conrod.cli import FAILED
from conrod.cli.baseline import Holding, holds
from conrod.cli.options import chosen_engines, refuse
from conrod.cli.outputs import outputs
from conrod.cli.runner import Runner, processes_of
from conrod.cli.validate_request import Request
from conrod.engines import Engine
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity
from conrod.report.kind import Kind
from conrod.report.results import name_of, summary_words, verdict_words
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import Scene
from conrod.studies.frame.baseline import Held
from conrod.studies.frame.case import Study, pursue
from conrod.studies.frame.resolve_arguments import (
    MOST_SAMPLES,
    MOST_STREAMED,
    make_plan,
    parse_tolerance,
    select_presets,
    select_scenes,
)
from conrod.studies.frame.result import SceneResults, study_of
from conrod.studies.frame.writing import naming

if TYPE_CHECKING:
    from conrod.studies.forces.results import ForceStudy
    from conrod.studies.free_motion.results import MotionStudy
    from conrod.studies.validation.plan import Plan
    from conrod.studies.validation.results import SceneStudy

DEFAULT_REVOLUTIONS = 2
SHORTEST_RUN, LONGEST_RUN, SHORTEST_STEP = 0.01, 1000.0, 1e-7  # [s]


@dataclass(frozen=True)
class Chosen:
    """Selection for a comparison: scenes and engines by name, and the presets of each engine."""

    scenes: Mapping[str, Scene]
    engines: Sequence[Engine[Any]]
    presets: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Measured:
    """Measurement on scenes, and its report.

    Attributes:
        kind: of the report.
        study: returns a study of each scene.
        show: prints what was found.
    """

    kind: Kind[Any]
    study: Study[Sequence[Any]]
    show: Callable[[Sequence[Any]], None]


def validate_scenes(asked: Request) -> None:
    """Run what the ledger does not have, print verdicts, write what is to be written.

    Raises:
        InvalidInput: what was asked for does not fit together, before anything is run.
    """
    from conrod.cli.verification import Dossier

    scenes = select_scenes(asked.subjects, asked.assignments)
    measured, holding = measured_of(asked, scenes), Holding.of(asked, scenes)
    files, dossier = outputs(measured.kind, scenes, asked), Dossier.of(asked, scenes)
    with Runner.of(replace(asked, fresh=True) if holding else asked) as runner:
        found = runner.pursue(measured.study)
        baseline = held_scenes(holding, asked, found, runner)
    with naming("standard output"):
        measured.show(found)
    with processes_of(asked) as executor:
        # One page is drawn here and now; several by all processes.
        draw = executor.map if len(found) > 1 else map
        every = {one.name: one for one in found}
        files.write(every, "validate", asked.subjects, asked, draw=draw)
    if dossier:
        dossier.write(found[0], scene_verdict(found[0]))
    if not holds(baseline) or not all(one.passed for one in found):
        sys.exit(FAILED)


def measured_of(asked: Request, scenes: Mapping[str, Scene]) -> Measured:
    """The measurement that was asked for; raises InvalidInput as `validate_scenes`."""
    engines = chosen_engines(asked.engine)
    chosen = Chosen(scenes, engines, select_presets(engines, asked.preset))
    if asked.motion is not None:
        return _free_motion(asked, chosen)
    return _steady_motion(asked, chosen) if asked.quantity is None else _forces(asked, chosen)


def held_scenes(holding: Holding | None, asked: Request, found: Sequence[Any], runner: Runner) -> Held | None:
    """Hold results against the baseline, if any; run what that needs."""
    own = replace(asked, qualify=False)

    def again(others: Sequence[Mapping[str, Scene]]) -> list[Sequence[Any]]:
        with runner.answering() as run:
            return pursue([measured_of(own, scenes).study for scenes in others], run)

    return None if holding is None else holding.held(found, again)


def _turns(asked: Request) -> int:
    return DEFAULT_REVOLUTIONS if asked.revolutions is None else asked.revolutions


# -- motion at constant crank speed ------------------------------------------------------------------------------------


def _steady_motion(asked: Request, chosen: Chosen) -> Measured:
    from conrod.report.validation import KIND

    most = MOST_SAMPLES if asked.qualify else MOST_STREAMED  # what defects are planted in is recorded whole
    plan = make_plan(chosen.scenes, asked.steps_per_rev, _turns(asked), asked.tolerance, most)
    return Measured(kind=KIND, study=_validation(chosen, plan, asked.qualify), show=print_verdicts)


def _validation(chosen: Chosen, plan: Plan, qualify: bool) -> Study[Sequence[SceneStudy]]:
    from conrod.studies.validation.study import validation

    found = yield from validation(chosen.scenes, chosen.engines, chosen.presets, plan)
    if not qualify:
        return found
    from conrod.studies.detection.qualification import qualified

    return (yield from qualified(found, chosen.scenes, chosen.engines, plan))


def print_verdicts(studies: Sequence[SceneStudy]) -> None:
    """Largest errors over the observed points, observed order, verdict; why what is not judged is not."""
    from conrod.report.validation_tables import added_words, qualification_table, verdicts_table

    out = console()
    print_table(out, verdicts_table(studies))
    print_lines(out, (f"{study.name}: {words}" for study in studies for words in added_words(study)))
    reasons = dict.fromkeys(
        (result.scene, result.tolerance.reason)
        for study in studies
        for result in study.results
        if result.passed is None and result.tolerance.reason
    )
    print_lines(out, (f"{scene}: tolerances: {reason}" for scene, reason in reasons))
    for study in studies:
        print_table(out, qualification_table(study))


def scene_verdict(study: SceneResults[Any]) -> str:
    """The verdict in words: each result that is out of tolerance, or that none is."""
    failed = [f"{' '.join(name_of(one))}: {verdict_words(one)}" for one in study.results if one.passed is False]
    return f"{study.name}: {'; '.join(failed) or summary_words(study.results)}"


# -- the forces in it --------------------------------------------------------------------------------------------------


def _forces(asked: Request, chosen: Chosen) -> Measured:
    from conrod.report.forces import KIND
    from conrod.studies.forces.study import ForceCase, ForcePlan

    refuse(asked, "--quantity: it qualifies the verdict on the motion, and on its forces beside it", "qualify")
    quantities = _quantities(str(asked.quantity), chosen.scenes)
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, quantities)
    run = make_plan(chosen.scenes, asked.steps_per_rev, _turns(asked), None)
    plan = ForcePlan(run.steps_per_revolution, run.revolutions, allowed, quantities)
    study = study_of(ForceCase, chosen.scenes, chosen.engines, chosen.presets, plan)
    return Measured(kind=KIND, study=study, show=print_forces)


def _quantities(text: str, scenes: Mapping[str, Scene]) -> tuple[str, ...]:
    """The groups of quantities that were asked for, in their usual order.

    Raises:
        InvalidInput: an unknown one, one named twice, or contact where no scene has any.
    """
    from conrod.studies.forces.results import GROUPS

    given = [name.strip() for name in text.split(",")]
    for name in given:
        if name not in GROUPS:
            raise unknown_choice("quantity", name, GROUPS)
        if given.count(name) > 1:
            raise InvalidInput(f"--quantity {text}: {name} is named twice")
    if given == ["contact"] and not any(scene.kinematics.mechanism.cam_contacts for scene in scenes.values()):
        raise InvalidInput(f"--quantity contact: no joint of {', '.join(scenes)} acts by contact")
    return tuple(name for name in GROUPS if name in given)


def print_forces(found: Sequence[ForceStudy]) -> None:
    """Largest errors, observed orders, verdict."""
    from conrod.report.forces import tolerance_reasons, verdicts_table

    out = console()
    print_table(out, verdicts_table(found))
    print_lines(out, (f"tolerance: {reason}" for reason in tolerance_reasons(r for one in found for r in one.results)))


# -- motion without a drive --------------------------------------------------------------------------------------------


def _free_motion(asked: Request, chosen: Chosen) -> Measured:
    from conrod.report.free_motion import KIND
    from conrod.studies.free_motion.perform import motion_study
    from conrod.studies.free_motion.plan import MOTIONS, MotionPlan, instants
    from conrod.studies.free_motion.results import QUANTITIES

    refuse(asked, "--motion: nothing turns the crank steadily", "steps_per_rev", "revolutions", "baseline")
    if asked.motion not in MOTIONS:
        raise unknown_choice("motion", str(asked.motion), MOTIONS)
    longest = LONGEST_RUN if asked.seconds is None else asked.seconds
    check_number("--seconds", longest, SHORTEST_RUN, LONGEST_RUN, "s")
    step = None if asked.step is None else parse_quantity("--step", asked.step, "s")
    if step is not None:
        check_number("--step", step, SHORTEST_STEP, longest, "s")
    judged = None if asked.tolerance is None else parse_tolerance(asked.tolerance, QUANTITIES)
    plan = MotionPlan(asked.motion, asked.seconds, step, judged)
    if asked.seconds is not None:
        instants(plan, asked.seconds)
    for name, scene in chosen.scenes.items():
        plan.mechanism(scene.kinematics.mechanism, name)
    return Measured(
        kind=KIND, study=motion_study(chosen.scenes, chosen.engines, chosen.presets, plan), show=print_motions
    )


def print_motions(studies: Sequence[MotionStudy]) -> None:
    """Errors in time, and what is to be said of the exact motion."""
    from conrod.report.free_motion import exact_words, loads_words, verdicts_table

    out = console()
    print_table(out, verdicts_table(studies))
    print_lines(out, (f"{study.name}: {loads_words(study)} {exact_words(study)}" for study in studies))
