"""Kinds of reports: how findings are saved, and how pages and figures are made of what was saved.

To add a kind: findings, a frozen dataclass of plain values, arrays, scenes, enums and further dataclasses; templates
`NAME.md.jinja` for the page of a part and `NAME-index.md.jinja` for the first page, where all prose stands, and which
ask a module for its tables and figures (`{{ report.verdicts_table([study]) }}`); that module, with `KIND = Kind(...)`,
such as `report/free_motion.py`; a line in `KINDS`. A verb calls `ReportFolder.check` before
any work and writes with `report_batch` of `report/writer.py`. Findings that change shape get another `schema`.

In the folder: `results.json` with {kind, schema, conrod, environment, command, files, parts: {NAME: {title, command,
conrod, summary, page, data, files}}}, and `data/NAME.json` with a part's findings; `files` are those that the
report owns, and may replace or remove.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from conrod.errors import unknown_choice
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart as Printed
from conrod.scenes import CATALOGUE, SCENES, catalogue_names

if TYPE_CHECKING:
    from conrod.report.template import Page

F = TypeVar("F")
SCENE = "{scene}"  # in a command, what stands for the scenes

# By name, the module whose `KIND` it is: a kind is imported when a folder holds one. An application may add its own.
KINDS: dict[str, str] = {
    "ablate": "conrod.report.ablate",
    "printed-values": "conrod.report.printed_values",
    "trajectory": "conrod.report.trajectory",
    "forces": "conrod.report.forces",
    "invariances": "conrod.report.invariances",
    "limits": "conrod.report.limits.report",
    "loops": "conrod.report.loops",
    "model": "conrod.report.user_model",
    "motion": "conrod.report.free_motion",
    "validation": "conrod.report.validation",
    "recommendation": "conrod.report.recommendation",
    "sweep": "conrod.report.sweep",
    "versions": "conrod.report.versions",
}


@dataclass(frozen=True)
class Reproduction:
    """A command of which the scenes are left open.

    Attributes:
        text: the command, quoted for a shell; the first {scene} in it stands for the scenes.
        typed: what is typed for those scenes that do not go by their names, such as a mechanism file's path, by name.
    """

    text: str
    typed: Mapping[str, str] = field(default_factory=dict)

    def command_for(self, *names: str) -> str:
        """The command for some scenes."""
        return self.text.replace(SCENE, " ".join(shlex.quote(self.typed.get(name, name)) for name in names), 1)

    def command_for_all(self, names: Collection[str]) -> str:
        """The command for all scenes of a report, in the shortest way that a user would type."""
        if set(names) == set(SCENES):
            return self.text.replace(f"{SCENE} ", "", 1)
        is_catalogue = not self.typed and set(names) == set(catalogue_names())
        return self.command_for(*((CATALOGUE,) if is_catalogue else names))


@dataclass(frozen=True)
class Part(Generic[F]):
    """Findings on one machine or file.

    Attributes:
        name: of its page and files.
        command: what finds the same again.
        conrod: version that found it.
    """

    name: str
    findings: F
    command: str
    conrod: str


@dataclass(frozen=True)
class Index(Generic[F]):
    """Material of the first page.

    Attributes:
        entries: those of `results.json` by part: title, command, conrod, summary, page, data.
        environment: of what was found last: Python, machine, system, and versions of engines and packages by name.
        origin: how to make the report again, in a sentence.
        findings: of a part, read when they are asked for.
    """

    entries: Mapping[str, Mapping[str, Any]]
    environment: Mapping[str, str]
    origin: str
    findings: Callable[[str], F]

    @cached_property
    def studies(self) -> dict[str, F]:
        """The findings of all parts."""
        return {name: self.findings(name) for name in self.entries}

    @property
    def versions(self) -> Table:
        """All versions of conrod that occur, and the environment of what was found last; pages name their engines."""
        conrod = "; ".join(sorted({entry["conrod"] for entry in self.entries.values()}))
        title = "versions of what was measured last; each page names its own"
        return table(["what", "which"], [("conrod", conrod), *self.environment.items()], title=title)


@dataclass(frozen=True)
class Kind(Generic[F]):
    """One kind of report.

    Attributes:
        name: as `KINDS` has it.
        findings: type of a part's findings.
        title: of a part, from its findings.
        summary: what the index and scripts read of a part, plain values.
        printed: tables and sentences that the command prints of some findings.
        verdict: findings in a few sentences, the first of which says the answer.
        passed: whether findings are within tolerance, None where nothing was judged; without it by their own `passed`.
        one_part: whether a report has one part, whose page is the first; others have an index.
        results, index_file: names of its files in a folder, which several kinds may share.
        suffix: of the names of its pages and data.
        kept: what of the findings is saved.
        merged: earlier findings of a part with new ones; None where these replace them.
        digits: of measured fractions in a folder, see `round_findings`; all of them where it is None.
        digits_of: the same of what has these names, and of all in it.
        live: markup of its own that a part's page has in HTML below its first sentence, with ids that begin with a
            text; empty where there is none.
        in_live: figures by the end of their names that it makes needless.
        tile: of a part on the first page in HTML, a figure by the end of its name; empty for none.
        schema: of the findings.
    """

    name: str
    findings: type[F]
    title: Callable[[F], str]
    summary: Callable[[F], Mapping[str, Any]]
    printed: Callable[[Sequence[F]], Iterable[Printed]]
    verdict: Callable[[F], str]
    passed: Callable[[F], bool | None] | None = None
    one_part: bool = False
    results: str = "results.json"
    index_file: str = "README.md"
    suffix: str = ""
    kept: Callable[[F], F] = lambda findings: findings
    merged: Callable[[F, F], F] | None = None
    digits: int | None = None
    digits_of: Mapping[str, int | None] = field(default_factory=dict)
    live: Callable[[Part[F], str], str] | None = None
    in_live: tuple[str, ...] = ()
    tile: str = ""
    schema: int = 2

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle a kind as its name, for its functions are those of a module."""
        return kind_named, (self.name,)

    def page_of(self, part: Part[F]) -> Page:
        """The page of a part; its template speaks of `part`, its findings `study`, and the kind's module `report`."""
        from conrod.report.template import page  # it has templates draw figures

        return page(self.name, import_module(KINDS[self.name]), part=part, study=part.findings)

    def index_of(self, index: Index[F]) -> Page:
        """The first page of several parts; its template speaks of `index` and the kind's module `report`."""
        from conrod.report.template import page

        return page(f"{self.name}-index", import_module(KINDS[self.name]), index=index)

    def page_file(self, part: str) -> str:
        """Name of a part's page."""
        return self.index_file if self.one_part else f"{part}{self.suffix}.md"

    def data_file(self, part: str) -> str:
        """Name of the file of a part's findings."""
        return f"data/{part}{self.suffix}.json"

    def first_page(self, parts: Mapping[str, Any]) -> str:
        """Name of the page to read first: that of the only part, or the index."""
        return self.page_file(next(iter(parts))) if len(parts) == 1 else self.index_file


def kind_named(name: str) -> Kind[Any]:
    """The kind of a name.

    Raises:
        InvalidInput: there is none.
    """
    if name not in KINDS:
        raise unknown_choice("kind of report", name, KINDS)
    kind: Kind[Any] = import_module(KINDS[name]).KIND
    return kind
