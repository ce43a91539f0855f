"""`conrod free`: motion without a drive."""

from __future__ import annotations

from dataclasses import dataclass

import click

from conrod.cli import completion, options
from conrod.cli.options import JudgedOptions, RunOptions, option, tolerance_in


@dataclass(frozen=True)
class FreeOptions(JudgedOptions, RunOptions):
    """Request to `conrod free`, as typed; None or empty where nothing was given."""

    torque: bool = option("--torque", is_flag=True, help="With the torques of the scene's driver.")
    seconds: float | None = option("--seconds", type=float, metavar="S", help="Length of the motion [10].")
    step: str | None = option("--step", metavar="TIME", help="Time step of the engines [5 ms or less].")
    engine: tuple[str, ...] = option("--engine")
    preset: str | None = option("--preset")
    assignments: tuple[str, ...] = option("--set", help=options.FAMILY_HELP)


@options.verb(FreeOptions)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...", shell_complete=completion.scenes)
def free(scenes: tuple[str, ...], asked: FreeOptions) -> None:
    """Compare the motion of SCENEs without a drive with their equations of motion.

    Machines move by weight, springs, loads and their start.
    Exit status 0: all that was judged is within tolerance; 1: something is not.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.mechanism.units import parse_quantity
    from conrod.studies.free_motion.api import free_motion
    from conrod.studies.free_motion.report import FREE_MOTION_REPORT
    from conrod.studies.free_motion.results import FREE_MOTION_QUANTITIES

    chosen = select_scenes(scenes, asked.assignments)
    files = check_outputs(FREE_MOTION_REPORT, chosen, asked)
    with runs_with_progress(asked) as runs:
        found = free_motion(
            chosen,
            torque=asked.torque,
            seconds=asked.seconds,
            step=None if asked.step is None else parse_quantity("--step", asked.step, "s"),
            engines=asked.engine,
            preset=asked.preset,
            tolerance=tolerance_in(asked.tolerance, FREE_MOTION_QUANTITIES),
            baseline=asked.baseline,
            accept=asked.accept,
            runs=runs,
        )
    files.print_and_write(found, "free", scenes, machines=chosen)
    exit_with_verdict(found)
