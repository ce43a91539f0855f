"""`conrod validate` of scenes: motion at constant crank speed, the forces in it, or motion without a drive."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from conrod.cli.options import chosen_engines, refuse
from conrod.cli.runner import Runner
from conrod.cli.validate_request import MODEL, MOTION, TABLE, Judging, Request
from conrod.engines import Engine
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity
from conrod.report.kind import Kind
from conrod.report.results import name_of, summary_words, verdict_words
from conrod.report.terminal import Part, said
from conrod.scenes import Scene
from conrod.studies.frame.case import Study
from conrod.studies.frame.resolve_arguments import (
    MOST_SAMPLES,
    MOST_STREAMED,
    make_plan,
    parse_tolerance,
    select_presets,
    select_scenes,
)
from conrod.studies.frame.result import SceneResults, study_of

if TYPE_CHECKING:
    from conrod.studies.forces.results import ForceStudy
    from conrod.studies.free_motion.results import MotionStudy
    from conrod.studies.validation.results import SceneStudy

SHORTEST_RUN, LONGEST_RUN, SHORTEST_STEP = 0.01, 1000.0, 1e-7  # [s]


def judging(asked: Request, scenes: Mapping[str, Scene] | None = None) -> Judging:
    """What was asked for of scenes, those that are given in place of those named.

    Raises:
        InvalidInput: it does not fit together.
    """
    refuse(asked, "a scene: it is for a file", MODEL, *(() if asked.measured else (TABLE,)))
    if asked.motion is None:
        refuse(asked, "a crank at constant speed: it is for --motion free and --motion torque", MOTION)
    scenes = select_scenes(asked.subjects, asked.assignments) if scenes is None else scenes
    engines = chosen_engines(asked.engine)
    presets = select_presets(engines, asked.preset)
    measure = _free_motion if asked.motion is not None else _steady_motion if asked.quantity is None else _forces
    kind, _, told = measure(asked, (scenes, engines, presets))

    def judge(own: Request, others: Sequence[Mapping[str, Scene]]) -> list[Sequence[Any]]:
        with Runner.of(own) as runner:
            return runner.pursue([measure(own, (one, engines, presets))[1] for one in others])

    return Judging(kind, asked.subjects, list(scenes), judge, told, scene_verdict, scenes)


def scene_verdict(study: SceneResults[Any]) -> str:
    """The verdict in words: each result that is out of tolerance, or that none is."""
    failed = [f"{' '.join(name_of(one))}: {verdict_words(one)}" for one in study.results if one.passed is False]
    return f"{study.name}: {'; '.join(failed) or summary_words(study.results)}"


# What it is of: scenes and engines by name, and the presets of each engine.
Chosen = tuple[Mapping[str, Scene], Sequence[Engine[Any]], Mapping[str, tuple[str, ...]]]
# The kind of its report, the study, and what is told of its findings.
Measured = tuple[Kind[Any], Study[Sequence[Any]], Callable[[Sequence[Any]], Iterator[Part]]]


# -- motion at constant crank speed ------------------------------------------------------------------------------------


def _steady_motion(asked: Request, chosen: Chosen) -> Measured:
    from conrod.report.validation import KIND
    from conrod.studies.validation.study import validation

    most = MOST_SAMPLES if asked.qualify else MOST_STREAMED  # what defects are planted in is recorded whole
    plan = make_plan(chosen[0], asked.steps_per_rev, asked.turns, asked.tolerance, most)

    def study() -> Study[Sequence[SceneStudy]]:
        found = yield from validation(*chosen, plan)
        if not asked.qualify:
            return found
        from conrod.studies.detection.qualification import qualified

        return (yield from qualified(found, *chosen[:2], plan))

    return KIND, study(), verdicts


def verdicts(studies: Sequence[SceneStudy]) -> Iterator[Part]:
    """Largest errors over the observed points, observed order, verdict; why what is not judged is not."""
    from conrod.report.validation_tables import added_words, qualification_table, verdicts_table

    yield from distrusted(studies)
    yield verdicts_table(studies)
    yield from (f"{study.name}: {words}" for study in studies for words in added_words(study))
    reasons = dict.fromkeys(
        (result.scene, result.tolerance.reason)
        for study in studies
        for result in study.results
        if result.passed is None and result.tolerance.reason
    )
    yield from (f"{scene}: tolerances: {reason}" for scene, reason in reasons)
    yield from map(qualification_table, studies)


def distrusted(studies: Sequence[SceneResults[Any]]) -> Iterator[Part]:
    """Scenes whose exact motion contradicts itself, before anything else is said."""
    doubted = [study for study in studies if any(result.distrust for result in study.results)]
    yield from (said(f"{study.name}: {summary_words(study.results)}", False) for study in doubted)


# -- the forces in it --------------------------------------------------------------------------------------------------


def _forces(asked: Request, chosen: Chosen) -> Measured:
    from conrod.report.forces import KIND
    from conrod.studies.forces.study import ForceCase, ForcePlan

    refuse(asked, "--quantity: it qualifies the verdict on the motion, and on its forces beside it", "qualify")
    quantities = _quantities(str(asked.quantity), chosen[0])
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, quantities)
    run = make_plan(chosen[0], asked.steps_per_rev, asked.turns, None)
    plan = ForcePlan(run.steps_per_revolution, run.revolutions, allowed, quantities)
    return KIND, study_of(ForceCase, *chosen, plan), force_verdicts


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


def force_verdicts(found: Sequence[ForceStudy]) -> Iterator[Part]:
    """Largest errors, observed orders, verdict."""
    from conrod.report.forces import reasons, verdicts_table

    yield from distrusted(found)
    yield verdicts_table(found)
    yield from (f"tolerance: {reason}" for reason in reasons(r for one in found for r in one.results))


# -- motion without a drive --------------------------------------------------------------------------------------------


def _free_motion(asked: Request, chosen: Chosen) -> Measured:
    from conrod.report.free_motion import KIND
    from conrod.studies.free_motion.perform import motion_study
    from conrod.studies.free_motion.plan import MOTIONS, MotionPlan, instants
    from conrod.studies.free_motion.results import QUANTITIES

    refuse(asked, "--motion: it is for a crank at constant speed", "qualify", "quantity")
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
    for name, scene in chosen[0].items():
        plan.mechanism(scene.kinematics.mechanism, name)
    return KIND, motion_study(*chosen, plan), motion_verdicts


def motion_verdicts(studies: Sequence[MotionStudy]) -> Iterator[Part]:
    """Errors in time, and what is to be said of the exact motion."""
    from conrod.report.free_motion import exact_words, loads_words, verdicts_table

    yield verdicts_table(studies)
    yield from (f"{study.name}: {loads_words(study)} {exact_words(study)}" for study in studies)
