"""`conrod limits`."""

from __future__ import annotations

from dataclasses import dataclass

import click
from click.shell_completion import CompletionItem

from conrod.cli import completion, options
from conrod.cli.options import StudyOptions, option
from conrod.errors import InvalidInput
from conrod.mechanism.units import parse_quantity

SEPARATOR = ".."


def complete_axes(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Complete names of axes and pairs of axes."""
    from conrod.studies.limits.plan import SEARCHES

    return completion.matching_names(SEARCHES, typed)


@dataclass(frozen=True)
class LimitsOptions(StudyOptions):
    """Request to `conrod limits`, as typed; None or empty where nothing was given."""

    axes: tuple[str, ...] = option(
        "--axis",
        multiple=True,
        metavar="AXIS",
        shell_complete=complete_axes,
        help="One axis or pair of docs/limits.md, again for others [all].",
    )
    span: str | None = option("--range", metavar="FROM..TO", help="Other ends of the one axis, e.g. 200..2.")
    preset: str | None = option("--preset")


@options.verb(LimitsOptions)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...", shell_complete=completion.scenes)
def limits(scenes: tuple[str, ...], asked: LimitsOptions) -> None:
    """Find where each engine stops being trustworthy, how it fails there, and whether one would notice.

    Each axis is walked from its safe end to its failing one, and its boundaries are found to 2 %. Finished runs are
    kept in the ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.studies.limits.api import limits
    from conrod.studies.limits.report import LIMITS_REPORT

    chosen, span = select_scenes(scenes, asked.assignments), None if asked.span is None else _span(asked.span)
    files = check_outputs(LIMITS_REPORT, chosen, asked)
    with runs_with_progress(asked) as runs:
        found = limits(chosen, axes=asked.axes, span=span, engines=asked.engine, preset=asked.preset, runs=runs)
    # Limits of a run are given too: they decide how some end.
    ended = {"--cell-timeout": asked.cell_timeout, "--cell-memory": asked.cell_memory}
    files.print_and_write(found, "limits", scenes, ended, machines=chosen)
    exit_with_verdict(found)


def _span(text: str) -> tuple[float, float]:
    """Parse the two ends of a range, as in `200..2`.

    Raises:
        InvalidInput: the text does not have two ends, or an end is no number.
    """
    ends = [parse_quantity("--range", part, "") for part in text.split(SEPARATOR) if part.strip()]
    if len(ends) != 2:
        raise InvalidInput(f"--range {text!r}: give two different ends, for instance 1000{SEPARATOR}2")
    return ends[0], ends[1]
