"""The notebooks in examples/ run, name in their texts the numbers that they print, and have pages with all of it."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from command_line import kept_worker

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES: Any = SimpleNamespace(**runpy.run_path(str(ROOT / "docs" / "notebooks.py")))
SLOW = {"judge_my_model", "dynamics_study"}  # they judge in processes of their own
RUNS = [
    pytest.param(path, marks=pytest.mark.slow if path.stem in SLOW else (), id=path.stem) for path in EXAMPLES
]  # fmt: skip
MAX_LINES, MIN_LINES = 80, 40
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w]|\.\d)")
LONG_NUMBER = re.compile(r"\d+\.\d{5,}")  # whose last digits are rounding
CODE_OR_LINK = re.compile(r"`[^`]*`|\]\([^)]*\)")


def named_numbers(notebook: str) -> list[str]:
    """Numbers in the texts of a notebook, without those in code."""
    texts = [CODE_OR_LINK.sub("", text) for kind, text in PAGES.cells(notebook) if kind == "markdown"]
    return [number for text in texts for number in NUMBER.findall(text)]


def unprinted_numbers(notebook: str, printed: str) -> list[str]:
    known = set(NUMBER.findall(printed))
    return [number for number in named_numbers(notebook) if number not in known]


@pytest.mark.parametrize("path", RUNS)
def test_page_shows_what_its_notebook_prints_today(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("conrod.execution.local.WorkerProcess", kept_worker)
    notebook = path.read_text(encoding="utf-8")
    outputs = [*PAGES.outputs(notebook, path.name)]
    page = path.with_suffix(".md").read_text(encoding="utf-8")
    made = PAGES.page(notebook, path.name, outputs)
    assert LONG_NUMBER.sub("#", made) == LONG_NUMBER.sub("#", page), "make notebooks"
    printed = "".join(outputs)
    assert unprinted_numbers(notebook, printed) == []
    # Negative control: a number of the text that is otherwise in its last digit.
    last = named_numbers(notebook)[-1]
    slip = f"{last[:-1]}{(int(last[-1]) + 1) % 10}"
    assert slip in unprinted_numbers(notebook.replace(last, slip), printed)
    # Another: one more word printed by the last cell that prints.
    last_printing = max(k for k, output in enumerate(outputs) if output)
    outputs[last_printing] += "more"
    assert LONG_NUMBER.sub("#", PAGES.page(notebook, path.name, outputs)) != LONG_NUMBER.sub("#", page)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_notebook_is_a_short_story_that_says_what_is_next(path: Path) -> None:
    notebook = path.read_text(encoding="utf-8")
    found = PAGES.cells(notebook)
    assert MIN_LINES <= len(notebook.splitlines()) <= MAX_LINES
    assert [kind for kind, _ in (found[0], found[-1])] == ["markdown", "markdown"]
    assert found[0][1].startswith("# ")
    assert "## What to do next\n\n- " in found[-1][1]
    assert "import conrod\n" in notebook


def test_every_notebook_stands_in_the_list() -> None:
    page = (EXAMPLES[0].parent / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"\| \[(\w+)\.py\]", page) == [
        "judge_my_model", "choose_settings", "regression_test", "dynamics_study", "textbook_audit",
    ]  # fmt: skip
    assert len(EXAMPLES) == 5
