"""Files beside a user's model are data, whatever their names: no command imports one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import command_line
import pytest
from own_model_edits import HACKSAW
from table_files import csv_text, exact_table

from conrod.scenes import SCENES
from conrod.studies.execution.local import isolated
from conrod.studies.execution.worker_process import HOME, import_path

# Of Python's library, which is searched last, and of what conrod needs; some are loaded by every interpreter.
NAMES = ("queue", "pickle", "numpy", "csv", "re", "typing", "__future__", "subprocess", "runpy", "mujoco", "ctypes")
PLANTED = "open(__file__ + '.executed', 'w').close()"
SAW = ("saw-500rpm", "--engine", "pymunk")
MODEL = ("my.xml", "--scene", "saw-40rpm", "--crank", "motor", "--point", "C=body:bow", "--revolutions", "1")
COMMANDS = {
    "limits": ("limits", *SAW, "--axis", "steps", "--preset", "stock", "--range", "40..20", "--jobs", "1"),
    "lint": ("lint", "my.xml", "--seconds", "0.1", "--json", "lint.json"),
    "harden": ("harden", "my.xml", "-o", "hard.mjb"),
    "validate MODEL": ("validate", *MODEL),
    "validate TABLE": ("validate", "t.csv", "--scene", "saw-500rpm"),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(PLANTED)
    (tmp_path / "my.xml").write_text(HACKSAW.read_text())
    (tmp_path / "t.csv").write_text(csv_text(exact_table(SCENES["saw-500rpm"], ("position",))))
    return tmp_path


def executed(folder: Path) -> list[str]:
    return [path.name for path in folder.glob("*.executed")]


# `limits` starts the workers of `python -m conrod validate`, and `harden` reads a model in the process of `lint`.
SIBLINGS = ("limits", "harden")


@pytest.mark.parametrize(
    "command", [pytest.param(name, marks=[pytest.mark.slow] if name in SIBLINGS else []) for name in COMMANDS]
)
def test_no_command_imports_what_lies_beside_a_model(folder: Path, command: str) -> None:
    done = command_line.conrod(*COMMANDS[command], cwd=folder, ledger=folder / "ledger.sqlite", own_workers=True)
    assert executed(folder) == []
    assert done.returncode == (1 if command == "lint" else 0), done.stderr  # the saw has findings


@pytest.mark.parametrize("options", [("-m", "conrod"), pytest.param(("-Bmconrod",), marks=pytest.mark.slow)])
def test_python_m_conrod_does_not_search_the_working_folder(folder: Path, options: tuple[str, ...]) -> None:
    done = start(folder, *options, "show", "saw-500rpm")
    assert executed(folder) == []
    assert done.returncode == 0, done.stderr


def test_what_is_planted_is_executed_where_python_searches_the_working_folder(folder: Path) -> None:
    # Negative control.
    start(folder, "-c", "import queue, numpy")
    assert {"queue.py.executed", "numpy.py.executed"} <= set(executed(folder))


def start(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False)


def here_and_where_from() -> tuple[list[str], str]:
    import conrod

    return sys.path, str(Path(conrod.__file__).parent.parent)


def test_a_child_imports_this_conrod_and_not_from_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", ["", *(entry for entry in sys.path if entry != HOME)])
    assert import_path()[0] == HOME
    path, home = isolated(here_and_where_from)
    assert home == HOME
    assert not {"", str(tmp_path)} & set(path)
