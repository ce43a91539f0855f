"""`conrod check MODEL.xml --drive JOINT=LAW --engine ENGINE`: a model's loops in several engines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from conrod.cli import waiting
from conrod.cli.options import refuse_others, tolerance_in
from conrod.errors import InvalidInput, named_values

TAKEN = (
    *("--drive", "--engine", "--preset", "--steps-per-rev", "--revolutions", "--keyframe", "--point", "--unit"),
    *("--tolerance", "--out", "--html", "--json"),
)


def compare_engines(names: tuple[str, ...], asked: Any, unit: str | None) -> None:
    """Compare engines on the loops of model files.

    Args:
        asked: options of `conrod check`.
        unit: of the models' lengths; None where none is given.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.exact.space.drive_laws import FORMS
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.models.engine_comparison.api import check_loops_in_engines
    from conrod.scenes import machines_in_space
    from conrod.studies.space.report import SPACE_REPORT
    from conrod.studies.space.results import UNITS
    from conrod.user_files.files import check_readable, protected_model_files

    if known := machines_in_space(names):
        raise InvalidInput(f"{known[0]}: engines are compared on a machine in space by conrod validate {known[0]}")
    refuse_others(asked, "a model in several engines", *TAKEN)
    inputs = dict[str, Path]()
    for name in names:
        check_readable(Path(name))
        inputs |= protected_model_files(Path(name))
    drives = named_values(asked.drives, "--drive", f"a joint and its law, JOINT=LAW; LAW: {FORMS}")
    files = check_outputs(SPACE_REPORT, [Path(name).stem for name in names], asked, inputs)
    found = check_loops_in_engines(
        names,
        drives=drives,
        engines=asked.engine,
        preset=asked.preset,
        steps_per_rev=asked.steps_per_rev,
        revolutions=1 if asked.revolutions is None else asked.revolutions,
        points=asked.points,
        keyframe=asked.keyframe,
        tolerance=tolerance_in(asked.tolerance, UNITS),
        unit=unit,
        while_reading=lambda name: waiting(name, FILE_TIMEOUT),
        runs=asked.runs,
    )
    files.print_and_write(found, "check", names)
    exit_with_verdict(found)
