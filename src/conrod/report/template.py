"""Pages in Markdown from templates, which have all prose of reports: in `templates/`, or in a kind's own folder.

In a template `{{ value }}` prints a `Table` or a `Figure` as Markdown, and nothing for None; each figure printed so
becomes a figure of the page. Some functions of `conrod.report.numbers` are filters (`{{ size | measured_text }}`), some
of `conrod.report.results` are globals. A paragraph may take several lines of a template.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import PurePath
from types import ModuleType
from typing import Any
from urllib.parse import quote

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, pass_context
from jinja2.runtime import Context

from conrod.report import numbers, results
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.table import Cell, ColouredCell, Table, Verbatim, safe_markdown, verbatim


@dataclass(frozen=True)
class Page:
    """A page in Markdown with the figures that it shows."""

    text: str
    figures: tuple[Figure, ...] = ()


BLOCK_STARTS = ("|", "#", "- ", "* ", "!", "```", "<", "$$")


def table_text(table: Table) -> str:
    """Return a table in Markdown, with cells out of tolerance in bold; empty if it has no rows."""
    if not table:
        return ""
    rule = ["---:" if heading in table.right else "---" for heading in table.headings]
    lines = [_row_text(table.headings), _row_text(rule), *(_row_text(row) for row in table.rows)]
    return "\n".join([f"{table.title[:1].upper()}{table.title[1:]}:\n", *lines] if table.title else lines)


def figure_text(figure: Figure) -> str:
    """Return the Markdown of a figure."""
    return f"![{safe_markdown(figure.alt)}]({quote(figure.file)})"


def bullets(points: Iterable[str]) -> str:
    """Return points as a Markdown list, each on one line."""
    return "\n".join(f"- {' '.join(point.split())}" for point in points)


def capitalise(text: str) -> str:
    """Capitalise the first letter, and unlike `str.capitalize` keep the rest."""
    return text[:1].upper() + text[1:]


def first_sentence(text: str) -> str:
    """Return a text up to its first full stop before a blank: what a page states in bold."""
    return f"{text.partition('. ')[0].removesuffix('.')}."


def after_first_sentence(text: str) -> str:
    """Return the rest of a text whose first sentence stands apart; empty if it has no more."""
    return text.partition(". ")[2]


def join_words(words: Sequence[str]) -> str:
    """Join words into a list in a sentence: `a, b and c`."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def unwrap_paragraphs(text: str) -> str:
    """Put every paragraph on one line, with one empty line between blocks."""
    lines: list[str] = []
    fenced = False
    for line in (line.rstrip() for line in text.strip().splitlines()):
        before = lines[-1] if lines else ""
        if line.startswith("```"):
            fenced = not fenced
        if fenced or line.startswith("```"):
            lines.append(line)
        elif not line:
            if before:
                lines.append(line)
        elif before and not line.startswith(BLOCK_STARTS) and not before.startswith(("|", "#", "```", "!")):
            lines[-1] = f"{before} {line.lstrip()}"
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


def _row_text(cells: Iterable[Cell]) -> str:
    return "| " + " | ".join(_cell_text(cell) for cell in cells) + " |"


def _cell_text(cell: Cell) -> str:
    if isinstance(cell, ColouredCell):
        text = _cell_text(cell.text)
        return f"**{text}**" if cell.tone == "bad" else text
    return cell.replace("|", "\\|").replace("\n", " ")


FILTERS = {
    "measured_text": numbers.measured_text,
    "quantity": numbers.quantity,
    "lengths": numbers.lengths,
    "in_shown_unit": numbers.in_shown_unit,
    "file_name": lambda path: PurePath(path).name,
    "bullets": bullets,
    "capitalise": capitalise,
    "first_sentence": first_sentence,
    "after_first_sentence": after_first_sentence,
    "verbatim": verbatim,
}


REPORT_PACKAGE = "conrod.report"
GLOBALS = {
    "scene_description": results.scene_description,
    "distrust_words": results.distrust_words,
    "engine_title": engine_title,
    "engine_and_preset": results.engine_and_preset,
    "parameters_table": results.parameters_table,
    "index_words": results.index_words,
    "summary_words": results.summary_words,
    "versions_words": results.versions_words,
}


def page(template: str, report: ModuleType | None = None, **names: Any) -> Page:
    """Render a template as a page.

    Args:
        template: name of its file in `templates` or in the module's folder, without `.md.jinja`.
        report: the module that makes its tables and figures.
        names: its other variables; a missing one is an error.
    """
    shown = dict[str, Figure]()
    found = _environment(report.__name__.rpartition(".")[0] if report else REPORT_PACKAGE).get_template(
        f"{template}.md.jinja"
    )
    text = found.render(report=report, shown_figures=shown, **names)
    return Page(unwrap_paragraphs(text), tuple(shown.values()))


@cache
def _environment(package: str = REPORT_PACKAGE) -> Environment:
    beside = PackageLoader(package, "")
    made = Environment(
        loader=ChoiceLoader([PackageLoader(REPORT_PACKAGE), beside]), undefined=StrictUndefined,
        finalize=_finalise_value, trim_blocks=True, lstrip_blocks=True, autoescape=False,
    )  # fmt: skip
    made.filters |= FILTERS
    made.globals |= GLOBALS
    return made


@pass_context
def _finalise_value(context: Context, value: Any) -> Any:
    match value:
        case Table():
            return safe_markdown(table_text(value))
        case Figure():
            context["shown_figures"][value.name] = value
            return figure_text(value)
        case Verbatim():
            return value
        case str():
            return safe_markdown(value)
        case None:
            return ""
        case _:
            return value
