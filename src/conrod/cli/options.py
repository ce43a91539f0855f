"""Options that commands share, options of one purpose as one object, and exit statuses."""

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


class Headed(click.Option):
    """An option that stands under a heading of its own in the help."""

    def __init__(self, *names: Any, heading: str, **attributes: Any) -> None:
        super().__init__(*names, **attributes)
        self.heading = heading


class HeadedCommand(click.Command):
    """A command whose help has options under headings."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        headings: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                headings.setdefault(getattr(parameter, "heading", "Options"), []).append(record)
        for heading, records in headings.items():
            with formatter.section(heading):
                formatter.write_dl(records)


def headed(heading: str, *names: str, **attributes: Any) -> Callable[[Any], Any]:
    """As `click.option`, under a heading."""
    return click.option(*names, cls=Headed, heading=heading, **attributes)


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

KEPT = "Runs and the ledger that keeps them"
RUNS = (
    headed(KEPT, "--ledger", metavar="FILE", help="Where finished runs are kept [a file in the user's cache folder]."),
    headed(KEPT, "--fresh", is_flag=True, help="Do again what the ledger has."),
    headed(KEPT, "--jobs", type=int, metavar="N", help="Runs at a time on this machine [one a core]."),
    headed(KEPT, "--cluster", metavar="ADDRESS", help="Run on a Dask cluster instead, e.g. tcp://host:8786."),
    headed(KEPT, "--cell-timeout", type=float, metavar="SECONDS", help="End a run that takes longer [600]."),
    headed(KEPT, "--cell-memory", metavar="SIZE", help="End a run that needs more, e.g. 4GB [no limit]."),
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
    unused = as_typed(type(bundle)())
    for option, value in as_typed(bundle).items():
        if value != unused[option]:
            raise InvalidInput(f"{option} does not go with {subject}")


def as_typed(bundle: Any) -> dict[str, Any]:
    """Values of the options of a purpose, by what a user types."""
    named = ((f.metadata.get("option", "--" + f.name.replace("_", "-")), f.name) for f in dataclasses.fields(bundle))
    return {option: getattr(bundle, name) for option, name in named}


@dataclass(frozen=True)
class RunOptions:
    """Options on how runs are made and where they are kept; None where nothing was given."""

    ledger: str | None = None
    fresh: bool = False
    jobs: int | None = None
    cluster: str | None = None
    cell_timeout: float | None = None
    cell_memory: str | None = None


of_runs = bundled("how", RunOptions, RUNS)


@dataclass(frozen=True)
class TimedRunOptions(RunOptions):
    """Options on how runs are made and timed."""

    retime: bool = False


of_timed_runs = bundled("how", TimedRunOptions, (*RUNS, retime))


@dataclass(frozen=True)
class MotionOptions:
    """A motion that no drive prescribes; None where nothing was given."""

    motion: str | None = None
    seconds: float | None = None
    step: str | None = None


MOTION = "Motion without a prescribed crank (--motion)"
FREE = "Nothing holds the crank's speed: free, without a torque that drives it, or torque, with its torques."
of_a_motion = bundled(
    "motion",
    MotionOptions,
    (
        headed(MOTION, "--motion", metavar="KIND", help=FREE),
        headed(MOTION, "--seconds", type=float, metavar="S", help="Length of the run [10]."),
        headed(MOTION, "--step", metavar="TIME", help="Time step of the engines, e.g. 2ms [5 ms or less]."),
    ),
)


@dataclass(frozen=True)
class TableOptions:
    """Options on the columns and units of a table of any tool; None or empty where nothing was given."""

    columns: tuple[str, ...] = field(default=(), metadata={"option": "--column"})
    units: tuple[str, ...] = field(default=(), metadata={"option": "--unit"})
    estimate: str | None = None


TABLE = "A table that another tool wrote (FILE.csv and the like)"
UNITS = "Unit that no heading gives."
UNKNOWN = "What is unknown and to be estimated: time, phase, sense, frame."
of_a_table = bundled(
    "table",
    TableOptions,
    (
        headed(TABLE, "--column", "columns", multiple=True, metavar="Q=NAME", help="Column of a quantity, C.x=px."),
        headed(TABLE, "--unit", "units", multiple=True, metavar="UNIT | Q=UNIT", help=UNITS),
        headed(TABLE, "--estimate", metavar="WHAT,...", help=UNKNOWN),
    ),
)


@dataclass(frozen=True)
class ModelOptions:
    """Options on the joints, points and frame of a user's own model; None or empty where nothing was given."""

    crank: str | None = None
    points: tuple[str, ...] = field(default=(), metadata={"option": "--point"})
    plane: str | None = None
    rotation: str | None = None
    crank_zero: str | None = None
    length_unit: str | None = None
    keyframe: str | None = None
    touching: str | None = None


MODEL = "A MuJoCo model (FILE.xml and the like)"
PLACE = "Place of an observed point (site:, body: or geom:); may be given again."
of_a_model = bundled(
    "model",
    ModelOptions,
    (
        headed(MODEL, "--crank", metavar="JOINT", help="The hinge that is driven."),
        headed(MODEL, "--point", "points", multiple=True, metavar="NAME=site:SITE", help=PLACE),
        headed(MODEL, "--plane", metavar="PLANE", help="Directions right and up, e.g. xz or -xz [found]."),
        headed(MODEL, "--rotation", metavar="ANGLE", help="Of the scene's x axis in the plane [found]."),
        headed(MODEL, "--crank-zero", metavar="ANGLE", help="Angle of the hinge at crank angle 0 [found]."),
        headed(MODEL, "--length-unit", metavar="UNIT", help="m, cm, mm or inch [found]."),
        headed(MODEL, "--keyframe", metavar="NAME", help="Assemble it from there [its reference pose]."),
        headed(MODEL, "--touching", metavar="CAM,ROLLER", help="Geoms of its cam contact [found]."),
    ),
)


@dataclass(frozen=True)
class Request:
    """Request to `conrod validate`, as typed; None or empty where nothing was given.

    Attributes:
        subjects: scenes, or one file.
        scene: that a file is judged against.
        document: the file that --json names.
    """

    subjects: tuple[str, ...]
    scene: str | None
    engine: str | None
    preset: str | None
    steps_per_rev: int | None
    revolutions: int | None
    assignments: tuple[str, ...]
    tolerance: str | None
    out: str | None
    document: str | None
    figures: str | None
    quantity: str | None
    how: RunOptions
    motion: MotionOptions
    model: ModelOptions
    table: TableOptions
