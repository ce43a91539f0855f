"""`conrod validate` of scenes: motion at constant crank speed, the forces in it, or motion without a drive."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from conrod.cli import options as exit_status
from conrod.cli.options import Request
from conrod.cli.outputs import outputs
from conrod.cli.reproduction import reproduction
from conrod.cli.runner import Runner
from conrod.cli.verdicts import print_forces, print_motions, print_verdicts
from conrod.engines import Engine
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity
from conrod.report.kind import Kind
from conrod.scenes import Scene
from conrod.studies.frame.files import naming
from conrod.studies.frame.resolve_arguments import (
    make_plan,
    parse_tolerance,
    select_engines,
    select_presets,
    select_scenes,
)
from conrod.studies.frame.result import SceneResults
from conrod.studies.frame.study import Study

DEFAULT_REVOLUTIONS = 2
# On the pages of so many machines: where it is, and how far off.
FEW_FIGURES = "mechanism,error"
SHORTEST_RUN, LONGEST_RUN, SHORTEST_STEP = 0.01, 1000.0, 1e-7  # [s]

Scenes = Mapping[str, Scene]
Presets = Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Measured:
    """Measurement on scenes, and its report.

    Attributes:
        kind: of the report.
        study: of scenes, engines and presets.
        show: prints what was found.
        given: options that the user gave, to make the report again.
        found: what is reported of what a study returns.
        drawn: options of the report's pages.
    """

    kind: Kind[Any]
    study: Callable[[Scenes, Sequence[Engine[Any]], Presets], Study[Sequence[Any]]]
    show: Callable[[Sequence[Any]], None]
    given: Mapping[str, object]
    found: Callable[[Any], SceneResults[Any]] = lambda study: study
    drawn: Mapping[str, Any] = field(default_factory=dict)


def validate_scenes(asked: Request) -> None:
    """Run what the ledger does not have, print verdicts, write what is to be written.

    Raises:
        InvalidInput: what was asked for does not fit together, before anything is run.
    """
    chosen = select_scenes(asked.subjects, asked.assignments)
    measured = _measured(asked, chosen)
    engines = select_engines(asked.engine)
    presets = select_presets(engines, asked.preset)
    files = outputs(measured.kind, chosen, asked.out, asked.document)
    with Runner.of(asked.how, files.file) as runner:
        studies = runner.pursue(measured.study(chosen, engines, presets))
    found = [measured.found(study) for study in studies]
    with naming("standard output"):
        measured.show(found)
    given = {"--engine": asked.engine, "--preset": asked.preset, **measured.given, "--tolerance": asked.tolerance}
    again = reproduction("validate", asked.subjects, given, asked.assignments, files.folder) if files.folder else None
    with runner.options.processes(runner.options.jobs) as executor:
        # One page is drawn here and now; several by all processes.
        draw = executor.map if len(found) > 1 else map
        files.write({one.name: one for one in found}, again, measured.drawn, draw)
    if not all(one.passed for one in found):
        sys.exit(exit_status.FAILED)


def _measured(asked: Request, chosen: Scenes) -> Measured:
    if asked.motion.motion is not None:
        return _free_motion(asked, chosen)
    return _steady_motion(asked, chosen) if asked.quantity is None else _forces(asked, chosen)


def _steady(asked: Request) -> dict[str, object]:
    """Options of a run at constant crank speed, as they were given."""
    turns = None if asked.revolutions == DEFAULT_REVOLUTIONS else asked.revolutions
    return {"--steps-per-rev": asked.steps_per_rev, "--revolutions": turns}


def _turns(asked: Request) -> int:
    return DEFAULT_REVOLUTIONS if asked.revolutions is None else asked.revolutions


def _steady_motion(asked: Request, chosen: Scenes) -> Measured:
    from conrod.report.charts.styles import figures_of
    from conrod.report.validation.report import KIND, without_motion
    from conrod.scenes.catalogue import CATALOGUE
    from conrod.studies.validation.study import validation

    plan = make_plan(chosen, asked.steps_per_rev, _turns(asked), asked.tolerance)
    figures = FEW_FIGURES if asked.figures is None and CATALOGUE in asked.subjects else asked.figures
    shown = figures_of(figures)
    if asked.figures is not None and asked.out is None:
        raise InvalidInput(f"--figures {asked.figures} is for a report: name its folder with --out")
    return Measured(
        kind=KIND,
        study=lambda scenes, engines, presets: validation(scenes, engines, presets, plan),
        show=print_verdicts,
        given={**_steady(asked), "--figures": figures},
        found=lambda study: study if "motion" in shown else without_motion(study),
        drawn={"figures": shown},
    )


def _forces(asked: Request, chosen: Scenes) -> Measured:
    from conrod.report.forces import KIND
    from conrod.studies.forces.study import ForcePlan, force_study

    if asked.figures is not None:
        raise InvalidInput("--figures does not go with --quantity: its report has one figure")
    quantities = _quantities(str(asked.quantity), chosen)
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, quantities)
    run = replace(make_plan(chosen, asked.steps_per_rev, _turns(asked), None), tolerance=allowed)
    return Measured(
        kind=KIND,
        study=lambda scenes, engines, presets: force_study(scenes, engines, presets, ForcePlan(run, quantities)),
        show=print_forces,
        given={"--quantity": asked.quantity, **_steady(asked)},
    )


def _quantities(text: str, scenes: Scenes) -> tuple[str, ...]:
    """The groups of quantities that were asked for, in their usual order.

    Raises:
        InvalidInput: an unknown one, one named twice, or contact where no scene has any.
    """
    from conrod.studies.forces.exact import GROUPS

    given = [name.strip() for name in text.split(",")]
    for name in given:
        if name not in GROUPS:
            raise unknown_choice("quantity", name, GROUPS)
        if given.count(name) > 1:
            raise InvalidInput(f"--quantity {text}: {name} is named twice")
    if given == ["contact"] and not any(scene.kinematics.mechanism.cam_contacts for scene in scenes.values()):
        raise InvalidInput(f"--quantity contact: no joint of {', '.join(scenes)} acts by contact")
    return tuple(name for name in GROUPS if name in given)


def _free_motion(asked: Request, chosen: Scenes) -> Measured:
    from conrod.report.free_motion import KIND
    from conrod.studies.free_motion.perform import motion_study
    from conrod.studies.free_motion.plan import MOTIONS, SECONDS, MotionPlan, instants
    from conrod.studies.free_motion.results import QUANTITIES

    given = asked.motion
    for name in ("steps_per_rev", "revolutions", "figures"):
        if getattr(asked, name) is not None:
            option = f"--{name.replace('_', '-')}"
            raise InvalidInput(f"{option} does not go with --motion: nothing turns the crank steadily")
    if given.motion not in MOTIONS:
        raise unknown_choice("motion", str(given.motion), MOTIONS)
    seconds = SECONDS if given.seconds is None else given.seconds
    check_number("--seconds", seconds, SHORTEST_RUN, LONGEST_RUN, "s")
    step = None if given.step is None else parse_quantity("--step", given.step, "s")
    if step is not None:
        check_number("--step", step, SHORTEST_STEP, seconds, "s")
    judged = None if asked.tolerance is None else parse_tolerance(asked.tolerance, QUANTITIES)
    plan = MotionPlan(given.motion, seconds, step, judged)
    instants(plan)
    for name, scene in chosen.items():
        plan.mechanism(scene.kinematics.mechanism, name)
    return Measured(
        kind=KIND,
        study=lambda scenes, engines, presets: motion_study(scenes, engines, presets, plan),
        show=print_motions,
        given={"--motion": given.motion, "--seconds": given.seconds, "--step": given.step},
    )
