"""`conrod limits` as a user types it."""

from __future__ import annotations

import json
import sqlite3
import subprocess
from pathlib import Path
from typing import Any

import command_line
import pytest

from conrod.runs.plain import restore
from conrod.studies.limits.results import LimitStudy

# Two dozen runs of a second or two in all.
QUICK = ("saw-500rpm", "--axis", "steps", "--engine", "pymunk", "--preset", "stock", "--range", "400..2")


def conrod(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    named = (*arguments, "--ledger", "ledger.sqlite")
    return command_line.conrod("limits", *named, cwd=cwd, ledger=cwd / "default.sqlite")


def runs_in(ledger: Path) -> int:
    with sqlite3.connect(ledger) as connection:
        (count,) = connection.execute("SELECT count(*) FROM runs").fetchone()
    return int(count)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the results and the report of a quick study."""
    made = tmp_path_factory.mktemp("limits")
    done = conrod(*QUICK, "--json", "limits.json", "--out", "report", cwd=made)
    assert done.returncode == 0, done.stderr
    (made / "first.txt").write_text(done.stdout)
    return made


def study_in(folder: Path, name: str = "limits.json") -> LimitStudy:
    document: dict[str, Any] = json.loads((folder / name).read_text())
    (part,) = document["parts"].values()
    return restore(LimitStudy, part["findings"])


def test_boundaries_are_printed_and_kept_as_json(folder: Path) -> None:
    (walk,) = study_in(folder).walks
    boundary = {b.criterion: b for b in walk.boundaries}
    # Saw at 500 rpm, stock pymunk: a joint gapes by a twentieth of the travel between 30 and 100 steps.
    assert boundary["wrong"].last_good is not None
    assert boundary["wrong"].first_bad is not None
    assert 20 < boundary["wrong"].first_bad < boundary["wrong"].last_good < 100
    assert boundary["wrong"].last_good <= 1.02 * boundary["wrong"].first_bad + 1.0
    assert boundary["wrong"].outcome == "opened"
    assert boundary["wrong"].undetected
    printed = (folder / "first.txt").read_text()
    for words in ("steps", "opened (undetected)", "within 1 %", "within 10 %"):
        assert words in printed


def test_the_same_command_runs_nothing_again_and_finds_the_same(folder: Path) -> None:
    before, first = runs_in(folder / "ledger.sqlite"), study_in(folder)
    done = conrod(*QUICK, "--json", "again.json", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert runs_in(folder / "ledger.sqlite") == before
    assert study_in(folder, "again.json") == first
