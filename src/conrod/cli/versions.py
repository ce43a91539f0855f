"""`conrod versions`."""

from __future__ import annotations

from dataclasses import dataclass

import click

from conrod.cli import options
from conrod.cli.options import ReportOptions, RunOptions, option
from conrod.errors import InvalidInput

DEFAULT_SCENES = ("saw-500rpm", "shear-press", "six-bar", "planetary-gear", "cam-follower")


@dataclass(frozen=True)
class Asked(ReportOptions, RunOptions):
    """Request to `conrod versions`, as typed."""

    assignments: tuple[str, ...] = option("--set")
    versions: str | None = option(
        "--versions", metavar="LIST", help="Releases, with commas, e.g. 3.6.0,3.7.0 [all that conrod knows]."
    )


@options.verb(Asked)
@click.argument("engine")
@click.argument("scenes", nargs=-1, metavar="[SCENE...]")
def versions(engine: str, scenes: tuple[str, ...], asked: Asked) -> None:
    """Measure what each release of an engine changed: outcome, error, and the last bit of every state.

    Each release is installed once, in an environment of its own in the cache folder. Finished runs are kept in the
    ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.outputs import outputs
    from conrod.cli.runner import Runner
    from conrod.engines import engine_named
    from conrod.engines.capabilities import KnownReleases, require_capability
    from conrod.report.terminal import Part
    from conrod.report.versions import KIND, changes_table, headline, unsupported_lines
    from conrod.studies.frame.resolve_arguments import select_scenes
    from conrod.studies.versions import plan_cases, versions_study

    if asked.cluster is not None:
        raise InvalidInput("--cluster does not go with versions: releases are installed on this machine")
    made, typed = engine_named(engine), scenes or DEFAULT_SCENES
    chosen = require_capability(made, KnownReleases).releases.select_versions(asked.versions)
    cases = plan_cases(select_scenes(typed, asked.assignments), made)
    files = outputs(KIND, [engine], asked)
    with Runner.of(asked) as runner:
        study = versions_study(made, chosen, cases, runner.run_in_release)
    told: list[Part] = [changes_table(study), headline(study), *unsupported_lines(study)]
    files.answer({engine: study}, told, "versions", {engine: engine}, {"": scenes})
