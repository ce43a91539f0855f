"""Options that commands share, options of one purpose as fields of one dataclass, and exit statuses."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import click

from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.studies.execution.local import LocalProcesses, RepeatingExecutor

FAILED, USAGE, INTERRUPTED = 1, 2, 130

CELL_TIMEOUT = 600.0  # [s]
DEFAULT_GRID = "default"
Command = TypeVar("Command", bound=Callable[..., Any])

assignments = click.option(
    "--set", "assignments", multiple=True, metavar="NAME=VALUE", help="Override a parameter, e.g. --set crank=80mm."
)
engine = click.option("--engine", metavar="ENGINE", help="One engine only; `conrod show` lists them.")
grid = click.option("--grid", default=DEFAULT_GRID, show_default=True, metavar="GRID", help="coarse, default or fine.")
LEDGER = "Where finished runs are kept [a file in the user's cache folder]."
ledger = click.option("--ledger", metavar="FILE", help=LEDGER)


def option(name: str, **attributes: Any) -> Any:
    """A field that is an option, with attributes as of `click.option`; None where it is not given, or empty."""
    default: Any = () if attributes.get("multiple") else False if attributes.get("is_flag") else None
    return field(default=default, metadata={"option": name, **attributes})


def gathered(name: str, kind: type[Any]) -> Callable[[Command], Command]:
    """A decorator that adds options to a command, which gets their values as one object.

    Args:
        name: of the command's argument.
        kind: a dataclass, each `option` of which is one.
    """
    fields = dataclasses.fields(kind)

    def decorate(command: Command) -> Command:
        @wraps(command)
        def called(**values: Any) -> Any:
            own = {one.name: values.pop(one.name) for one in fields if one.name in values}
            return command(**{name: kind(**own)}, **values)

        decorated: Any = called
        for one in reversed(fields):
            if one.metadata:
                attributes = dict(one.metadata)
                decorated = click.option(attributes.pop("option"), one.name, **attributes)(decorated)
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

    heading: ClassVar[str] = "Runs and the ledger that keeps them"

    ledger: str | None = option("--ledger", metavar="FILE", help=LEDGER)
    fresh: bool = option("--fresh", is_flag=True, help="Do again what the ledger has.")
    jobs: int | None = option("--jobs", type=int, metavar="N", help="Runs at a time on this machine [one a core].")
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
    def timed_again(self) -> bool:
        """Whether costs are measured that the ledger has."""
        return self.fresh

    @property
    def timeout(self) -> float:
        """Longest time of a cell [s]."""
        return CELL_TIMEOUT if self.cell_timeout is None else self.cell_timeout

    @property
    def memory(self) -> int | None:
        """Most memory of a cell [bytes]."""
        from conrod.mechanism.units import parse_quantity

        return None if self.cell_memory is None else round(parse_quantity("--cell-memory", self.cell_memory, "byte"))

    @property
    def ledger_file(self) -> Path:
        """The ledger that was named, or the user's own."""
        from conrod.studies.frame.ledger import default_path

        return default_path() if self.ledger is None else Path(self.ledger)

    def executor(self) -> RepeatingExecutor:
        """Executor of the runs: a cluster, or processes of this machine."""
        if self.cluster is None:
            return self.processes()
        from conrod.studies.execution.cluster import DaskCluster

        return DaskCluster(self.cluster, cell_timeout=self.timeout, cell_memory=self.memory)

    def processes(self, jobs: int | None = None) -> LocalProcesses:
        """Processes of this machine, as many as were asked for unless a number is given."""
        from conrod.studies.execution.local import LocalProcesses

        jobs = self.jobs if jobs is None else jobs
        return LocalProcesses(
            available_cores() if jobs is None else jobs, cell_timeout=self.timeout, cell_memory=self.memory
        )


def available_cores() -> int:
    """Cores that this process may use, as far as the system says."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


of_runs = gathered("how", RunOptions)


@dataclass(frozen=True)
class TimedRunOptions(RunOptions):
    """Options on how runs are made and timed."""

    retime: bool = option("--retime", is_flag=True, help="Time again what the ledger has, without running it again.")

    @property
    def timed_again(self) -> bool:
        return self.fresh or self.retime


of_timed_runs = gathered("how", TimedRunOptions)


# -- conrod validate ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class MotionOptions:
    """A motion that no drive prescribes; None where nothing was given."""

    heading: ClassVar[str] = "Motion without a prescribed crank (--motion)"

    motion: str | None = option(
        "--motion",
        metavar="KIND",
        help="Nothing holds the crank's speed: free, without a torque that drives it, or torque, with its torques.",
    )
    seconds: float | None = option("--seconds", type=float, metavar="S", help="Length of the run [10].")
    step: str | None = option("--step", metavar="TIME", help="Time step of the engines, e.g. 2ms [5 ms or less].")


@dataclass(frozen=True)
class TableOptions:
    """Options on the columns and units of a table of any tool; None or empty where nothing was given."""

    heading: ClassVar[str] = "A table that another tool wrote (FILE.csv and the like)"

    columns: tuple[str, ...] = option("--column", multiple=True, metavar="Q=NAME", help="Column of a quantity, C.x=px.")
    units: tuple[str, ...] = option(
        "--unit", multiple=True, metavar="UNIT | Q=UNIT", help="Unit that no heading gives."
    )
    estimate: str | None = option(
        "--estimate", metavar="WHAT,...", help="What is unknown and to be estimated: time, phase, sense, frame."
    )


@dataclass(frozen=True)
class ModelOptions:
    """Options on the joints, points and frame of a user's own model; None or empty where nothing was given."""

    heading: ClassVar[str] = "A MuJoCo model (FILE.xml and the like)"

    crank: str | None = option("--crank", metavar="JOINT", help="The hinge that is driven.")
    points: tuple[str, ...] = option(
        "--point",
        multiple=True,
        metavar="NAME=site:SITE",
        help="Place of an observed point (site:, body: or geom:); may be given again.",
    )
    plane: str | None = option("--plane", metavar="PLANE", help="Directions right and up, e.g. xz or -xz [found].")
    rotation: str | None = option("--rotation", metavar="ANGLE", help="Of the scene's x axis in the plane [found].")
    crank_zero: str | None = option(
        "--crank-zero", metavar="ANGLE", help="Angle of the hinge at crank angle 0 [found]."
    )
    length_unit: str | None = option("--length-unit", metavar="UNIT", help="m, cm, mm or inch [found].")
    keyframe: str | None = option("--keyframe", metavar="NAME", help="Assemble it from there [its reference pose].")
    touching: str | None = option("--touching", metavar="CAM,ROLLER", help="Geoms of its cam contact [found].")


@dataclass(frozen=True)
class Request(TableOptions, ModelOptions, MotionOptions, RunOptions):
    """Request to `conrod validate`, as typed; None or empty where nothing was given.

    Attributes:
        subjects: scenes, or one file.
        document: the file that --json names.
    """

    heading: ClassVar[str] = "Options"

    subjects: tuple[str, ...] = ()
    scene: str | None = option(
        "--scene", metavar="SCENE", help="What a FILE is to be: the machine it is judged against."
    )
    engine: str | None = option("--engine", metavar="ENGINE", help="One engine only; `conrod show` lists them.")
    preset: str | None = option("--preset", metavar="PRESET", help="One preset only; `conrod show` lists them.")
    quantity: str | None = option(
        "--quantity", metavar="NAME,...", help="Forces in place of motion: torque, reactions, contact."
    )
    steps_per_rev: int | None = option(
        "--steps-per-rev", type=int, metavar="N", help="Time steps a revolution [1000; for contact 62832]."
    )
    revolutions: int | None = option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
    assignments: tuple[str, ...] = option(
        "--set", multiple=True, metavar="NAME=VALUE", help="Override a parameter, e.g. --set crank=80mm."
    )
    figures: str | None = option(
        "--figures",
        metavar="NAME,...",
        help="Figures of the report: mechanism, motion, error, order [all; of the catalogue mechanism,error].",
    )
    tolerance: str | None = option(
        "--tolerance", metavar="Q=T,...", help="Judge every preset by these, e.g. position=1e-4,velocity=1e-3."
    )
    out: str | None = option("--out", metavar="DIR", help="Write the report there.")
    document: str | None = option("--json", metavar="FILE", help="Write the results as JSON.")

    @property
    def given(self) -> dict[str, object]:
        """What was given of all that the result follows from, by the options' names."""
        return as_given(self, RunOptions, "assignments", "out", "document")


class HeadedCommand(click.Command):
    """`conrod validate`, whose help has options under the headings of their classes."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        kinds: list[Any] = [kind for kind in Request.__mro__ if dataclasses.is_dataclass(kind)]
        home = {one.name: kind.heading for kind in kinds for one in dataclasses.fields(kind)}
        headings: dict[str, list[tuple[str, str]]] = {Request.heading: []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                headings.setdefault(home.get(str(parameter.name), Request.heading), []).append(record)
        for heading, records in headings.items():
            with formatter.section(heading):
                formatter.write_dl(records)
