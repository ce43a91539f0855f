"""Free motion on the command line: progress, and a line for each result.

`conrod validate [SCENE...] --motion free|torque`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from conrod.cli import options as exit_status
from conrod.cli.options import MotionOptions
from conrod.cli.outputs import outputs
from conrod.cli.reproduction import reproduction
from conrod.cli.runner import available_cores
from conrod.engines import Engine
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity
from conrod.report.free_motion import KIND, exact_words, loads_words, results_table
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import Scene
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.execution.validation import run_jobs
from conrod.studies.frame.files import naming
from conrod.studies.frame.resolve_arguments import parse_tolerance, select_engines, select_presets, select_scenes
from conrod.studies.free_motion.perform import ExactJob, motion_jobs, motion_study
from conrod.studies.free_motion.plan import MOTIONS, SECONDS, MotionPlan, instants
from conrod.studies.free_motion.results import QUANTITIES, MotionStudy

WIDE = 180


def run_motions(
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, tuple[str, ...]],
    plan: MotionPlan,
    executor: Executor,
) -> list[MotionStudy]:
    """The exact motions, then the engines', with a bar on standard error where that is a terminal.

    Raises:
        InvalidInput: a scene has no such motion.
    """
    err = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        runs = sum(len(presets[engine.name]) for engine in engines)
        bar = progress.add_task("", total=len(scenes) * (1 + runs))
        done: Callable[[Any], None] = lambda job: progress.update(bar, advance=1, description=job.label)  # noqa: E731
        exact = run_jobs([ExactJob(name, scene, plan) for name, scene in scenes.items()], executor, done)
        courses = dict(zip(scenes, exact, strict=True))
        found = run_jobs(motion_jobs(courses, engines, presets, plan), executor, done)
    return [
        motion_study(name, scene, courses[name], plan, [result for result in found if result.scene == name])
        for name, scene in scenes.items()
    ]


def print_motions(studies: Sequence[MotionStudy]) -> None:
    """A line for each result, and what is to be said of the exact motion."""
    out = console(WIDE)
    print_table(out, results_table(studies, with_clock=True), folding=("verdict",))
    print_lines(out, (f"{study.name}: {loads_words(study)} {exact_words(study)}" for study in studies))


SHORTEST_RUN, LONGEST_RUN = 0.01, 1000.0  # [s]
SHORTEST_STEP = 1e-7  # [s]


def validate_motion(
    names: Sequence[str],
    options: MotionOptions,
    engine: str | None,
    preset: str | None,
    assignments: tuple[str, ...],
    jobs: int | None,
    tolerance: str | None,
    out: str | None,
    document: str | None,
    **others: Any,
) -> None:
    """Scenes in engines, let go or driven by their torques, from their start in motion.

    Raises:
        InvalidInput: what was asked for does not fit, or a scene has no such motion.
    """
    for name, value in others.items():
        if value is not None:
            raise InvalidInput(
                f"--{name.replace('_', '-')} does not go with --motion: nothing turns the crank steadily"
            )
    plan = _plan(options, tolerance)
    chosen = select_scenes(names, assignments)
    for name, scene in chosen.items():
        plan.mechanism(scene.kinematics.mechanism, name)
    engines = select_engines(engine)
    presets = select_presets(engines, preset)
    files = outputs(KIND, chosen, out, document)
    asked = {
        "--motion": options.motion, "--engine": engine, "--preset": preset, "--seconds": options.seconds,
        "--step": options.step, "--tolerance": tolerance,
    }  # fmt: skip
    with LocalProcesses(available_cores() if jobs is None else jobs) as executor:
        studies = run_motions(chosen, engines, presets, plan, executor)
    with naming("standard output"):
        print_motions(studies)
    command = reproduction("validate", names, asked, assignments, files.folder) if files.folder else None
    files.write({study.name: study for study in studies}, command)
    if not all(study.passed for study in studies):
        sys.exit(exit_status.FAILED)


def _plan(options: MotionOptions, tolerance: str | None) -> MotionPlan:
    """What was asked for; what cannot be is refused before any work is done."""
    if options.motion not in MOTIONS:
        raise unknown_choice("motion", str(options.motion), MOTIONS)
    seconds = SECONDS if options.seconds is None else options.seconds
    check_number("--seconds", seconds, SHORTEST_RUN, LONGEST_RUN, "s")
    step = None if options.step is None else parse_quantity("--step", options.step, "s")
    if step is not None:
        check_number("--step", step, SHORTEST_STEP, seconds, "s")
    judged = None if tolerance is None else parse_tolerance(tolerance, QUANTITIES)
    plan = MotionPlan(options.motion, seconds, step, judged)
    instants(plan)
    return plan
