"""`conrod versions`."""

from __future__ import annotations

from dataclasses import dataclass

import click

from conrod.cli import completion, options
from conrod.cli.options import ReportOptions, RunOptions, names_in, option


@dataclass(frozen=True)
class VersionsOptions(ReportOptions, RunOptions):
    """Request to `conrod versions`, as typed."""

    assignments: tuple[str, ...] = option("--set", help=options.FAMILY_HELP)
    versions: str | None = option(
        "--versions", metavar="LIST", help="Releases, with commas, e.g. 3.6.0,3.7.0 [all that conrod knows]."
    )
    costs: bool = option("--costs", is_flag=True, help="Time the runs too, in turns with the installed release.")


@options.verb(VersionsOptions)
@click.argument("engine", shell_complete=completion.engines)
@click.argument("scenes", nargs=-1, metavar="[SCENE...]", shell_complete=completion.scenes)
def versions(engine: str, scenes: tuple[str, ...], asked: VersionsOptions) -> None:
    """Measure what each release of an engine changed: outcome, error, and the last bit of every state.

    Each release is installed once, in an environment of its own in the cache folder. Finished runs are kept in the
    ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.engines import engine_named
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.studies.versions.api import DEFAULT_SCENES, versions
    from conrod.studies.versions.report import VERSIONS_REPORT

    engine_named(engine)
    chosen = select_scenes(scenes or DEFAULT_SCENES, asked.assignments)
    files = check_outputs(VERSIONS_REPORT, [engine], asked)
    with asked.runs() as runs:
        found = versions(engine, chosen, releases=names_in(asked.versions), costs=asked.costs, runs=runs)
    files.print_and_write(found, "versions", {engine: engine}, {"": scenes})
    exit_with_verdict(found)
