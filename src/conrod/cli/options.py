"""Options that commands share, and options of one purpose as fields of one dataclass."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import click

from conrod.cli import HEADING, Verb, say
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.engines import Engine

CELL_TIMEOUT = 600.0  # [s]
MOST_MEMORY = 2.0**60  # bytes, that a process can be limited to
DEFAULT_GRID = "default"
Command = TypeVar("Command", bound=Callable[..., Any])


verb = partial(click.command, cls=Verb)


class HeadedOption(click.Option):
    """An option under a heading of its own, which --help-all shows."""

    def __init__(self, *arguments: Any, heading: str = "", **attributes: Any) -> None:
        super().__init__(*arguments, **attributes)
        self.heading = heading


# -- options that mean the same in every verb --------------------------------------------------------------------------

SHARED: Mapping[str, Mapping[str, Any]] = {
    "--out": {"metavar": "DIR", "help": "Write the report there."},
    "--json": {"metavar": "FILE", "help": "Write the results as JSON."},
    "--html": {"metavar": "FILE", "help": "Write the report as one HTML file."},
    "--engine": {
        "multiple": True,
        "metavar": "ENGINE",
        "help": "This engine only, again for others; or all.",
    },
    "--preset": {
        "metavar": "PRESET",
        "help": "One preset only; `conrod show` lists them.",
    },
    "--set": {"multiple": True, "metavar": "NAME=VALUE", "help": "Override a parameter, e.g. --set crank=80mm."},
    "--ctrl": {
        "multiple": True,
        "metavar": "NAME=VALUE",
        "help": "Control of an actuator, by name or number, in MuJoCo's units [the keyframe's].",
    },
    "--grid": {
        "default": DEFAULT_GRID,
        "show_default": True,
        "metavar": "GRID",
        "help": "coarse, default or presets.",
    },
    "--ledger": {"metavar": "FILE", "help": "Where finished runs are kept [in the cache folder]."},
    "--jobs": {"type": int, "metavar": "N", "help": "Runs at a time on this machine [one a core]."},
}
assignments = click.option("--set", "assignments", **SHARED["--set"])
ledger = click.option("--ledger", **SHARED["--ledger"])
out = click.option("--out", **SHARED["--out"])
document = click.option("--json", "document", **SHARED["--json"])
html = click.option("--html", **SHARED["--html"])


def chosen_engines(names: tuple[str, ...]) -> list[Engine[Any]]:
    """The engines that --engine names; one line on each that nobody named and that cannot be loaded.

    Raises:
        InvalidInput: there is no such engine, or it cannot be loaded.
    """
    from conrod.studies.frame.resolve_arguments import select_engines

    return select_engines(names, left_out=lambda reason: say(f"conrod: left out: {reason}", err=True))


def option(name: str, **attributes: Any) -> Any:
    """A field that is an option, by its names, attributes as of `click.option`; None or empty where not given."""
    attributes = {**SHARED.get(name, {}), **attributes}
    empty: Any = () if attributes.get("multiple") else False if attributes.get("is_flag") else None
    return field(default=attributes.get("default", empty), metadata={"option": name, **attributes})


def gathered(name: str, kind: type[Any]) -> Callable[[Command], Command]:
    """A decorator that adds options to a command, which gets their values as one object.

    Args:
        name: of the command's argument.
        kind: a dataclass, each `option` of which is one, under the `heading` of its class.
    """
    own = list(kind.__annotations__)
    fields = sorted(dataclasses.fields(kind), key=lambda one: own.index(one.name) if one.name in own else len(own))
    bases: list[Any] = [base for base in kind.__mro__ if dataclasses.is_dataclass(base)]
    home = {one.name: vars(base).get("heading", HEADING) for base in bases for one in dataclasses.fields(base)}

    def decorate(command: Command) -> Command:
        @wraps(command)
        def called(**values: Any) -> Any:
            own = {one.name: values.pop(one.name) for one in fields if one.name in values}
            return command(**{name: kind(**own)}, **values)

        decorated: Any = called
        for one in reversed(fields):
            if one.metadata:
                attributes = {**one.metadata, "cls": HeadedOption, "heading": home[one.name]}
                decorated = click.option(*attributes.pop("option").split(), one.name, **attributes)(decorated)
        result: Command = decorated
        return result

    return decorate


def refuse(asked: Any, subject: str, *which: type | str) -> None:
    """Refuse options that do not go with something.

    Args:
        asked: the values of options, see `gathered`.
        subject: what they do not go with, for the message: "a scene".
        which: fields by name, or all of a class.

    Raises:
        InvalidInput: names the first option that was given.
    """
    names = [one.name for kind in which if isinstance(kind, type) for one in dataclasses.fields(kind)]
    for one in dataclasses.fields(asked):
        if one.name in (*names, *which) and getattr(asked, one.name) != one.default:
            raise InvalidInput(f"{one.metadata['option']} does not go with {subject}")


def as_given(asked: Any, *left_out: type | str) -> dict[str, object]:
    """Values of options that were given, by the options' names, but for those left out."""
    names = [one.name for kind in left_out if isinstance(kind, type) for one in dataclasses.fields(kind)]
    given = [one for one in dataclasses.fields(asked) if one.metadata and one.name not in (*names, *left_out)]
    return {one.metadata["option"]: value for one in given if (value := getattr(asked, one.name)) != one.default}


@dataclass(frozen=True)
class RunOptions:
    """Options on how runs are made and where they are kept; None where nothing was given."""

    heading: ClassVar[str] = "Runs and ledger"

    ledger: str | None = option("--ledger")
    fresh: bool = option("--fresh", is_flag=True, help="Do again what the ledger has.")
    jobs: int | None = option("--jobs")
    cluster: str | None = option(
        "--cluster", metavar="ADDRESS", help="Run on a Dask cluster instead, e.g. tcp://host:8786."
    )
    cell_timeout: float | None = option(
        "--cell-timeout", type=float, metavar="SECONDS", help="End a run that takes longer [600]."
    )
    cell_memory: str | None = option(
        "--cell-memory", metavar="SIZE", help="End a run that needs more, e.g. 4GB [no limit]."
    )

    @property
    def timeout(self) -> float:
        """Longest time of a cell [s]."""
        return CELL_TIMEOUT if self.cell_timeout is None else self.cell_timeout

    @property
    def memory(self) -> int | None:
        """Most memory of a cell [bytes]."""
        from conrod.mechanism.units import check_number, parse_quantity

        if self.cell_memory is None:
            return None
        memory = parse_quantity("--cell-memory", self.cell_memory, "byte")
        check_number("--cell-memory", memory, 0.0, MOST_MEMORY, "byte")
        return round(memory)

    @property
    def ledger_file(self) -> Path:
        """The ledger that was named, or the user's own."""
        from conrod.studies.frame.ledger import default_path

        return default_path() if self.ledger is None else Path(self.ledger)


def available_cores() -> int:
    """Cores that this process may use, as far as the system says."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class ReportOptions:
    """Options of a verb that reports; None where nothing was given.

    Attributes:
        assignments: of --set, where the verb has it.
        document, html: the files that --json and --html name.
    """

    assignments: tuple[str, ...] = ()
    out: str | None = option("--out")
    document: str | None = option("--json")
    html: str | None = option("--html")

    @property
    def given(self) -> dict[str, object]:
        """Options given that the result follows from, by name."""
        files = ("out", "document", "html", "baseline", "accept", "report", "measured", "limits", "uncertainties")
        return as_given(self, RunOptions, "assignments", *files)


@dataclass(frozen=True)
class StudyOptions(ReportOptions):
    """Options of a verb that studies engines on scenes."""

    engine: tuple[str, ...] = option("--engine")
    assignments: tuple[str, ...] = option("--set")
