"""The table of engines and capabilities in `docs/engines.md`: `python docs/capabilities.py` writes what is installed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from conrod.cli.show import capabilities_table
from conrod.engines import Engine
from conrod.engines import installed_extras, loadable_engines
from conrod.report.table import table
from conrod.report.template import table_text

PAGE = Path(__file__).with_name("engines.md")
BEGIN, END = "<!-- python docs/capabilities.py -->\n", "\n<!-- end of the table -->"


def text_of(engines: Sequence[Engine[Any]]) -> str:
    """The table as Markdown, without versions and origins."""
    whole = capabilities_table(engines)
    return table_text(table(whole.headings, whole.rows[2:]))


if __name__ == "__main__":
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    made = text_of(loadable_engines(installed_extras())[0])
    PAGE.write_text(before + BEGIN + made + END + rest.split(END)[1], encoding="utf-8")
