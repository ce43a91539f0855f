"""Verbs and their options: fields of a dataclass for each verb, of which some stand in several."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, wraps
from pathlib import Path
from typing import Any, TypeVar

import click

from conrod.cli import completion, model_completion
from conrod.cli.completion import TYPED
from conrod.errors import InvalidInput
from conrod.slices import has_slice

RUN_TIMEOUT = 600.0  # [s]
MAX_PROCESS_MEMORY = 2.0**60  # [bytes]; the largest --cell-memory
OPTIONS, OUTPUT, RUNS = "Options", "Output", "Runs and ledger"  # headings
# Fields of options that the command printed in a report leaves out: what the report says does not depend on them.
FILE_FIELDS = (
    "out", "document", "html", "baseline", "accept", "verification", "title", "measured", "limits", "uncertainties",
    "model",
)  # fmt: skip


class Option(click.Option):
    """An option under a heading."""

    def __init__(self, *arguments: Any, heading: str = OPTIONS, **attributes: Any) -> None:
        super().__init__(*arguments, **attributes)
        self.heading = heading


class Verb(click.Command):
    """A command whose help has options under their headings, and fits on a screen."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.meta[TYPED] = list(args)
        typed = list(args)
        try:
            rest = super().parse_args(ctx, args)
        except click.UsageError as error:
            refuse_old_spelling(ctx)
            from conrod.cli.usage_errors import usage_error

            raise usage_error(ctx, error) from None
        if not ctx.resilient_parsing:
            self._refuse_repeats(ctx, typed)
        return rest

    def _refuse_repeats(self, ctx: click.Context, typed: list[str]) -> None:
        """Refuse an option of one value that is given twice; click would take the last value silently."""
        *_, order = self.make_parser(ctx).parse_args(args=typed.copy())
        given = [one for one in order if isinstance(one, click.Option)]
        for one in dict.fromkeys(given):
            if given.count(one) > 1 and not (one.multiple or one.is_flag or one.count):
                from conrod.cli.usage_errors import refuse_other_values

                refuse_other_values(one, typed)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        headings: dict[str, list[tuple[str, str]]] = {OPTIONS: []}
        for one in self.get_params(ctx):
            if isinstance(one, click.Option) and (record := one.get_help_record(ctx)):
                headings.setdefault(getattr(one, "heading", OPTIONS), []).append(record)
        names = max(len(name) for records in headings.values() for name, _ in records)
        formatter.write("\n")
        for heading, records in headings.items():
            # Without the empty line that `section` puts before each.
            formatter.write_heading(heading)
            formatter.indent()
            # The names of all sections are as wide, so that the texts stand in one column.
            formatter.write_dl([(f"{name:{names}}", text) for name, text in records], col_max=names + 2, col_spacing=1)
            formatter.dedent()


def refuse_old_spelling(context: click.Context) -> None:
    """Refuse a command line of an earlier version; InvalidInput names the one to type today."""
    from conrod.cli.moved import new_spelling

    if moved := new_spelling([str(context.info_name), *context.meta[TYPED]]):
        raise InvalidInput(moved)


# -- options that mean the same in every verb --------------------------------------------------------------------------

SHARED: Mapping[str, Mapping[str, Any]] = {
    "--out": {"metavar": "DIR", "help": "Write the report there."},
    "--json": {"metavar": "FILE", "help": "Write the results as JSON."},
    "--html": {"metavar": "FILE", "help": "Write the report as one HTML file."},
    "--engine": {
        "multiple": True,
        "metavar": "ENGINE",
        "help": "This engine only, again for others; or all.",
        "shell_complete": completion.engines,
    },
    "--preset": {
        "metavar": "PRESET",
        "help": "One preset only; `conrod engines` lists them.",
        "shell_complete": completion.presets,
    },
    "--set": {
        "multiple": True,
        "metavar": "NAME=VALUE",
        "help": "Override a parameter, e.g. --set crank=80mm.",
        "shell_complete": model_completion.parameters,
    },
    "--ctrl": {
        "multiple": True,
        "metavar": "NAME=VALUE",
        "help": "Control of an actuator [the keyframe's].",
        "shell_complete": partial(model_completion.names, kinds=("actuator",), ending="="),
    },
    "--keyframe": {
        "metavar": "KEY",
        "help": "Start from it, by name or number; qpos0 for none.",
        "shell_complete": partial(model_completion.names, kinds=("key",), more=("qpos0",)),
    },
    "--ledger": {"metavar": "FILE", "help": "Where finished runs are kept [in the cache folder]."},
}
FINDINGS_HELP = "Results as JSON, JUnit (.xml) or SARIF (.sarif)."
FAMILY_HELP = "Override a parameter, e.g. crank=80mm; crank=80mm,90mm is a family."
assignments = click.option("--set", "assignments", **SHARED["--set"])
ledger = click.option("--ledger", **SHARED["--ledger"])
out = click.option("--out", **SHARED["--out"])
document = click.option("--json", "document", **SHARED["--json"])
html = click.option("--html", **SHARED["--html"])


PROJECT_FILE = "pyproject.toml"


def project_file() -> Path | None:
    """Find the nearest pyproject.toml here or above; None if it has no settings of conrod, which are not read then."""
    here = Path.cwd()
    file = next((place / PROJECT_FILE for place in (here, *here.parents) if (place / PROJECT_FILE).is_file()), None)
    return file if file and re.search(rb"tool\W+conrod|\[\s*tool\s*\]", file.read_bytes()) else None


def option(name: str, heading: str = OPTIONS, **attributes: Any) -> Any:
    """Declare a dataclass field that is an option, None or empty where not given."""
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

    def decorate(function: Callable[..., Any]) -> click.Command:
        @wraps(function)
        def call_with_options(**values: Any) -> Any:
            if kind is None:
                return function(**values)
            asked = {one.name: values.pop(one.name) for one in fields if one.name in values}
            return function(asked=kind(**asked), **values)

        decorated: Any = call_with_options
        for one in reversed([one for one in fields if one.metadata]):
            given = dict(one.metadata)
            decorated = click.option(*given.pop("option").split(), one.name, cls=Option, **given)(decorated)
        return click.command(cls=Verb, **attributes)(decorated)

    return decorate


def refuse(asked: Any, subject: str, *which: str) -> None:
    """Refuse options that do not go with something.

    Args:
        asked: the values of options.
        subject: what the options do not go with, for the message: "a scene".
        which: fields by name, or all under a heading.

    Raises:
        InvalidInput: names the first option that was given.
    """
    for one in dataclasses.fields(asked):
        if {one.name, one.metadata.get("heading")} & {*which} and getattr(asked, one.name) != one.default:
            raise InvalidInput(f"{one.metadata['option']} does not go with {subject}")


def refuse_others(asked: Any, subject: str, *taken: str) -> None:
    """Refuse all options except those taken; raises InvalidInput, which names these."""
    if other := next((name for name in explicit_options(asked) if name not in taken), None):
        raise InvalidInput(
            f"{other} does not go with {subject}, which takes {', '.join(one for one in taken if one != subject)}"
        )


def compares_engines(asked: Any, folder: str) -> bool:
    """Return True if engines are to be compared: others than MuJoCo by itself, or settings of it, are named.

    Args:
        folder: the slice that compares them; this conrod may have none.
    """
    settings = (asked.preset, asked.steps_per_rev, asked.revolutions)
    other = asked.engine != ("mujoco",) or any(one is not None for one in settings)
    return bool(asked.engine) and other and has_slice(folder)


def explicit_options(asked: Any, *left_out: str) -> dict[str, Any]:
    """Return the values of the options that the user gave, by option name.

    Args:
        left_out: names of fields, and headings, whose options are left out.
    """
    return {
        one.metadata["option"]: value
        for one in dataclasses.fields(asked)
        if one.metadata and not {one.name, one.metadata["heading"]} & {*left_out}
        if (value := getattr(asked, one.name)) != one.default
    }


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
        """Longest time of a run [s]."""
        return RUN_TIMEOUT if self.cell_timeout is None else self.cell_timeout

    @property
    def memory(self) -> int | None:
        """Most memory of a run [bytes]."""
        from conrod.mechanism.units import check_number, parse_quantity

        if self.cell_memory is None:
            return None
        memory = parse_quantity("--cell-memory", self.cell_memory, "byte")
        check_number("--cell-memory", memory, 0.0, MAX_PROCESS_MEMORY, "byte")
        return round(memory)

    @property
    def ledger_file(self) -> Path:
        """The ledger that was named, or the user's own."""
        from conrod.execution.ledger import default_ledger_path

        return default_ledger_path() if self.ledger is None else Path(self.ledger)


@dataclass(frozen=True)
class ReportOptions:
    """Options of a verb that reports; None where nothing was given."""

    out: str | None = option("--out", OUTPUT)
    document: str | None = option("--json", OUTPUT, help=FINDINGS_HELP)
    html: str | None = option("--html", OUTPUT)


@dataclass(frozen=True)
class StudyOptions(ReportOptions, RunOptions):
    """Options of a verb that studies engines on scenes."""

    engine: tuple[str, ...] = option("--engine")
    assignments: tuple[str, ...] = option("--set")


@dataclass(frozen=True)
class JudgedOptions(ReportOptions):
    """Options of a verb that judges something, and may compare it with a baseline."""

    tolerance: str | None = option(
        "--tolerance", metavar="Q=T,...", help="Largest errors, e.g. position=0.1mm or 1e-4L."
    )
    baseline: str | None = option("--baseline", OUTPUT, metavar="FILE", help="Compare with FILE; written if none.")
    accept: bool = option("--accept", OUTPUT, is_flag=True, help="Write the baseline again, as it is now.")


@dataclass(frozen=True)
class VerificationOptions(JudgedOptions):
    """Options of a verb that can write a verification report."""

    verification: str | None = option(
        "--verification", OUTPUT, metavar="FILE", help="Write a report to sign, named by --title TEXT."
    )
    # Named in the line above, which leaves the help on one screen.
    title: str | None = option("--title", OUTPUT, metavar="TEXT", hidden=True, help="Title of the report.")
    measured: str | None = option(
        "--measured", OUTPUT, metavar="TABLE", help="Measurements of the machine, for --verification."
    )
    limits: str | None = option(
        "--limits", OUTPUT, metavar="DIR", help="Results of `conrod limits`, for --verification."
    )
    uncertainties: tuple[str, ...] = option(
        "--uncertainty",
        OUTPUT,
        multiple=True,
        metavar="NAME=SIZE",
        help="Standard uncertainty of a length or `measured`.",
    )
    columns: tuple[str, ...] = option(
        "--column", multiple=True, metavar="Q=NAME", help="Heading of the column of quantity Q, e.g. C.x=px."
    )
    units: tuple[str, ...] = option(
        "--unit", multiple=True, metavar="UNIT", help="Of columns without one, or of a model's lengths."
    )
    estimate: str | None = option("--estimate", metavar="WHAT,...", help="Unknowns to estimate first: time, phase.")


# -- values that a user typed ------------------------------------------------------------------------------------------


def names_in(text: str | None) -> tuple[str, ...] | None:
    """Split names at commas; None where nothing was given."""
    return None if text is None else tuple(name.strip() for name in text.split(","))


def tolerance_in(text: str | None, known: Collection[str]) -> dict[str, float | str] | None:
    """Parse tolerances, as in `position=1e-4,velocity=1mm/s`; None where nothing was given.

    Args:
        known: quantities that may be judged, normalised; or with their units, in SI.

    Returns:
        Numbers by quantity, and texts where they have a unit or need one, for `check_tolerance`.

    Raises:
        InvalidInput: an unknown quantity, or a value that is no tolerance.
    """
    from conrod.errors import named_values
    from conrod.execution.tolerances import check_tolerance

    if text is None:
        return None
    given = named_values(text.split(","), "--tolerance", kind="quantity", known=known)
    check_tolerance(given, known)
    return {name: number_or_text(value) for name, value in given.items()}


Text = TypeVar("Text", str, str | None)


def number_or_text(text: Text) -> float | Text:
    """A plain number as a number; any other text, such as a size with a unit, and None as they are."""
    from conrod.mechanism.units import NUMBER

    return float(text) if text is not None and NUMBER.fullmatch(text.strip()) else text


def controls_in(texts: Iterable[str]) -> dict[str, float]:
    """Parse control inputs, as in `motor=4.19`.

    Raises:
        InvalidInput: a text is not NAME=VALUE, or a name is given twice.
    """
    from conrod.errors import named_values
    from conrod.mjcf.request import CONTROL_FORM

    controls = dict[str, float]()
    for name, text in named_values(texts, "--ctrl", CONTROL_FORM).items():
        try:
            controls[name] = float(text)
        except ValueError:
            raise InvalidInput(f"--ctrl '{name}={text}': give {CONTROL_FORM}") from None
    return controls


def columns_in(texts: Iterable[str], points: Sequence[str], links: Sequence[str] = ()) -> dict[str, str]:
    """Parse columns by quantity, as in `C.x=px`.

    Raises:
        InvalidInput: a text is not QUANTITY=COLUMN, or its quantity is unknown or given twice.
    """
    from conrod.errors import named_values
    from conrod.models.tables.columns import quantities

    form = "QUANTITY=..., e.g. --column time=t"
    return named_values(texts, "--column", form, "quantity", quantities(points, links))
