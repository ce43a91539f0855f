"""The notebooks in examples/ run, and name in their texts the numbers that they print."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest
from command_line import kept_worker

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
SLOW = {"judge_my_model", "dynamics_study"}  # they judge in processes of their own
RUNS = [
    pytest.param(path, marks=pytest.mark.slow if path.stem in SLOW else (), id=path.stem) for path in EXAMPLES
]  # fmt: skip
MAX_LINES, MIN_LINES = 80, 40
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w]|\.\d)")
CODE_OR_LINK = re.compile(r"`[^`]*`|\]\([^)]*\)")


def cells(notebook: str) -> list[tuple[str, str]]:
    """Kind and text of each cell: `markdown` without its comment signs, or `code`."""
    found = []
    for cell in re.split(r"^# %%", notebook, flags=re.MULTILINE)[1:]:
        head, _, body = cell.partition("\n")
        text = re.sub(r"^# ?", "", body, flags=re.MULTILINE) if "[markdown]" in head else body
        found.append(("markdown" if "[markdown]" in head else "code", text))
    return found


def named_numbers(notebook: str) -> list[str]:
    """Numbers in the texts of a notebook, without those in code."""
    texts = [CODE_OR_LINK.sub("", text) for kind, text in cells(notebook) if kind == "markdown"]
    return [number for text in texts for number in NUMBER.findall(text)]


def unprinted_numbers(notebook: str, printed: str) -> list[str]:
    known = set(NUMBER.findall(printed))
    return [number for number in named_numbers(notebook) if number not in known]


@pytest.mark.parametrize("path", RUNS)
def test_notebook_prints_the_numbers_that_it_names(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("conrod.execution.local.WorkerProcess", kept_worker)
    runpy.run_path(str(path))
    notebook, printed = path.read_text(encoding="utf-8"), capsys.readouterr().out
    assert unprinted_numbers(notebook, printed) == []
    # Negative control: a number of the text that is otherwise in its last digit.
    last = named_numbers(notebook)[-1]
    slip = f"{last[:-1]}{(int(last[-1]) + 1) % 10}"
    assert slip in unprinted_numbers(notebook.replace(last, slip), printed)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_notebook_is_a_short_story_that_says_what_is_next(path: Path) -> None:
    notebook = path.read_text(encoding="utf-8")
    found = cells(notebook)
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
