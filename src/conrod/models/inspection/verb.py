"""`conrod check MODEL.xml` without a scene: a user's own model, inspected."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from conrod.cli import waiting
from conrod.cli.options import controls_in, refuse_others
from conrod.errors import InvalidInput

TAKEN = ("--keyframe", "--ctrl", "--unit", "--engine", "--out", "--html", "--json")


def inspect_models(
    names: tuple[str, ...], asked: Any, unit: str | None, drives: Mapping[str, str] | None, said: Collection[str] = (),
) -> None:  # fmt: skip
    """Say what model files are: whether they load, close and move.

    Args:
        asked: options of `conrod check`.
        unit: unit of the models' lengths; None for metres.
        drives: laws of actuators, or of joints outside loops.
        said: names of files whose run was announced before.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.models.inspection.api import inspect_model
    from conrod.models.inspection.report import INSPECTION_REPORT
    from conrod.user_files.files import check_readable, protected_model_files

    if drives:
        refuse_others(asked, "--drive of an actuator, or outside loops", "--drive", *TAKEN)
    else:
        refuse_others(asked, "a model without --scene", *TAKEN)
    parts, inputs = dict[str, str](), dict[str, Path]()
    for name in names:
        if Path(name).stem in parts:
            raise InvalidInput(f"{name}: another has the same name in the report: inspect it by itself")
        check_readable(Path(name))
        inputs |= protected_model_files(Path(name))
        parts[Path(name).stem] = name
    files = check_outputs(INSPECTION_REPORT, parts, asked, inputs)
    controls = controls_in(asked.controls)
    with ExitStack() as under_way:

        def begin(name: str) -> None:
            under_way.close()
            if name not in said:
                under_way.enter_context(waiting(name, FILE_TIMEOUT))

        found = inspect_model(
            names, keyframe=asked.keyframe, drives=drives, controls=controls, unit=unit, progress=begin
        )
    files.print_and_write(found, "check", parts)
    exit_with_verdict(found)
