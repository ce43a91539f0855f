"""Findings of every study by machine or file: how they are shown, written and judged."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic

from conrod.errors import InvalidInput
from conrod.report.kind import SCENE, F, Kind, Reproduction
from conrod.report.notebook import NotebookResult, data_frame, numbered_table
from conrod.report.table import Table
from conrod.report.terminal import print_parts

if TYPE_CHECKING:
    from pandas import DataFrame

    from conrod.execution.baseline import BaselineComparison

HTML = ".html"


@dataclass(frozen=True)
class Findings(NotebookResult, Mapping[str, F], Generic[F]):
    """Findings of a study, by name of machine or file.

    Attributes:
        kind: the kind of report that shows them.
        parts: findings by name.
        call: the Python call that finds the same, for a report; a command names itself when it writes.
        typed: arguments of a command, such as a file's path, by the name of their part.
        baseline: comparison with a baseline; None if none was named.
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
            InvalidInput: the findings are on several machines or files.
        """
        if len(self.parts) != 1:
            raise InvalidInput(f"these are findings on {', '.join(self.parts)}: take one by its name")
        return next(iter(self.parts.values()))

    @property
    def within_tolerance(self) -> bool | None:
        """True if everything judged is within tolerance; None if nothing was judged.

        False, too, if conrod's own figures cannot be trusted.
        """
        judge = self.kind.passed or findings_passed
        verdicts = [False if getattr(found, "distrust", "") else judge(found) for found in self.parts.values()]
        return False if False in verdicts else True if True in verdicts else None

    @property
    def passed(self) -> bool | None:
        """True if everything judged is within tolerance and as in the baseline; None if unjudged."""
        if self.baseline is None or self.within_tolerance is False:
            return self.within_tolerance
        return self.baseline.passed

    @property
    def verdict(self) -> str:
        """The verdict on each machine or file, in a few sentences."""
        return "\n".join(self.kind.verdict(found) for found in self.parts.values())

    def tables(self) -> list[Table]:
        """The tables that the command prints, without empty ones."""
        return self._tables_of(*self.parts.values())

    def _tables_of(self, *parts: F) -> list[Table]:
        return [part for part in self.kind.printed(list(parts)) if isinstance(part, Table) and part]

    def to_pandas(self, table: int = 0) -> DataFrame:
        """Return the tables of all machines or files, stacked, as a data frame of pandas.

        Args:
            table: its place in the tables of one of them.

        Raises:
            InvalidInput: pandas is not installed, or there is no such table.
        """
        of_parts = {name: self._tables_of(found) for name, found in self.parts.items()}
        first = numbered_table(max(of_parts.values(), key=len, default=[]), table)
        rows = [
            (name, *row)
            for name, tables in of_parts.items()
            for one in tables[table : table + 1]
            if one.headings == first.headings
            for row in one.rows
        ]
        if all(row[0] == row[1] for row in rows):  # the table itself names the machine
            return data_frame(replace(first, rows=tuple(row[1:] for row in rows)))
        return data_frame(replace(first, headings=("part", *first.headings), rows=tuple(rows)))

    @property
    def text(self) -> str:
        """The text that the command prints."""
        with redirect_stdout(io.StringIO()) as printed:
            print_parts(self.kind.printed(list(self.parts.values())))
        return "\n".join([printed.getvalue(), *([self.baseline.text] if self.baseline else [])])

    @property
    def json(self) -> str:
        """The JSON document that `--json` writes."""
        from conrod.report.writer import document_text

        return document_text(self.kind, self.parts)

    def write(self, place: str | Path, command: Reproduction | None = None) -> Path:
        """Write the report as a folder, or as one page if the name ends in .html.

        Args:
            command: command that makes the report again, printed in it; None for the Python call.

        Returns:
            The page to read first.

        Raises:
            InvalidInput: a file or folder is in the way.
        """
        from conrod.execution.files import files_to_write, folder_to_write
        from conrod.execution.writing import single_file, write_together
        from conrod.report.folder import ReportFolder
        from conrod.report.html.page import html_report
        from conrod.report.writer import report_batch

        again = command or Reproduction(self.call or f"conrod {self.kind.name} {SCENE}", self.typed)
        if str(place).lower().endswith(HTML):
            file = files_to_write({"the page": str(place)})["the page"]
            write_together([single_file(file, html_report([report_batch(self.kind, self.parts, file, again)]))])
            return file
        folder = folder_to_write(str(place), "the folder")
        ReportFolder(folder, self.kind).check(self.parts, None, None)
        write_together([report_batch(self.kind, self.parts, folder, again)])
        return folder / self.kind.first_page(self.parts)

    def __repr__(self) -> str:
        first = re.split(r"(?<=[^.\s])\.\s", self.verdict)[0].rstrip(".")  # a range is written "2.44 .. 2.54"
        return f"<{type(self).__name__} passed={self.passed}: {first}>"


def findings_passed(findings: Any) -> bool | None:
    """Return the `passed` of findings; None if they have results and none was judged.

    So a study that only measures does not count as passed.
    """
    results = getattr(findings, "results", None)
    judged = results is None or any(one.passed is not None for one in results)
    passed: bool | None = getattr(findings, "passed", None) if judged else None
    return passed


def text_of_call(function: str, *subjects: object, **arguments: object) -> str:
    """Return a call of the API as Python text, with the arguments that were given."""
    given = {name: value for name, value in arguments.items() if not (value is None or value is False or value == ())}
    words = [*map(repr, subjects), *(f"{name}={value!r}" for name, value in given.items())]
    return f"conrod.{function}({', '.join(words)})"
