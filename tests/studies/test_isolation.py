"""A run that kills its process, hangs or eats all memory is an outcome, of that run alone."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import cell_tasks as planted
import command_line
import pytest
from cell_tasks import MEMORY
from own_model_edits import HACKSAW
from table_files import csv_text, exact_table

from conrod import InvalidInput, PymunkSettings, Saw, run
from conrod.execution.local import LocalProcesses, call_isolated
from conrod.execution.worker_process import WorkerDied
from conrod.scenes import SCENES

SAW = Saw()
SETTINGS = PymunkSettings.tuned(SAW, 100)


def mistake() -> None:
    raise ZeroDivisionError("a mistake in the task")


def test_mistakes_are_raised_with_their_traceback() -> None:
    with pytest.raises(ZeroDivisionError, match="a mistake") as raised:
        call_isolated(mistake)
    assert Path(__file__).name in raised.value.__notes__[0]
    with pytest.raises(InvalidInput, match="timestep"):
        call_isolated(run, SAW.with_parameters(speed=1.0), SETTINGS, 1.0)


# With 3 MB MuJoCo's library cannot be loaded (ImportError), with 16 its compiler gives up (ValueError).
def test_engine_without_memory_is_out_of_memory_for_any_message() -> None:
    with LocalProcesses(1, memory=MEMORY) as executor:
        for megabytes in (3, 16):
            with pytest.raises(MemoryError, match="3000000000 bytes"):
                executor.submit(planted.engine_with_little, megabytes).result()
        # Negative control.
        assert executor.submit(planted.engine_with_little, 256).result().outcome == "completed"


def test_a_mistake_under_a_memory_limit_is_a_mistake() -> None:
    with LocalProcesses(1, memory=MEMORY) as executor:
        with pytest.raises(ValueError, match="a mistake"):
            executor.submit(planted.wrong_value, 16).result()
        with pytest.raises(ZeroDivisionError, match="a mistake"):
            executor.submit(planted.mistake_with_little, 16).result()


# -- what an engine or an FMU forks ------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", [pytest.param("fork", marks=pytest.mark.slow), "exec", "double fork", "session"])
def test_call_that_forks_and_aborts_leaves_no_process(how: str, tmp_path: Path) -> None:
    begun, note = time.monotonic(), tmp_path / "pids"
    with LocalProcesses(1, timeout=60.0) as executor, pytest.raises(WorkerDied, match="ended by signal SIGABRT"):
        executor.submit(planted.fork_and_abort, how, str(note)).result()
    assert time.monotonic() - begun < 30.0
    for pid in map(int, note.read_text().split()):
        assert gone(pid), f"{how}: process {pid} is left"


def gone(pid: int) -> bool:
    """True if a process ends within a second; what has ended and nobody waits for counts as ended."""
    for _ in range(20):
        try:
            if "State:\tZ" in Path(f"/proc/{pid}/status").read_text():
                return True
        except OSError:
            return True
        time.sleep(0.05)
    return False


def test_answer_of_a_fork_is_no_answer_to_the_next_call() -> None:
    with LocalProcesses(1) as executor:
        first = executor.submit(planted.fork_and_return).result()
        assert executor.submit(os.path.join, "a", "b").result() == "a/b"
        assert executor.submit(os.getpid).result() == first


def test_write_to_stray_descriptors_fails_at_most_its_own_call() -> None:
    with LocalProcesses(1) as executor:
        assert executor.submit(planted.write_into_strays, 3, 100).result() == "written"
        with pytest.raises(WorkerDied, match="conrod's connection"):
            executor.submit(planted.write_into_strays, 3, 300).result()
        assert executor.submit(os.path.join, "a", "b").result() == "a/b"


# -- files beside a user's model are data ------------------------------------------------------------------------------

# Of Python's library, which is searched last, and of what conrod needs; some are loaded by every interpreter.
NAMES = ("queue", "pickle", "numpy", "csv", "re", "typing", "__future__", "subprocess", "runpy", "mujoco", "ctypes")
PLANTED = "open(__file__ + '.executed', 'w').close()"
COMMANDS = (
    ("lint", "my.xml", "--seconds", "0.1", "--json", "lint.json"),
    ("check", "my.xml", "--scene", "saw-40rpm", "--crank", "motor", "--point", "C=body:bow", "--revolutions", "1"),
    ("check", "t.csv", "--scene", "saw-500rpm"),
)


@pytest.fixture(scope="module")
def table() -> str:
    return csv_text(exact_table(SCENES["saw-500rpm"], ("position",)))


@pytest.fixture
def folder(tmp_path: Path, table: str) -> Path:
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(PLANTED)
    (tmp_path / "my.xml").write_text(HACKSAW.read_text())
    (tmp_path / "t.csv").write_text(table)
    return tmp_path


def executed(folder: Path) -> list[str]:
    return [path.name for path in folder.glob("*.executed")]


@pytest.mark.usefixtures("started_anew")
@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: " ".join(command[:2]))
def test_no_command_imports_what_lies_beside_a_model(folder: Path, command: tuple[str, ...]) -> None:
    done = command_line.conrod(*command, cwd=folder, ledger=folder / "ledger.sqlite", own_workers=True)
    assert executed(folder) == []
    assert done.returncode == (1 if command[0] == "lint" else 0), done.stderr  # the saw has findings


def test_python_m_conrod_does_not_search_the_working_folder(folder: Path) -> None:
    done = start(folder, "-m", "conrod", "show", "saw-500rpm")
    assert executed(folder) == []
    assert done.returncode == 0, done.stderr
    # Negative control.
    start(folder, "-c", "import queue, numpy")
    assert {"queue.py.executed", "numpy.py.executed"} <= set(executed(folder))


def start(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False)


# -- a process that is given little memory by whoever started it -------------------------------------------------------


def test_too_little_memory_for_linear_algebra_is_one_line(tmp_path: Path) -> None:
    command = f"ulimit -v 250000; exec {sys.executable} -m conrod validate saw-40rpm --ledger l.sqlite"
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert "allowed here (ulimit -v)" in done.stderr
