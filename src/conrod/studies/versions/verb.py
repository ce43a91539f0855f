"""`conrod versions`."""

from __future__ import annotations

import shlex
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import click

from conrod.cli import completion, options, waiting
from conrod.cli.options import ReportOptions, RunOptions, controls_in, names_in, option
from conrod.errors import InvalidInput
from conrod.user_files import MODELS


@dataclass(frozen=True)
class VersionsOptions(ReportOptions, RunOptions):
    """Request to `conrod versions`, as typed."""

    assignments: tuple[str, ...] = option("--set", help=options.FAMILY_HELP)
    versions: str | None = option(
        "--versions", metavar="LIST", help="Releases, with commas, e.g. 3.6.0,3.7.0 [all that conrod knows]."
    )
    costs: bool = option("--costs", is_flag=True, help="Time the runs too, in turns with the installed release.")
    keyframe: str | None = option("--keyframe")
    controls: tuple[str, ...] = option("--ctrl")
    seconds: float | None = option("--seconds", type=float, metavar="S", help="Length of a model's run [2].")


OF_SCENES = ("assignments", "fresh", "jobs", "cluster", "cell_timeout", "cell_memory", "ledger")
OF_MODELS = ("keyframe", "controls", "seconds")


@options.verb(VersionsOptions)
@click.argument("engine", shell_complete=completion.engines)
@click.argument("scenes", nargs=-1, metavar="[SCENE...|MODEL.xml...]", shell_complete=completion.models_or_scenes)
def versions(engine: str, scenes: tuple[str, ...], asked: VersionsOptions) -> None:
    """Measure what each release of an engine changed: in scenes, or in models (.xml) of your own, run as they are.

    Each release is installed once, in an environment of its own in the cache folder. Finished runs of scenes are kept
    in the ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.engines import engine_named
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.studies.versions.api import DEFAULT_SCENES, versions
    from conrod.studies.versions.report import VERSIONS_REPORT

    if engine.lower().endswith(MODELS):
        raise InvalidInput(f"{engine}: the engine comes first: conrod versions mujoco {shlex.join((engine, *scenes))}")
    engine_named(engine)
    if models := [name for name in scenes if name.lower().endswith(MODELS)]:
        _compare_models(engine, scenes, models, asked)
        return
    options.refuse(asked, "scenes: it is for a model", *OF_MODELS)
    chosen = select_scenes(scenes or DEFAULT_SCENES, asked.assignments)
    files = check_outputs(VERSIONS_REPORT, [engine], asked)
    with runs_with_progress(asked) as runs:
        found = versions(engine, chosen, releases=names_in(asked.versions), costs=asked.costs, runs=runs)
    files.print_and_write(found, "versions", {engine: engine}, {"": scenes}, machines=chosen)
    exit_with_verdict(found)


def _compare_models(engine: str, names: tuple[str, ...], models: list[str], asked: VersionsOptions) -> None:
    """Run models as they are in releases of MuJoCo."""
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.models.upgrades.api import SECONDS, compare_releases
    from conrod.models.upgrades.report import UPGRADES_REPORT
    from conrod.user_files.files import protected_model_files

    if engine != "mujoco":
        raise InvalidInput(f"{models[0]}: {engine} reads no MJCF: a model is run in releases of mujoco")
    if other := next((name for name in names if name not in models), None):
        raise InvalidInput(f"{other}: scenes and models are compared apart: name one kind")
    options.refuse(asked, "a model: it is for scenes", *OF_SCENES)
    parts = {Path(name).stem: name for name in models}
    protected = {what: path for name in models for what, path in protected_model_files(Path(name)).items()}
    files = check_outputs(UPGRADES_REPORT, parts, asked, protected)
    with ExitStack() as under_way:

        def begin(name: str) -> None:
            under_way.close()
            under_way.enter_context(waiting(name, FILE_TIMEOUT))

        found = compare_releases(
            models,
            releases=names_in(asked.versions),
            keyframe=asked.keyframe,
            controls=controls_in(asked.controls),
            seconds=SECONDS if asked.seconds is None else asked.seconds,
            costs=asked.costs,
            progress=begin,
        )
    files.print_and_write(found, "versions mujoco", parts)
    exit_with_verdict(found)
