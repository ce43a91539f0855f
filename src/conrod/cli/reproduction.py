"""The command that makes a report again, for the report to print."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from conrod.report.reproduction import SCENE, Reproduction


def reproduction(
    command: str, scenes: Sequence[str], options: Mapping[str, object], assignments: Sequence[str], folder: Path
) -> Reproduction:
    """The command that makes a report on scenes again.

    Args:
        scenes: as they were typed.
        options, assignments: as of `command_line`.
    """
    from conrod.studies.frame.resolve_arguments import typed_names

    return Reproduction(command_line(command, options, assignments, folder), typed_names(scenes))


def command_line(command: str, options: Mapping[str, object], assignments: Sequence[str], folder: Path) -> str:
    """The words that a user would type, quoted for a shell; {scene} stands for the scenes.

    Args:
        options: by name; those that are None were not given, of a tuple each value was.
        assignments: what was given with --set.
    """
    words = ["conrod", command, SCENE]
    for name, value in options.items():
        given = value if isinstance(value, tuple) else () if value is None else (value,)
        for one in given:
            words += [name, shlex.quote(_typed(one))]
    for assignment in assignments:
        words += ["--set", shlex.quote(assignment)]
    return " ".join([*words, "--out", shlex.quote(str(folder))])


def _typed(value: object) -> str:
    """A whole number without the point that a float has."""
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)
