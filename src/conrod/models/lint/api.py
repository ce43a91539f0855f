"""Parts of a MuJoCo model that its motion does not need, and parts that will cause trouble."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from conrod.errors import as_names
from conrod.execution.local import call_on_file
from conrod.mechanism.units import check_number
from conrod.mjcf.request import controls_of, size_of_unit
from conrod.models.lint.findings import Report
from conrod.user_files.files import check_readable

SHORTEST_RUN, LONGEST_RUN = 1e-9, 1e9  # [s]


def lint(
    model: str | Path,
    *,
    keyframe: str | None = None,
    controls: Mapping[str, float] | None = None,
    seconds: float | None = None,
    ignore: str | Sequence[str] = (),
    fix_for: Path | None = None,
    unit: str | None = None,
) -> Report:
    """Find parts of a MuJoCo model that its motion does not need, and parts that will cause trouble.

    Args:
        model: path of an MJCF file, which is only read.
        keyframe: keyframe to start from; None for the first, "qpos0" for none.
        controls: inputs of actuators in place of the keyframe's.
        seconds: length of the run [s]; None for 2000 steps.
        ignore: names of rules that are left out.
        fix_for: folder that a fixed model is to lie in; None where none is wanted.
        unit: unit of the model's lengths: m, cm, mm or inch; metres where none is given.

    Raises:
        InvalidInput: the model or an argument cannot be used; says what can.
    """
    from conrod.models.lint.linting import lint as lint_file

    path = Path(model)
    check_readable(path)
    if seconds is not None:
        check_number("--seconds", seconds, SHORTEST_RUN, LONGEST_RUN, "s")
    given, size = controls_of(controls or {}), size_of_unit(unit)
    return call_on_file(lint_file, path, keyframe, seconds, as_names(ignore), fix_for, given, size)
