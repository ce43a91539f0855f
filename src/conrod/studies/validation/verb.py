"""`conrod validate`: motion of scenes at constant crank speed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import click

from conrod.cli import completion, options, say
from conrod.cli.options import OUTPUT, RunOptions, VerificationOptions, option, refuse, tolerance_in
from conrod.errors import InvalidInput


@dataclass(frozen=True)
class ValidateOptions(VerificationOptions, RunOptions):
    """Request to `conrod validate`, as typed; None or empty where nothing was given."""

    engine: tuple[str, ...] = option("--engine")
    preset: str | None = option("--preset")
    steps_per_rev: int | None = option("--steps-per-rev", type=int, metavar="N", help="Steps a turn [1000; cam 62832].")
    revolutions: int | None = option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
    assignments: tuple[str, ...] = option("--set", help=options.FAMILY_HELP)
    cost_ratio: float | None = option(
        "--cost-ratio", OUTPUT, type=float, metavar="R", help="Fail above R times the baseline's costs."
    )
    qualify: bool = option("--qualify", is_flag=True, help="Plant known defects too: which are noticed?")


@options.verb(ValidateOptions)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...", shell_complete=completion.scenes)
def validate(scenes: tuple[str, ...], asked: ValidateOptions) -> None:
    """Compare engines with the exact motion of SCENEs at constant crank speed.

    A SCENE is a name that `conrod show` lists or a mechanism file (.toml); `catalogue` and `spatial` name all scenes of
    these groups. Without a SCENE, all with a closed form are run.
    Exit status 0: all that was judged is within tolerance; 1: something is not.
    """
    from conrod.scenes import machines_in_space

    if spatial := machines_in_space(scenes):
        if len(spatial) < len(scenes):
            other = next(name for name in scenes if name not in spatial)
            raise InvalidInput(f"{spatial[0]} is a machine in space, {other} is not: validate them one after the other")
        _validate_in_space(scenes, asked)
        return
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.execution.tolerances import ALL_TOLERANCE_NAMES
    from conrod.studies.validation.api import REVOLUTIONS, validate
    from conrod.studies.validation.report import VALIDATION_REPORT
    from conrod.user_files import FILES

    if any(name.lower().endswith(FILES) for name in scenes):
        options.refuse_old_spelling(click.get_current_context())
    asked = with_project_settings(asked)
    chosen = select_scenes(scenes, asked.assignments)
    dossier = None
    files = check_outputs(VALIDATION_REPORT, chosen, asked)
    if asked.verification is None:
        refuse(asked, "no --verification", *MEASUREMENTS)
    else:
        from conrod.verification.verb import Dossier

        dossier = Dossier.prepare("validate", scenes, asked, chosen)
    with runs_with_progress(asked) as runs:
        found = validate(
            chosen,
            engines=asked.engine,
            preset=asked.preset,
            steps_per_rev=asked.steps_per_rev,
            revolutions=REVOLUTIONS if asked.revolutions is None else asked.revolutions,
            tolerance=tolerance_in(asked.tolerance, ALL_TOLERANCE_NAMES),
            qualify=asked.qualify,
            baseline=asked.baseline,
            accept=asked.accept,
            cost_ratio=asked.cost_ratio,
            runs=runs,
        )
    files.print_and_write(found, "validate", scenes, machines=chosen)
    if dossier:
        dossier.write(found)
    exit_with_verdict(found)


def with_project_settings(asked: ValidateOptions) -> ValidateOptions:
    """Fill in options that were not typed from the project's pyproject.toml, and print which."""
    if (file := options.project_file()) is None:
        return asked
    from conrod.cli.project import read_project_settings

    settings = read_project_settings(file)
    if settings is None:
        return asked
    filled = replace(
        asked,
        engine=asked.engine or settings.engines,
        preset=asked.preset or settings.preset,
        tolerance=asked.tolerance or settings.tolerance_text,
    )
    taken = {"engine": ", ".join(filled.engine), "preset": filled.preset, "tolerance": filled.tolerance}
    changed = [f"{name} {value}" for name, value in taken.items() if getattr(filled, name) != getattr(asked, name)]
    if changed:
        say(f"{settings.file}: {'; '.join(changed)}", err=True)
    return filled


MEASUREMENTS = ("title", "measured", "limits", "uncertainties", "columns", "units", "estimate")
TAKEN_IN_SPACE = (
    *("--engine", "--tolerance", "--out", "--html", "--json", "--verification", "--title"),
    *("--baseline", "--accept"),
)

TAKEN_FIELDS = ("out", "document", "html", "tolerance", "verification", "title", "baseline", "accept")


def _validate_in_space(names: tuple[str, ...], asked: ValidateOptions) -> None:
    """Judge machines in space by their own exact motion, driven as they are made for.

    MuJoCo alone runs them with all that is asked of a model's loops; engines that are named are compared.
    """
    if options.compares_engines(asked, "studies.space"):
        from conrod.studies.space.verb import compare_engines

        compare_engines(names, asked)
        return
    from conrod.models.check.verb import CheckOptions, judge_loops

    options.refuse_others(asked, "a machine in space", *TAKEN_IN_SPACE)
    common = {name: getattr(asked, name) for name in TAKEN_FIELDS}
    judge_loops("validate", names, replace(CheckOptions(), engine=asked.engine, **common))
