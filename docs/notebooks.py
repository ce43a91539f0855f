"""The pages of the notebooks in examples/, with what they print: `python docs/notebooks.py` runs and writes all."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import tempfile
import textwrap
from collections.abc import Iterable, Iterator
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples"
PRINTED, COLUMNS = "It prints:", 90


def cells(notebook: str) -> list[tuple[str, str]]:
    """Kind and text of each cell of a notebook in percent format: `markdown` without its comment signs, or `code`."""
    found = []
    for cell in re.split(r"^# %%", notebook, flags=re.MULTILINE)[1:]:
        head, _, body = cell.partition("\n")
        text = re.sub(r"^# ?", "", body, flags=re.MULTILINE) if "[markdown]" in head else body
        found.append(("markdown" if "[markdown]" in head else "code", text))
    return found


def outputs(notebook: str, name: str) -> Iterator[str]:
    """Run the cells of a notebook one after the other in this process, and yield what each prints."""
    space = {"__name__": "__main__", "__file__": name}
    for kind, text in cells(notebook):
        printed = io.StringIO()
        if kind == "code":
            with contextlib.redirect_stdout(printed):
                exec(compile(text, name, "exec"), space)
        yield printed.getvalue()


def wrapped(output: str) -> str:
    """Wrap long sentences of an output as a terminal does; rows of tables stay."""
    lines = output.rstrip().splitlines()
    return "\n".join(line if "  " in line.strip() else textwrap.fill(line, COLUMNS) for line in lines)


def page(notebook: str, name: str, printed: Iterable[str]) -> str:
    """Return the page of a notebook: its texts, its code, and below each cell what that printed."""
    parts = []
    for (kind, text), output in zip(cells(notebook), printed, strict=True):
        parts.append(text.strip() if kind == "markdown" else f"```python\n{text.strip()}\n```")
        if output.strip():
            parts.append(f"{PRINTED}\n\n```\n{wrapped(output)}\n```")
    title, *rest = parts[0].split("\n\n", 1)
    note = f"Made from [{name}]({name}), which runs as it stands. All: [notebooks](README.md)."
    return "\n\n".join([title, note, *rest, *parts[1:]]) + "\n"


def write_pages() -> None:
    """Run all notebooks, each in an empty folder, and write their pages beside them."""
    for file in sorted(EXAMPLES.glob("*.py")):
        notebook = file.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            file.with_suffix(".md").write_text(page(notebook, file.name, outputs(notebook, file.name)), encoding="utf-8")
            os.chdir(EXAMPLES)
        print(f"wrote {file.with_suffix('.md')}", file=sys.stderr)


if __name__ == "__main__":
    write_pages()
