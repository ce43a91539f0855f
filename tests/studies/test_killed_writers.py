"""What a killed process leaves of the files that it was writing is undone; what ends a command leaves nothing."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from conrod.studies.execution.isolation import isolated
from conrod.studies.frame.files import PLANNED, STAGING, _staging, check_writable_folder
from tests.support.command_line import conrod

FILES = {name: f"new {name}" for name in ("README.md", "results.json", "data/a.json", "figures/b.svg", "c", "d", "e")}
WRITER = f"""
import os, signal, sys
from pathlib import Path
from conrod.studies.frame.files import Batch, write_together
replace, moved = os.replace, []
def put(source, target):
    replace(source, target)
    moved.append(target)
    if len(moved) == int(sys.argv[2]):
        os.kill(os.getpid(), signal.SIGKILL)
os.replace = put
write_together([Batch(Path(sys.argv[1]), {FILES!r}, ("obsolete",))])
"""


def contents(folder: Path) -> dict[str, str]:
    return {str(file.relative_to(folder)): file.read_text() for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize("count", [3, 7])
def test_files_that_a_killed_process_has_replaced_are_put_back(count: int, tmp_path: Path) -> None:
    folder = tmp_path / "report"
    (folder / "data").mkdir(parents=True)
    for name in ("README.md", "data/a.json", "d", "obsolete", "mine"):
        (folder / name).write_text(f"old {name}")
    before = contents(folder)
    assert subprocess.run([sys.executable, "-c", WRITER, folder, str(count)], check=False).returncode == -9
    assert sum(text.startswith("new") for name, text in contents(folder).items() if STAGING not in name) == count
    (folder / "README.md").write_text("edited since")
    check_writable_folder(folder)
    assert contents(folder) == before | {"README.md": "edited since"}


def test_a_writer_that_is_alive_is_left_alone(tmp_path: Path) -> None:
    with _staging(tmp_path) as waiting:
        check_writable_folder(tmp_path)
        assert waiting.is_dir()
    assert list(tmp_path.iterdir()) == []


def test_a_planted_plan_touches_nothing_outside_its_folder(tmp_path: Path) -> None:
    precious, folder = tmp_path / "precious", tmp_path / "folder"
    precious.write_text("mine")
    (folder / f"{STAGING}x").mkdir(parents=True)
    digest = hashlib.sha256(b"mine").hexdigest()
    plan = [["../precious", digest], [str(precious), digest], ["..", None], [7, None], "nonsense"]
    for k in range(len(plan)):
        (folder / f"{STAGING}x").mkdir(exist_ok=True)
        (folder / f"{STAGING}x" / PLANNED).write_text(json.dumps(plan[k:]))
        check_writable_folder(folder)
        assert precious.read_text() == "mine"
        assert list(folder.iterdir()) == []


@pytest.mark.parametrize("refused", [("--jobs", "0"), ("--cell-timeout", "0"), ("--cluster", "x", "--jobs", "2")])
def test_a_refused_command_makes_no_ledger(refused: tuple[str, ...], tmp_path: Path) -> None:
    done = conrod("validate", "saw-500rpm", *refused, "--ledger", "new/l.sqlite", cwd=tmp_path)
    assert done.returncode == 2
    assert list(tmp_path.iterdir()) == []


def test_what_an_interpreter_prints_as_it_starts_is_no_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "sitecustomize.py").write_text("import os; os.write(1, b'9' * 1000); print('8' * 1000, flush=True)\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert isolated(os.path.basename, "a/b") == "b"
