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
