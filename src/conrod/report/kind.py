"""Kinds of reports: how findings are saved, and how pages and figures are made from saved findings.

To add a kind: findings, a frozen dataclass of plain values, arrays, scenes, enums and further dataclasses; templates
`NAME.md.jinja` for the page of a part and `NAME-index.md.jinja` for the first page, which have all prose and call a
module for tables and figures (`{{ report.verdicts_table([study]) }}`); that module, with `NAME_REPORT = Kind(...)`,
such as `studies/free_motion/report.py`; a line in `slices.py`. A verb calls `ReportFolder.check` before any work and
writes with `report_batch` of `report/writer.py`. Findings that change shape get another `schema`.

In the folder: `results.json` with {kind, schema, conrod, environment, command, files, parts: {NAME: {title, command,
conrod, summary, page, data, files}}}, and `data/NAME.json` with a part's findings; `files` names the files that the
report owns, and may replace or remove.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from conrod.errors import InvalidInput, unknown_choice
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart as Printed
from conrod.scenes import CATALOGUE, SCENES, catalogue_names
from conrod.slices import SLICES

if TYPE_CHECKING:
    from conrod.report.template import Page

F = TypeVar("F")
SCENE = "{scene}"  # placeholder of the scenes in a command

# Kinds of reports by their names: a module, imported when a folder has such a report, and the name of the `Kind` in it.
# An application may add some.
KINDS: dict[str, str] = {kind: f"{one.package}.{place}" for one in SLICES for kind, place in one.reports.items()}
# Reports that conrod's repository makes of itself: their modules are there when it is installed by `pip install -e .`.
REPOSITORY_KINDS = {
    "documents": "audits.report.pages.DOCUMENTS_REPORT",
    "cams": "audits.report.cams.CAMS_REPORT",
    "detection": "docs.studies.detection_report.DETECTION_REPORT",
    "batch": "docs.studies.batch_report.BATCH_REPORT",
    "batch-gpu": "docs.studies.batch_gpu_page.BATCH_GPU_REPORT",
}
KINDS |= REPOSITORY_KINDS


@dataclass(frozen=True)
class Reproduction:
    """A command with a placeholder for the scenes.

    Attributes:
        text: the command, quoted for a shell; the first {scene} in it stands for the scenes.
        typed: arguments by scene name, such as a mechanism file's path, where they are not the name itself; several
            words of a member of a family.
        family: words for all scenes together, where some are members of a family.
    """

    text: str
    typed: Mapping[str, str | Sequence[str]] = field(default_factory=dict)
    family: Sequence[str] = ()

    def command_for(self, *names: str) -> str:
        """Return the command with the names of scenes in its placeholder."""
        given = (self.typed.get(name, name) for name in names)
        return self._with_words(word for one in given for word in ([one] if isinstance(one, str) else one))

    def command_for_all(self, names: Collection[str]) -> str:
        """Return the shortest command for all scenes of a report."""
        if self.family:
            return self._with_words(self.family)
        if set(names) == set(SCENES):
            return self.text.replace(f"{SCENE} ", "", 1)
        is_catalogue = not self.typed and set(names) == set(catalogue_names())
        return self.command_for(*((CATALOGUE,) if is_catalogue else names))

    def _with_words(self, words: Iterable[str]) -> str:
        return self.text.replace(SCENE, " ".join(map(shlex.quote, words)), 1)


@dataclass(frozen=True)
class Part(Generic[F]):
    """Findings on one machine or file.

    Attributes:
        name: stem of the names of its page and files.
        command: command that finds the same again.
        conrod: version of conrod that found it.
        elsewhere: links to pages on the same machine of reports in folders below, as Markdown.
    """

    name: str
    findings: F
    command: str
    conrod: str
    elsewhere: Sequence[str] = ()


@dataclass(frozen=True)
class Index(Generic[F]):
    """Values that the template of a report's first page prints.

    Attributes:
        entries: entries of `results.json` by part: title, command, conrod, summary, page, data.
        environment: Python, machine, system, and versions of packages by name, at the last measurement.
        origin: how to make the report again, in a sentence.
        findings: reads the findings of a part.
        subreports: lines on the reports in folders below, each with a link to it, as Markdown.
    """

    entries: Mapping[str, Mapping[str, Any]]
    environment: Mapping[str, str]
    origin: str
    findings: Callable[[str], F]
    subreports: Sequence[str] = ()

    @cached_property
    def studies(self) -> dict[str, F]:
        """The findings of all parts."""
        return {name: self.findings(name) for name in self.entries}

    @property
    def versions(self) -> Table:
        """Table of all versions of conrod in the report, and of the last environment."""
        conrod = "; ".join(sorted({entry["conrod"] for entry in self.entries.values()}))
        title = "versions of what was measured last; each page names its own"
        return table(["what", "which"], [("conrod", conrod), *self.environment.items()], title=title)


@dataclass(frozen=True)
class Kind(Generic[F]):
    """A kind of report: its findings, templates, tables and figures.

    Attributes:
        name: key in `KINDS`.
        findings: type of a part's findings.
        title: returns the title of a part.
        summary: returns plain values of a part for the index and for scripts.
        printed: returns the tables and sentences that a command prints.
        verdict: returns the verdict in a few sentences, the answer first.
        headline: returns the finding of a whole report in a line, from the entries of its parts, for a report above it;
            by default what its first page states in bold.
        passed: True if findings are within tolerance, None if nothing was judged; by default their attribute `passed`.
        one_part: True if a report has only one part, and so no index.
        results, index_file: names of its files in a folder, which several kinds may share.
        suffix: ending of the names of its pages and data.
        prepare_to_save: returns the findings as they are saved.
        merge: merges earlier findings of a part with new ones; None if new ones replace them.
        digits: digits of measured fractions in a folder, see `round_findings`; None keeps all.
        digits_of: other digits for fields of these names.
        places: by field, the field of the largest values whose places it has, see `keep_earlier_digits`.
        live_html: returns HTML to insert below the first sentence of a part's page, with ids that begin with a prefix;
            empty if there is none.
        replaced_figures: endings of the names of figures that this HTML replaces.
        tile: ending of the name of a part's figure on the first page in HTML; empty for none.
        schema: version of the layout of the findings.
    """

    name: str
    findings: type[F]
    title: Callable[[F], str]
    summary: Callable[[F], Mapping[str, Any]]
    printed: Callable[[Sequence[F]], Iterable[Printed]]
    verdict: Callable[[F], str]
    headline: Callable[[Mapping[str, Mapping[str, Any]]], str] | None = None
    passed: Callable[[F], bool | None] | None = None
    one_part: bool = False
    results: str = "results.json"
    index_file: str = "README.md"
    suffix: str = ""
    prepare_to_save: Callable[[F], F] = lambda findings: findings
    merge: Callable[[F, F], F] | None = None
    digits: int | None = None
    digits_of: Mapping[str, int | None] = field(default_factory=dict)
    places: Mapping[str, str] = field(default_factory=dict)
    live_html: Callable[[Part[F], str], str] | None = None
    replaced_figures: tuple[str, ...] = ()
    tile: str = ""
    schema: int = 2

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle a kind by its name, because it holds functions."""
        return kind_named, (self.name,)

    def _module(self) -> ModuleType:
        return import_module(KINDS[self.name].rpartition(".")[0])

    def page_of(self, part: Part[F]) -> Page:
        """Render the page of a part from `part`, `study` (its findings) and `report` (the module)."""
        from conrod.report.template import page  # loaded late: it loads jinja2

        return page(self.name, self._module(), kind=self, part=part, study=part.findings)

    def index_of(self, index: Index[F]) -> Page:
        """Render the first page of several parts from `index` and `report` (the kind's module)."""
        from conrod.report.template import page

        return page(f"{self.name}-index", self._module(), kind=self, index=index)

    def page_file(self, part: str) -> str:
        """Return the file name of a part's page."""
        return self.index_file if self.one_part else f"{part}{self.suffix}.md"

    def data_file(self, part: str) -> str:
        """Return the file name of a part's findings."""
        return f"data/{part}{self.suffix}.json"

    def first_page(self, parts: Mapping[str, Any]) -> str:
        """Return the file name of the page to read first: the only part's page, or the index."""
        return self.page_file(next(iter(parts))) if len(parts) == 1 else self.index_file


def kind_named(name: str) -> Kind[Any]:
    """Return the kind of report of a name.

    Raises:
        InvalidInput: no kind has the name, or what renders it is not installed.
    """
    if name not in KINDS:
        raise unknown_choice("kind of report", name, KINDS)
    module, _, constant = KINDS[name].rpartition(".")
    try:
        kind: Kind[Any] = getattr(import_module(module), constant)
    except ModuleNotFoundError:
        if name not in REPOSITORY_KINDS:
            raise
        where = "where conrod is installed from its repository, by `pip install -e .` there"
        raise InvalidInput(f"reports of the kind {name!r} can be rendered {where}") from None
    return kind
