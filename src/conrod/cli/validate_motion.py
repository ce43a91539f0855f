"""Free motion on the command line: progress, and a line for each result.

`conrod validate [SCENE...] --motion free|torque`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from conrod.cli import options as exit_status
from conrod.cli.options import MotionOptions, RunOptions
from conrod.cli.outputs import outputs
from conrod.cli.reproduction import reproduction
from conrod.cli.runner import Runner
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity
from conrod.report.free_motion import KIND, exact_words, loads_words, results_table
from conrod.report.terminal import console, print_lines, print_table
from conrod.studies.frame.files import naming
from conrod.studies.frame.resolve_arguments import parse_tolerance, select_engines, select_presets, select_scenes
from conrod.studies.free_motion.perform import motion_study
from conrod.studies.free_motion.plan import MOTIONS, SECONDS, MotionPlan, instants
from conrod.studies.free_motion.results import QUANTITIES, MotionStudy

WIDE = 180


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
    how: RunOptions,
    engine: str | None,
    preset: str | None,
    assignments: tuple[str, ...],
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
    with Runner.of(how, files.file) as runner:
        studies = runner.pursue(motion_study(chosen, engines, presets, plan))
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
