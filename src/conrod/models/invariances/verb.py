"""`conrod invariances`: changes that must not matter."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import click

from conrod.cli import completion, options, waiting
from conrod.cli.options import ReportOptions, controls_in, option


@dataclass(frozen=True)
class InvariancesOptions(ReportOptions):
    """Request to `conrod invariances`, as typed; None or empty where nothing was given."""

    keyframe: str | None = option("--keyframe")
    seconds: float | None = option("--seconds", type=float, metavar="S", help="Length of the run [2000 steps].")
    controls: tuple[str, ...] = option("--ctrl")
    assignments: tuple[str, ...] = option("--set")


@options.verb(InvariancesOptions)
@click.argument("subjects", nargs=-1, metavar="[MODEL.xml | SCENE]...", shell_complete=completion.models_or_scenes)
def invariances(subjects: tuple[str, ...], asked: InvariancesOptions) -> None:
    """Change what must not matter in MuJoCo models and SCENEs' models, and compare accelerations.

    Names, order of declaration, units, frames, and the like.
    Exit status 0: nothing mattered; 1: something did.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.errors import InvalidInput
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.execution.resolve_arguments import arguments_of_files, refuse_lists, select_scenes
    from conrod.models.invariances.api import invariances
    from conrod.models.invariances.report import INVARIANCES_REPORT
    from conrod.user_files import MODELS
    from conrod.user_files.files import check_readable, protected_model_files

    models = [name for name in subjects if name.lower().endswith(MODELS)]
    named, inputs = [name for name in subjects if name not in models], dict[str, Path]()
    for name in models:
        check_readable(Path(name))
        inputs |= protected_model_files(Path(name))
    refuse_lists(asked.assignments)
    scenes = select_scenes(named, asked.assignments) if named or not models else {}
    parts = [*(Path(name).stem for name in models), *scenes]
    if hidden := next((name for k, name in enumerate([*models, *scenes]) if parts[k] in parts[:k]), None):
        raise InvalidInput(f"{hidden}: another has the same name in the report: judge it by itself")
    files = check_outputs(INVARIANCES_REPORT, parts, asked, inputs)
    with ExitStack() as under_way:

        def begin(name: str) -> None:
            under_way.close()
            under_way.enter_context(waiting(name, FILE_TIMEOUT))

        found = invariances(
            [*models, *scenes.items()],
            keyframe=asked.keyframe,
            controls=controls_in(asked.controls),
            seconds=asked.seconds,
            progress=begin,
        )
    files.print_and_write(found, "invariances", {Path(name).stem: name for name in models} | arguments_of_files(named))
    exit_with_verdict(found)
