"""What a verb shows: progress of its runs and findings, printed and written to a folder, a page and a document."""

from __future__ import annotations

import shlex
import sys
import time
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, Generic, Self

from rich.console import Console
from rich.text import Text

from conrod.cli import FAILED, say
from conrod.cli.options import FILE_FIELDS, RUNS, ReportOptions, RunOptions, explicit_options
from conrod.comparison.trajectory import Outcome
from conrod.execution.case import Case
from conrod.execution.runner import Runs, Watcher
from conrod.report.findings import Findings
from conrod.report.kind import SCENE, F, Kind, Reproduction
from conrod.report.numbers import in_shown_unit, quantity
from conrod.report.terminal import console as standard_console
from conrod.report.terminal import print_parts

if TYPE_CHECKING:
    from rich.progress import Progress

    from conrod.report.folder import ReportFolder
    from conrod.scenes import Scene

DOUBT = "cannot be trusted"  # in the line that says so of a scene
MAX_NAMED_MACHINES = 6
UNDRIVEN = "motion"  # kind of report on machines whose speed nothing keeps
# Rates are taken over this many seconds: cases of one sweep differ a thousandfold.
SPEED_PERIOD = 120.0


@dataclass(frozen=True)
class Outputs(Generic[F]):
    """Files that --out, --json and --html name.

    Attributes:
        kind: kind of the report.
        asked: options of the verb.
        folder, file, html: their paths; None for options that were not given.
    """

    kind: Kind[F]
    asked: ReportOptions
    folder: Path | None = None
    file: Path | None = None
    html: Path | None = None

    def print_and_write(
        self,
        found: Findings[F],
        command: str,
        subjects: Sequence[str] | Mapping[str, str],
        given: Mapping[str, object] = MappingProxyType({}),
        machines: Mapping[str, Scene] = MappingProxyType({}),
    ) -> None:
        """Print findings, then write all files or none, and print where the report is.

        Args:
            command: verb that makes the report, which the report states.
            subjects: scenes as they were typed, or files by the names of their pages.
            given: further options of the command, by name; None for options that were not given.
            machines: scenes by name, which the first line names with their speed.
        """
        parts = list(self.kind.printed(list(found.values())))
        # That figures cannot be trusted is said before anything else.
        doubts = list(takewhile(lambda part: isinstance(part, Text) and DOUBT in part.plain.lower(), parts))
        changed = [one.partition("=")[0].strip() for one in getattr(self.asked, "assignments", ())]
        print_parts(
            [*doubts, *machine_lines(machines, changed, driven=self.kind.name != UNDRIVEN), *parts[len(doubts) :]]
        )
        if not (self.folder or self.file or self.html):
            return
        from conrod.execution.writing import single_file, write_together
        from conrod.report.build_servers import results_text
        from conrod.report.html.page import html_report
        from conrod.report.writer import report_batch

        batches = [single_file(self.file, results_text(self.file, found))] if self.file else []
        place = self.folder or self.html
        if place:
            target = ("--out" if self.folder else "--html", place)
            stated = {**explicit_options(self.asked, RUNS, *FILE_FIELDS), **given}
            again = reproduction(command, subjects, stated, target)
            with nullcontext() if len(found) == 1 else _processes(self.asked) as executor:
                draw = executor.map if executor else map
                # No folder has the page's name, so that the page holds what was found now and nothing else.
                report = report_batch(self.kind, found.parts, place, again, draw)
            batches += [report] if self.folder else []
            batches += [single_file(self.html, html_report([report]))] if self.html else []
        write_together(batches)
        if self.html:
            say(f"report: {self.html}")
        if self.folder:
            say(f"report: {self.folder / self.kind.first_page(found.parts)}")


def machine_lines(machines: Mapping[str, Scene], changed: Collection[str], *, driven: bool = True) -> Iterator[str]:
    """Name each machine with its speed and the parameters that were changed: 'saw: 500 rpm (52.36 rad/s), rod 310 mm'.

    Args:
        changed: names of the parameters that the user gave.
        driven: whether the crank is kept at the scene's speed.
    """
    if len(machines) > MAX_NAMED_MACHINES:
        first = ", ".join([*machines][:MAX_NAMED_MACHINES])
        yield f"{len(machines)} machines: {first}, .."
        return
    for name, scene in machines.items():
        facts = scene.parameter_facts()
        rpm, unit = in_shown_unit(scene.speed, "rad/s")
        words = [f"{rpm} {unit} ({quantity(scene.speed)} rad/s)"] if driven else []
        words += [
            " ".join([one, *in_shown_unit(scene.parameters[one], facts[one].unit)]).removesuffix(" -")
            for one in dict.fromkeys(changed)
            if one in facts and one != "speed"
        ]
        yield f"{name}: {', '.join(words) or scene.title}"


def _processes(asked: ReportOptions) -> Any:
    """Processes that draw pages side by side; none where the verb has no options on runs."""
    return Runs(jobs=asked.jobs).processes() if isinstance(asked, RunOptions) else nullcontext()


def exit_with_verdict(found: Findings[Any]) -> None:
    """Print the comparison with a baseline; exit with status 1 where something is out of tolerance."""
    if compared := found.baseline:
        accept = [] if compared.passed or compared.written else [shlex.join(["conrod", *sys.argv[1:], "--accept"])]
        print_parts([*compared.text.splitlines(), *(f"accept it: {line}" for line in accept)])
    if found.passed is False:
        sys.exit(FAILED)


def check_outputs(
    kind: Kind[F],
    parts: Iterable[str],
    asked: ReportOptions,
    given: Mapping[str, Path] = MappingProxyType({}),
) -> Outputs[F]:
    """Check the outputs that --out, --json and --html name: no other file may be overwritten.

    Args:
        parts: names of the report's parts: scenes or files.
        given: files that the user gave to be read, by what they are called.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    if asked.out is None and asked.document is None and asked.html is None:
        return Outputs(kind, asked)
    from conrod.execution.files import files_to_write, folder_to_write
    from conrod.report.folder import ReportFolder

    if isinstance(asked, RunOptions):
        given = {"the ledger": asked.ledger_file, **given}
    if baseline := getattr(asked, "baseline", None):
        given = {"the baseline": Path(baseline), **given}
    files = files_to_write({"--json": asked.document, "--html": asked.html}, given)
    file, html = files.get("--json"), files.get("--html")
    folder = None if asked.out is None else folder_to_write(asked.out, "--out")
    if folder:
        before = ReportFolder(folder, kind)
        say_unfinished(before)
        before.check(parts, file, html, *given.values())
    return Outputs(kind, asked, folder, file, html)


def say_unfinished(report: ReportFolder) -> None:
    """Say that a report is not whole, where an earlier write of it was cut short."""
    if report.unfinished:
        say(f"{report.path / report.kind.results}: writing this report was stopped; it is made whole", err=True)


def reproduction(
    command: str,
    subjects: Sequence[str] | Mapping[str, str],
    options: Mapping[str, Any],
    target: tuple[str, Path],
) -> Reproduction:
    """Return the command that makes a report again.

    Args:
        command, subjects: as in `Outputs.print_and_write`.
        options: values by the name of their option; a tuple holds the values of an option that was repeated, and the
            empty name has the values of further arguments.
        target: the option that names the output, and its path.
    """
    from conrod.execution.resolve_arguments import arguments_of_files, arguments_of_members

    words, assigned = ["conrod", command, SCENE], options.get("--set", ())
    listed = any("," in one for one in assigned) and not isinstance(subjects, Mapping)
    members = arguments_of_members(tuple(subjects), assigned) if listed else {}
    if members:  # each has its own values in its words
        options = {name: found for name, found in options.items() if name != "--set"}
    for name, found in options.items():
        for one in found if isinstance(found, tuple) else () if found is None else (found,):
            # A whole number without the point that a float has.
            value = str(int(one) if isinstance(one, float) and one.is_integer() else one)
            words += [name] if name else []
            words += [] if one is True else [shlex.quote(value)]  # a flag has none
    text = " ".join([*words, target[0], shlex.quote(str(target[1]))])
    if isinstance(subjects, Mapping):
        return Reproduction(text, subjects)
    family = (*subjects, *(word for one in assigned for word in ("--set", one))) if members else ()
    return Reproduction(text, members or arguments_of_files(subjects), family)


# -- progress of runs, on standard error -------------------------------------------------------------------------------


@contextmanager
def runs_with_progress(asked: RunOptions) -> Iterator[Runs]:
    """Yield how runs are made by these options, with a progress bar; an interrupt prints how to continue."""
    path = asked.ledger_file
    try:
        yield Runs(path, asked.fresh, asked.jobs, asked.cluster, asked.timeout, asked.memory, ProgressBar)
    except KeyboardInterrupt:
        if path.exists():
            say(f"conrod: finished runs are kept in {path}; the same command goes on from there", err=True)
        raise


class ProgressBar(Watcher):
    """Progress of cases on standard error: a bar where that is a terminal, otherwise a line at either end.

    A watcher of `run_cases`, also called again and again, each time with what the answers so far ask for, and of
    `time_cases`; a context manager, because it has to be taken down again.
    """

    def __init__(self, description: str, usual: str = Outcome.COMPLETED.slug, console: Console | None = None) -> None:
        """Show nothing yet; cases that end as is `usual` are not counted apart."""
        self.console = standard_console(stderr=True) if console is None else console
        self._description, self._usual, self._ended = description, usual, Counter[str]()
        self._begun: float | None = None  # [s], when the first cases began
        self._bar: Progress | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._bar:
            self._bar.stop()
        if self._begun is not None:
            text = f"{self._description}: {self._ended.total()} done in {time.monotonic() - self._begun:.1f} s"
            others = [f"{n} {how}" for how, n in sorted(self._ended.items()) if how != self._usual]
            self._say(f"{text}, of which {', '.join(others)}" if others else text)

    def on_start(self, total: int, already_finished: int) -> None:
        new = total - already_finished
        if not self.console.is_terminal:
            more = "" if self._begun is None else "more "
            self._say(f"{self._description}: {new} {more}to do, {already_finished} in the ledger")
        elif self._bar or new:
            self._bar = self._bar or _new_bar(self._description, self.console)
            (task,) = self._bar.tasks
            self._bar.update(task.id, total=(task.total or 0) + new)
        self._begun = time.monotonic() if self._begun is None else self._begun

    def on_note(self, text: str) -> None:
        self._say(f"{self._description}: {text}")

    def on_emptied(self, count: int) -> None:
        self._say(f"{self._description}: the ledger's {count} runs are of an older conrod and are made again")

    def on_unreadable(self, count: int) -> None:
        self._say(f"{self._description}: {count} in the ledger cannot be read and count as not run; made again")

    def on_case_end(self, case: Case | None, how: str) -> None:
        self._ended[how] += 1
        if self._bar:
            self._bar.advance(self._bar.task_ids[0])

    def _say(self, text: str) -> None:
        self.console.print(text, markup=False, soft_wrap=True)


def _new_bar(description: str, console: Console) -> Progress:
    """Show a new bar in a terminal."""
    # Imported where there is something to wait for: it takes as long as all that the ledger answers.
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    bar = Progress(*columns, console=console, transient=True, speed_estimate_period=SPEED_PERIOD)
    bar.add_task(description, total=0)
    bar.start()
    return bar
