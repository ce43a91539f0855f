"""What each release of an engine changed: outcome, error, and the last bit of every state."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from conrod.engines import engine_named
from conrod.engines.capabilities import KnownReleases, require_capability
from conrod.errors import InvalidInput, as_names
from conrod.execution.release_costs import BLOCK_TIMEOUT, time_in_releases
from conrod.execution.releases import ReleaseProcesses
from conrod.execution.resolve_arguments import Scenes, scenes_by_name
from conrod.execution.runner import Runner, Runs
from conrod.report.findings import Findings, text_of_call
from conrod.studies.versions.report import VERSIONS_REPORT
from conrod.studies.versions.study import VersionStudy, release_cases, versions_study

DEFAULT_SCENES = ("saw-500rpm", "shear-press", "six-bar", "planetary-gear", "cam-follower")


def versions(
    engine: str,
    scenes: Scenes = (),
    *,
    releases: str | Sequence[str] | None = None,
    costs: bool = False,
    runs: Runs | None = None,
) -> Findings[VersionStudy]:
    """Run the same cases in several releases of an engine, each installed once in a separate environment.

    Args:
        engine: name of the engine.
        scenes: as in `validate`; five of different kinds where none is given.
        releases: such as ("3.6.0", "3.7.0"); all that conrod knows where none is given.
        costs: time the runs too, each release in turns with the installed one, or with the first.
        runs: how runs are made, and where their results are kept.

    Raises:
        InvalidInput: an argument cannot be used, or no release can be installed.
    """
    runs, made = runs or Runs(), engine_named(engine)
    if runs.cluster is not None:
        raise InvalidInput("--cluster does not go with versions: releases are installed on this machine")
    known = require_capability(made, KnownReleases).releases
    chosen = known.select_versions(None if releases is None else ",".join(as_names(releases)))
    cases = release_cases(scenes_by_name(scenes or DEFAULT_SCENES), made)
    with Runner.open(runs) as runner:
        if not costs:
            study = versions_study(made, chosen, cases, runner.run_in_release)
        else:
            with ReleaseProcesses(engine, known.requirement, BLOCK_TIMEOUT) as processes:
                study = versions_study(made, chosen, cases, runner.run_in_release, partial(time_in_releases, processes))
    call = text_of_call("versions", engine, releases=releases, costs=costs or None)
    return Findings(VERSIONS_REPORT, {engine: study}, call)
