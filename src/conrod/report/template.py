"""Pages from templates: the prose of all reports lies in `templates/*.md.jinja`.

In a template `{{ value }}` prints a `Table` or a `Figure` as Markdown, and nothing for None. The functions of
`conrod.report.numbers` are filters (`{{ size | measured }}`). A paragraph may take several lines of a template.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from conrod.report import numbers
from conrod.report.figure import Figure
from conrod.report.markdown import bullets, figure_text, table_text, unwrapped
from conrod.report.table import Table

FILTERS = {
    "measured": numbers.measured,
    "quantity": numbers.quantity,
    "order": numbers.order,
    "duration": numbers.duration,
    "percent": numbers.percent,
    "bullets": bullets,
}


def rendered(template: str, **names: Any) -> str:
    """A page.

    Args:
        template: its file in `templates`, without `.md.jinja`.
        names: what the template speaks of; one that is missing is an error.
    """
    return unwrapped(_environment().get_template(f"{template}.md.jinja").render(**names))


def begun(text: str) -> str:
    """The text with a capital; `capitalize` would make the others small."""
    return text[:1].upper() + text[1:]


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("conrod.report"), undefined=StrictUndefined, finalize=_shown, trim_blocks=True,
        lstrip_blocks=True, autoescape=False,
    )  # fmt: skip
    made.filters |= FILTERS | {"begun": begun}
    return made


def _shown(value: Any) -> Any:
    match value:
        case Table():
            return table_text(value)
        case Figure():
            return figure_text(value)
        case None:
            return ""
        case _:
            return value
