"""The answer of every study: findings by machine or file, shown, written and judged in one way."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from markupsafe import escape

from conrod.errors import InvalidInput
from conrod.report.kind import SCENE, Kind, Reproduction
from conrod.report.table import Table, cell_text, safe_html
from conrod.report.terminal import print_parts

if TYPE_CHECKING:
    from conrod.studies.frame.baseline import BaselineComparison

F = TypeVar("F")
HTML = ".html"


@dataclass(frozen=True)
class Findings(Mapping[str, F], Generic[F]):
    """Findings of a study, by name of the machine or file that they are on.

    Attributes:
        kind: of the report that shows them.
        parts: findings by name.
        call: the Python call that finds the same, for a report; a command names itself when it writes.
        typed: what a command names for a part, such as a file's path, where that is not the part's name.
        baseline: comparison with the baseline that was named; None where none was.
    """

    kind: Kind[F]
    parts: Mapping[str, F]
    call: str = ""
    typed: Mapping[str, str] = field(default_factory=dict)
    baseline: BaselineComparison | None = None

    def __getitem__(self, name: str) -> F:
        return self.parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)

    @property
    def study(self) -> F:
        """The findings on the only machine or file.

        Raises:
            InvalidInput: there are several.
        """
        if len(self.parts) != 1:
            raise InvalidInput(f"these are findings on {', '.join(self.parts)}: take one by its name")
        return next(iter(self.parts.values()))

    @property
    def within_tolerance(self) -> bool | None:
        """True if all that was judged is within tolerance, a baseline apart; None where nothing was judged."""
        judge = self.kind.passed or findings_passed
        verdicts = [judge(found) for found in self.parts.values()]
        return False if False in verdicts else True if True in verdicts else None

    @property
    def passed(self) -> bool | None:
        """True if all that was judged is within tolerance and as in the baseline; None where nothing was judged."""
        if self.baseline is None or self.within_tolerance is False:
            return self.within_tolerance
        return self.baseline.passed

    @property
    def verdict(self) -> str:
        """The answer in a few sentences for each machine or file, the first of which says it."""
        return "\n".join(self.kind.verdict(found) for found in self.parts.values())

    def tables(self) -> list[Table]:
        """The tables that the command prints, those without rows left out as there."""
        return [part for part in self.kind.printed(list(self.parts.values())) if isinstance(part, Table) and part]

    @property
    def text(self) -> str:
        """All that the command prints."""
        with redirect_stdout(io.StringIO()) as printed:
            print_parts(self.kind.printed(list(self.parts.values())))
        return "\n".join([printed.getvalue(), *([self.baseline.text] if self.baseline else [])])

    @property
    def json(self) -> str:
        """The JSON document that `--json` writes."""
        from conrod.report.writer import document_text

        return document_text(self.kind, self.parts)

    def write(self, place: str | Path, command: Reproduction | None = None) -> Path:
        """Write the report: a folder of pages, figures and data, or one page where the name ends in .html.

        Args:
            command: what makes the report again, printed in it; None for the Python call.

        Returns:
            The page to read first.

        Raises:
            InvalidInput: something is in the way.
        """
        from conrod.report.folder import ReportFolder
        from conrod.report.html.page import html_report
        from conrod.report.writer import report_batch
        from conrod.studies.frame.files import files_to_write, folder_to_write
        from conrod.studies.frame.writing import single, write_together

        again = command or Reproduction(self.call or f"conrod {self.kind.name} {SCENE}", self.typed)
        if str(place).lower().endswith(HTML):
            file = files_to_write({"the page": str(place)})["the page"]
            write_together([single(file, html_report([report_batch(self.kind, self.parts, file, again)]))])
            return file
        folder = folder_to_write(str(place), "the folder")
        ReportFolder(folder, self.kind).check(self.parts, None, None)
        write_together([report_batch(self.kind, self.parts, folder, again)])
        return folder / self.kind.first_page(self.parts)

    def __repr__(self) -> str:
        first = re.split(r"(?<=[^.\s])\.\s", self.verdict)[0].rstrip(".")  # a range is written "2.44 .. 2.54"
        return f"<{type(self).__name__} passed={self.passed}: {first}>"

    def _repr_html_(self) -> str:
        """The verdict and the tables, as a notebook shows them."""
        return safe_html("".join([f"<p>{escape(self.verdict)}</p>", *map(_html_table, self.tables())]))


def findings_passed(findings: Any) -> bool | None:
    """True if all that was judged in findings is within tolerance; None where nothing was judged, or nothing is."""
    results = getattr(findings, "results", None)
    judged = results is None or any(one.passed is not None for one in results)
    passed: bool | None = getattr(findings, "passed", None) if judged else None
    return passed


def text_of_call(function: str, subject: object, **arguments: object) -> str:
    """A call of the API as Python text, with the arguments that were given, for reports to print."""
    given = {name: value for name, value in arguments.items() if value not in (None, (), False)}
    return f"conrod.{function}({', '.join([repr(subject), *(f'{name}={value!r}' for name, value in given.items())])})"


def _html_table(table: Table) -> str:
    rows = [table.headings, *table.rows]
    tags = ["th", *["td"] * len(table.rows)]
    lines = [
        f"<tr>{''.join(f'<{tag}>{escape(cell_text(cell))}</{tag}>' for cell in row)}</tr>"
        for tag, row in zip(tags, rows, strict=True)
    ]
    return f"<table><caption>{escape(table.title)}</caption>{''.join(lines)}</table>"
