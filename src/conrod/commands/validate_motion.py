"""`conrod validate [SCENE...] --motion free|torque`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from conrod.commands import exit_status
from conrod.commands.motion_options import MotionOptions
from conrod.commands.reproduction import reproduction
from conrod.commands.runner import available_cores
from conrod.errors import InvalidInput, unknown_choice
from conrod.execution.local import LocalProcesses
from conrod.files import Batch, file_to_write, folder_to_write, naming, single, write_together
from conrod.motion_console import print_motions, run_motions
from conrod.ranges import check_number
from conrod.report.free_motion.document import motions_text
from conrod.report.free_motion.folder import check_motion_apart, check_motion_folder
from conrod.report.free_motion.writer import motion_batch
from conrod.selection import parse_tolerance, select_engines, select_presets, select_scenes
from conrod.studies.free_motion.plan import MOTIONS, SECONDS, MotionPlan, instants
from conrod.studies.free_motion.results import QUANTITIES, MotionStudy
from conrod.units import parse_quantity

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
    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        check_motion_folder(folder, chosen)
        if file:
            check_motion_apart(file, folder, chosen)
    asked = {
        "--motion": options.motion, "--engine": engine, "--preset": preset, "--seconds": options.seconds,
        "--step": options.step, "--tolerance": tolerance,
    }  # fmt: skip
    with LocalProcesses(available_cores() if jobs is None else jobs) as executor:
        studies = run_motions(chosen, engines, presets, plan, executor)
    with naming("standard output"):
        print_motions(studies)
    batches = [single(file, motions_text(studies))] if file else []
    if folder:
        batches.append(_report(studies, folder, names, asked, assignments))
    write_together(batches)
    if folder:
        click.echo(f"report: {', '.join(str(folder / f'{name}-motion.md') for name in chosen)}")
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


def _report(
    studies: Sequence[MotionStudy],
    folder: Path,
    names: Sequence[str],
    asked: dict[str, Any],
    assignments: Sequence[str],
) -> Batch:
    return motion_batch(studies, folder, reproduction("validate", names, asked, assignments, folder))
