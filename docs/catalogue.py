"""The page `docs/catalogue.md`, made from the files: `python docs/catalogue.py > docs/catalogue.md`."""

from __future__ import annotations

import sys

from conrod.scenes import catalogue_names, catalogue_tables

HEAD = """# The catalogue

Machines that ship as [mechanism files](mechanism-files.md) in `src/conrod/scenes/catalogue/`. Each is a scene by its
name, wherever `conrod` takes one; `conrod validate catalogue` runs all of them in both engines, and
[reports/catalogue](../reports/catalogue/README.md) has what that found, one page per machine with its assumptions. Copy
a file to start a machine of your own.

| machine | what it is | moving links | source |
|---|---|---|---|
"""


def page() -> str:
    """The page as Markdown."""
    return HEAD + "".join(_row(name) for name in catalogue_names())


def _row(name: str) -> str:
    tables = catalogue_tables(name)
    links = f"{len(tables['bodies'])}, one pass" if "from" in tables["driver"] else str(len(tables["bodies"]))
    cells = (f"[{name}](../src/conrod/scenes/catalogue/{name}.toml)", tables["title"], links, tables["source"])
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |\n"


if __name__ == "__main__":
    sys.stdout.write(page())
