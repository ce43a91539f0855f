"""Verbs and their options: fields of a dataclass for each verb, of which some stand in several."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from conrod.cli import say
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.engines import Engine
    from conrod.studies.execution.local import LocalProcesses, RepeatingExecutor

CELL_TIMEOUT = 600.0  # [s]
MOST_MEMORY = 2.0**60  # bytes, that a process can be limited to
OPTIONS, RUNS = "Options", "Runs and ledger"  # headings
# What is written does not say by which command it is found again.
FILES = ("out", "document", "html", "baseline", "accept", "report", "measured", "limits", "uncertainties", "model")


class Option(click.Option):
    """An option under a heading."""

    def __init__(self, *arguments: Any, heading: str = OPTIONS, **attributes: Any) -> None:
        super().__init__(*arguments, **attributes)
        self.heading = heading


class Verb(click.Command):
    """A command whose help has options under their headings."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        headings: dict[str, list[tuple[str, str]]] = {OPTIONS: []}
        for one in self.get_params(ctx):
            if isinstance(one, click.Option) and (record := one.get_help_record(ctx)):
                headings.setdefault(getattr(one, "heading", OPTIONS), []).append(record)
        for heading, records in headings.items():
            with formatter.section(heading):
                formatter.write_dl(records)


# -- options that mean the same in every verb --------------------------------------------------------------------------

SHARED: Mapping[str, Mapping[str, Any]] = {
    "--out": {"metavar": "DIR", "help": "Write the report there."},
    "--json": {"metavar": "FILE", "help": "Write the results as JSON."},
    "--html": {"metavar": "FILE", "help": "Write the report as one HTML file."},
    "--engine": {"multiple": True, "metavar": "ENGINE", "help": "This engine only, again for others; or all."},
    "--preset": {"metavar": "PRESET", "help": "One preset only; `conrod engines` lists them."},
    "--set": {"multiple": True, "metavar": "NAME=VALUE", "help": "Override a parameter, e.g. --set crank=80mm."},
    "--ctrl": {"multiple": True, "metavar": "NAME=VALUE", "help": "Control of an actuator [the keyframe's]."},
    "--ledger": {"metavar": "FILE", "help": "Where finished runs are kept [in the cache folder]."},
}
assignments = click.option("--set", "assignments", **SHARED["--set"])
ledger = click.option("--ledger", **SHARED["--ledger"])
out = click.option("--out", **SHARED["--out"])
document = click.option("--json", "document", **SHARED["--json"])
html = click.option("--html", **SHARED["--html"])


def option(name: str, heading: str = OPTIONS, **attributes: Any) -> Any:
    """A field that is an option, by its names, attributes as of `click.option`; None or empty where not given."""
    attributes = {**SHARED.get(name, {}), **attributes}
    empty: Any = () if attributes.get("multiple") else False if attributes.get("is_flag") else None
    return field(default=attributes.get("default", empty), metadata={"option": name, "heading": heading, **attributes})


def verb(kind: type[Any] | None = None, **attributes: Any) -> Callable[[Callable[..., Any]], click.Command]:
    """A decorator that makes a command.

    Args:
        kind: a dataclass whose fields are options; the function gets their values as one, `asked`.
        attributes: of the command.
    """
    # A verb's own before those that it has from others.
    fields = sorted(dataclasses.fields(kind), key=lambda one: one.name not in kind.__annotations__) if kind else []

    def made(function: Callable[..., Any]) -> click.Command:
        @wraps(function)
        def called(**values: Any) -> Any:
            if kind is None:
                return function(**values)
            asked = {one.name: values.pop(one.name) for one in fields if one.name in values}
            return function(asked=kind(**asked), **values)

        decorated: Any = called
        for one in reversed([one for one in fields if one.metadata]):
            given = dict(one.metadata)
            decorated = click.option(*given.pop("option").split(), one.name, cls=Option, **given)(decorated)
        return click.command(cls=Verb, **attributes)(decorated)

    return made


def refuse(asked: Any, subject: str, *which: str) -> None:
    """Refuse options that do not go with something.

    Args:
        asked: the values of options.
        subject: what they do not go with, for the message: "a scene".
        which: fields by name, or all under a heading.

    Raises:
        InvalidInput: names the first option that was given.
    """
    for one in dataclasses.fields(asked):
        if {one.name, one.metadata.get("heading")} & {*which} and getattr(asked, one.name) != one.default:
            raise InvalidInput(f"{one.metadata['option']} does not go with {subject}")


def refuse_others(asked: Any, subject: str, *taken: str) -> None:
    """Refuse all options but some; raises InvalidInput, which names what is taken."""
    if other := next((name for name in as_given(asked) if name not in taken), None):
        raise InvalidInput(
            f"{other} does not go with {subject}, which takes {', '.join(one for one in taken if one != subject)}"
        )


def as_given(asked: Any, *left_out: str) -> dict[str, Any]:
    """Values of options that were given, by the options' names, but for fields and headings that are left out."""
    return {
        one.metadata["option"]: value
        for one in dataclasses.fields(asked)
        if one.metadata and not {one.name, one.metadata["heading"]} & {*left_out}
        if (value := getattr(asked, one.name)) != one.default
    }


def chosen_engines(names: tuple[str, ...]) -> list[Engine[Any]]:
    """The engines that --engine names; one line on each that nobody named and that cannot be loaded.

    Raises:
        InvalidInput: there is no such engine, or it cannot be loaded.
    """
    from conrod.studies.frame.resolve_arguments import select_engines

    return select_engines(names, left_out=lambda reason: say(f"conrod: left out: {reason}", err=True))


@dataclass(frozen=True)
class RunOptions:
    """Options on how runs are made and where they are kept; None where nothing was given."""

    ledger: str | None = option("--ledger", RUNS)
    fresh: bool = option("--fresh", RUNS, is_flag=True, help="Do again what the ledger has.")
    jobs: int | None = option("--jobs", RUNS, type=int, metavar="N", help="Runs at a time here [one a core].")
    cluster: str | None = option("--cluster", RUNS, metavar="ADDRESS", help="Run on Dask, e.g. tcp://host:8786.")
    cell_timeout: float | None = option(
        "--cell-timeout", RUNS, type=float, metavar="SECONDS", help="Longest run [600 s]."
    )
    cell_memory: str | None = option("--cell-memory", RUNS, metavar="SIZE", help="Largest run, e.g. 4GB [any].")

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

    def processes(self, jobs: int | None = None, interpreter: str | None = None) -> LocalProcesses:
        """Processes of this machine, as many as were asked for unless a number is given."""
        from conrod.studies.execution.local import LocalProcesses

        jobs = jobs or (available_cores() if self.jobs is None else self.jobs)
        return LocalProcesses(jobs, cell_timeout=self.timeout, cell_memory=self.memory, interpreter=interpreter)

    def executor(self) -> RepeatingExecutor:
        """Executor of the runs: a cluster, or processes of this machine.

        Raises:
            InvalidInput: options that exclude each other.
        """
        if self.cluster is None:
            return self.processes()
        if self.jobs is not None:
            raise InvalidInput("--jobs does not go with --cluster: the cluster has as many as it has workers")
        from conrod.studies.execution.cluster import DaskCluster

        return DaskCluster(self.cluster, cell_timeout=self.timeout, cell_memory=self.memory)


def available_cores() -> int:
    """Cores that this process may use, as far as the system says."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class ReportOptions:
    """Options of a verb that reports; None where nothing was given."""

    out: str | None = option("--out")
    document: str | None = option("--json")
    html: str | None = option("--html")


@dataclass(frozen=True)
class StudyOptions(ReportOptions, RunOptions):
    """Options of a verb that studies engines on scenes."""

    engine: tuple[str, ...] = option("--engine")
    assignments: tuple[str, ...] = option("--set")
