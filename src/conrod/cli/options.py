"""Exit statuses of the command line.

Options that several commands share.

Options of one purpose, handed to a command as one object.

Options of `conrod validate --motion`: a motion that no drive prescribes.

Options of `conrod validate TRAJECTORY.csv`: what is what in a table of any tool.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, TypeVar

import click

from conrod.errors import InvalidInput

FAILED, USAGE, INTERRUPTED = 1, 2, 130


DEFAULT_GRID = "default"
Command = TypeVar("Command", bound=Callable[..., Any])

assignments = click.option(
    "--set", "assignments", multiple=True, metavar="NAME=VALUE", help="Override a parameter, e.g. --set crank=80mm."
)
engine = click.option("--engine", metavar="ENGINE", help="One engine only; `conrod show` lists them.")
grid = click.option("--grid", default=DEFAULT_GRID, show_default=True, metavar="GRID", help="coarse, default or fine.")
ledger = click.option(
    "--ledger", metavar="FILE", help="Where finished runs are kept [a file in the user's cache folder]."
)
retime = click.option("--retime", is_flag=True, help="Time again what the ledger has, without running it again.")
jobs = click.option("--jobs", type=int, metavar="N", help="Runs at a time on this machine [one a core].")

RUNS = (
    ledger,
    click.option("--fresh", is_flag=True, help="Do again what the ledger has."),
    jobs,
    click.option("--cluster", metavar="ADDRESS", help="Run on a Dask cluster instead, e.g. tcp://host:8786."),
    click.option("--cell-timeout", type=float, metavar="SECONDS", help="End a run that takes longer [600]."),
    click.option("--cell-memory", metavar="SIZE", help="End a run that needs more, e.g. 4GB [no limit]."),
)


def runs(command: Command) -> Command:
    """Options of how runs are made and where they are kept."""
    for option in reversed(RUNS):
        command = option(command)
    return command


def bundled(name: str, bundle: type, options: tuple[Callable[[Any], Any], ...]) -> Callable[[Command], Command]:
    """A decorator that adds options to a command, which gets their values as one object.

    Args:
        name: of the command's argument.
        bundle: a frozen dataclass with a field for each option, each with the option's default.
        options: decorators as `click.option` gives them.
    """
    fields = [field.name for field in dataclasses.fields(bundle)]

    def decorate(command: Command) -> Command:
        @wraps(command)
        def gathered(**values: Any) -> Any:
            return command(**{name: bundle(**{field: values.pop(field) for field in fields})}, **values)

        decorated: Any = gathered
        for option in reversed(options):
            decorated = option(decorated)
        result: Command = decorated
        return result

    return decorate


def check_unused(bundle: Any, subject: str) -> None:
    """Refuse options of a purpose that what was named does not have.

    Args:
        bundle: what the options were given as.
        subject: what was named instead, for the message: "a scene".

    Raises:
        InvalidInput: names the first option that was given.
    """
    for option_field in dataclasses.fields(bundle):
        if getattr(bundle, option_field.name) != option_field.default:
            option = option_field.metadata.get("option", "--" + option_field.name.replace("_", "-"))
            raise InvalidInput(f"{option} does not go with {subject}")


@dataclass(frozen=True)
class RunOptions:
    """How runs are made and where they are kept; None where nothing was given."""

    ledger: str | None = None
    fresh: bool = False
    jobs: int | None = None
    cluster: str | None = None
    cell_timeout: float | None = None
    cell_memory: str | None = None


of_runs = bundled("how", RunOptions, RUNS)


@dataclass(frozen=True)
class MotionOptions:
    """What was given; None where nothing was."""

    motion: str | None = None
    seconds: float | None = None
    step: str | None = None


MOTION_OPTIONS = (
    click.option(
        "--motion",
        metavar="KIND",
        help="Nothing holds the crank's speed: free, without a torque that drives it, or torque, with its torques.",
    ),
    click.option("--seconds", type=float, metavar="S", help="Of --motion: how long [10]."),
    click.option("--step", metavar="TIME", help="Of --motion: the engines' time step, e.g. 2ms [5 ms or less]."),
)
of_a_motion = bundled("motion", MotionOptions, MOTION_OPTIONS)


@dataclass(frozen=True)
class TableOptions:
    """What was given; None or empty where nothing was."""

    columns: tuple[str, ...] = field(default=(), metadata={"option": "--column"})
    units: tuple[str, ...] = field(default=(), metadata={"option": "--unit"})
    estimate: str | None = None


TABLE_OPTIONS = (
    click.option(
        "--column", "columns", multiple=True, metavar="Q=NAME", help="Of a table: which column is what, e.g. C.x=px."
    ),
    click.option(
        "--unit", "units", multiple=True, metavar="UNIT | Q=UNIT", help="Of a table: units that no heading gives."
    ),
    click.option(
        "--estimate",
        metavar="WHAT,...",
        help="Of a table: what is unknown and to be worked out, of time, phase, sense and frame.",
    ),
)
of_a_table = bundled("table", TableOptions, TABLE_OPTIONS)
