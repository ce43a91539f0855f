"""conrod attacked, as `make attack` does: nothing ends in a traceback, takes over a minute, is lost, or is executed.

What is tried comes from one seed, `CONROD_ATTACK_SEED`: another one tries others. Times are CPU times, so that a
machine under load does not decide.
"""

from __future__ import annotations

import csv
import os
import pickle
import random
import shutil
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import closing
from pathlib import Path
from typing import Any

import cell_tasks as tasks
import model_mutants as models
import pytest

from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.results_table import TIMED
from conrod.studies.frame.writing import TEMPORARY
from tests.support.command_line import conrod

pytestmark = pytest.mark.slow

SEED = int(os.environ.get("CONROD_ATTACK_SEED", "1"))
LONGEST = 60.0  # [s]
MODELS, KILLS = 1000, 20
PATIENCE, MEMORY = 600.0, 6_000_000_000  # [s] of wall time, [bytes]: of a worker that has many of them


# Modules of Python's own library and of others, which a user's file may be called as.
MODULES = ("queue", "pickle", "json", "numpy", "mujoco", "random", "csv", "signal", "sitecustomize", "click")
SWEEP = ("sweep", "saw-500rpm", "--engine", "pymunk", "--grid", "coarse", "--jobs", "2", "--ledger", "l.sqlite")
REPORT = "report"


class Payload:
    """An object that leaves a mark where its pickle is read."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str, int]]:
        return os.mkdir, (str(self.mark), 0o700)


def planted(folder: Path, mark: Path) -> Path:
    """A folder with files of which each leaves a mark where it is executed."""
    for name in MODULES:
        (folder / f"{name}.py").write_text(f"import os\nos.makedirs({str(mark)!r}, exist_ok=True)\n", encoding="utf-8")
    (folder / "payload.pickle").write_bytes(pickle.dumps(Payload(mark)))
    return folder


def begun(*arguments: str) -> subprocess.Popen[str]:
    """A command under way, in the working folder."""
    with Path("errors.txt").open("a", encoding="utf-8") as errors:
        command = [sys.executable, "-m", "conrod", *arguments]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, text=True)


def kept(ledger: Path) -> int:
    """Number of results in a ledger, which may not be there yet."""
    if not ledger.exists():
        return 0
    with closing(sqlite3.connect(ledger, timeout=60.0)) as connection:
        if not connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'runs'").fetchone():
            return 0
        return int(connection.execute("SELECT count(*) FROM runs").fetchone()[0])


def killed(process: subprocess.Popen[str], now: Callable[[], bool]) -> bool:
    """Kill a process once something is so; False where it has ended before."""
    while process.poll() is None:
        if now():
            process.kill()
            return process.wait() == -9
        time.sleep(0.002)
    return False


@pytest.fixture
def arena(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working folder with files that nothing may execute, and which is left as it was."""
    folder, mark = tmp_path / "arena", tmp_path / "executed"
    folder.mkdir()
    monkeypatch.chdir(planted(folder, mark))
    yield folder
    assert not mark.exists()


@pytest.fixture
def report(capsys: pytest.CaptureFixture[str]) -> Callable[[str], None]:
    """Prints a line of what was counted, with the CPU time that it took."""
    begun = sum(os.times()[:4])

    def say(text: str) -> None:
        took = sum(os.times()[:4]) - begun
        with capsys.disabled():
            print(f"\nattack, seed {SEED}: {text}; {took:.0f} s of CPU time")

    return say


def test_what_is_planted_is_executed_by_who_looks_for_it(tmp_path: Path) -> None:
    # Negative control.
    mark = tmp_path / "executed"
    planted(tmp_path, mark)
    subprocess.run([sys.executable, "-c", "import queue"], cwd=tmp_path, check=True)
    assert mark.exists()
    mark.rmdir()
    pickle.loads((tmp_path / "payload.pickle").read_bytes())
    assert mark.exists()


def test_models(arena: Path, report: Callable[[str], None]) -> None:
    cases = [
        (base, f"{SEED} {k}", models.VERBS[k // len(models.MODELS) % len(models.VERBS)], arena)
        for k, base in zip(range(MODELS), len(models.MODELS) * MODELS * [*models.MODELS], strict=False)
    ]
    with LocalProcesses(2, cell_timeout=PATIENCE, cell_memory=MEMORY) as executor:
        tries = [executor.submit(models.tried, *case) for case in cases]
        ends = [ended(future, case) for future, case in zip(tries, cases, strict=True)]
    wrong = [f"{case[0].name}, mutant {case[1]}, {case[2]}: {end.wrong}" for case, end in zip(cases, ends, strict=True)]
    wrong = [line for line, end in zip(wrong, ends, strict=True) if end.wrong]
    status = Counter(end.status for end in ends)
    slowest = max(end.seconds for end in ends)
    report(
        f"{MODELS} mutated models through {', '.join(models.VERBS)}: {status[0] + status[1]} answered, "
        f"{status[2]} refused in one line, {len(wrong)} tracebacks, the longest {slowest:.1f} s"
    )
    assert wrong == []
    assert slowest < LONGEST
    assert min(status[2], status[0] + status[1]) > MODELS // 10
    kept = {path.name.split("-", 1)[1] for path in arena.glob("*.xml")}
    assert kept == {base.name for base in models.MODELS}


def ended(future: Future[models.End], case: Any) -> models.End:
    """How a mutant ended; one that took down its process is tried again as a user would, who is to see one line."""
    try:
        return future.result()
    except Exception:
        before = sum(os.times()[2:4])  # of children
        end = models.attempt(*case)
        return models.End(end.status, end.wrong, sum(os.times()[2:4]) - before)


def test_kills_of_a_sweep(arena: Path, report: Callable[[str], None]) -> None:
    chance, ledger, out = random.Random(f"kills {SEED}"), arena / "l.sqlite", arena / REPORT
    assert begun(*SWEEP[:-1], "undisturbed.sqlite").wait() == 0
    wanted, kills = kept(arena / "undisturbed.sqlite"), 0
    while kills < KILLS:
        before = kept(ledger)
        goal = before + min(chance.randint(1, 4), (wanted - before) // (KILLS - kills))
        kills += killed(begun(*SWEEP), lambda goal=goal: kept(ledger) >= goal)
        assert kept(ledger) >= before
    command = (*SWEEP, "--out", REPORT)
    assert begun(*command).wait() == 0
    assert rows(ledger) == rows(arena / "undisturbed.sqlite")
    whole = files(out)
    # At any step of writing: tests/studies/test_killed_writers.py. Here whatever a few kills hit, or come too late for.
    for _ in range(4):
        shutil.rmtree(out)
        killed(begun(*command), lambda: any(out.glob("**/*")))
        assert conrod("report", REPORT).returncode == (0 if any(out.glob("data/*.json")) else 2)
        assert begun(*command).wait() == 0
        assert {name: text for name, text in files(out).items() if not Path(name).name.startswith(TEMPORARY)} == whole
    assert rows(ledger) == rows(arena / "undisturbed.sqlite")
    assert "Traceback" not in (arena / "errors.txt").read_text(encoding="utf-8")
    report(f"{kills} kills of a sweep: {wanted} runs, none lost, none other")


def rows(ledger: Path) -> list[dict[str, str]]:
    """The table of a ledger, without what a clock says."""
    assert conrod("results", "--ledger", str(ledger), "--csv", "r.csv").returncode == 0
    with Path("r.csv").open(encoding="utf-8", newline="") as table:
        return [{name: value for name, value in row.items() if name not in TIMED} for row in csv.DictReader(table)]


def files(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_faults_in_cells(arena: Path, report: Callable[[str], None]) -> None:
    limits: Any = {"cell_timeout": tasks.TIMEOUT, "cell_memory": tasks.MEMORY}
    with Ledger.open(arena / "l.sqlite") as ledger, LocalProcesses(2, **limits) as executor:
        tasks.check_that_faults_cost_their_own_cells(80, ledger, executor)
    report("24 faults in 80 cells, each the outcome of its own cell")
