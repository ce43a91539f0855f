"""conrod attacked, as `make attack` does: nothing ends in a traceback, takes over a minute, is lost, or is executed.

What is tried comes from one seed, `CONROD_ATTACK_SEED`: another one tries others. Times are CPU times, so that a
machine under load does not decide.
"""

from __future__ import annotations

import csv
import hashlib
import json
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
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import cell_tasks as tasks
import model_mutants as models
import pytest

from conrod.execution.ledger import Ledger
from conrod.execution.local import LocalProcesses
from conrod.execution.results_table import TIMING_FIELDS
from conrod.execution.runner import available_cores
from conrod.execution.writing import TEMPORARY_PREFIX
from tests.support.command_line import conrod

pytestmark = pytest.mark.slow

SEED = int(os.environ.get("CONROD_ATTACK_SEED", "1"))
LONGEST = 60.0  # [s]
MODELS, KILLS = 1000, 20
WORKERS = available_cores()
BUDGET = float(os.environ.get("CONROD_ATTACK_SECONDS", "900"))  # [s] of CPU time for mutated models, in one go
ROOT = Path(__file__).parents[2]
PATIENCE, MEMORY = 600.0, 6_000_000_000  # [s] of wall time, [bytes]: of a worker that has many of them


# Modules of Python's own library and of others, which a user's file may be called as.
MODULES = ("queue", "pickle", "json", "numpy", "mujoco", "random", "csv", "signal", "sitecustomize", "click")
# Studies that are killed, and how often.
STUDIES = {
    ("sweep", "saw-500rpm", "--engine", "pymunk", "--grid", "coarse", "--jobs", "2"): KILLS,
    ("limits", "saw-500rpm", "--engine", "pymunk", "--preset", "stock", "--axis", "mass-ratio"): 8,
    ("ablate", "saw-500rpm", "--engine", "pymunk", "--rounds", "4"): 8,
}
REPORT = "report"


class Payload:
    """An object that leaves a mark where its pickle is read."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str, int]]:
        return os.mkdir, (str(self.mark), 0o700)


def plant_payloads(folder: Path, mark: Path) -> Path:
    """A folder with files of which each leaves a mark where it is executed."""
    for name in MODULES:
        (folder / f"{name}.py").write_text(f"import os\nos.makedirs({str(mark)!r}, exist_ok=True)\n", encoding="utf-8")
    (folder / "payload.pickle").write_bytes(pickle.dumps(Payload(mark)))
    return folder


def start_command(*arguments: str) -> subprocess.Popen[str]:
    """A command under way, in the working folder."""
    with Path("errors.txt").open("a", encoding="utf-8") as errors:
        command = [sys.executable, "-m", "conrod", *arguments]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, text=True)


def result_count(ledger: Path) -> int:
    """Number of results in a ledger, which may not be there yet."""
    if not ledger.exists():
        return 0
    with closing(sqlite3.connect(ledger, timeout=60.0)) as connection:
        if not connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'runs'").fetchone():
            return 0
        return int(connection.execute("SELECT count(*) FROM runs").fetchone()[0])


def kill_when(process: subprocess.Popen[str], now: Callable[[], bool]) -> bool:
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
    monkeypatch.chdir(plant_payloads(folder, mark))
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


def test_planted_payload_is_executed_when_loaded(tmp_path: Path) -> None:
    # Negative control.
    mark = tmp_path / "executed"
    plant_payloads(tmp_path, mark)
    subprocess.run([sys.executable, "-c", "import queue"], cwd=tmp_path, check=True)
    assert mark.exists()
    mark.rmdir()
    pickle.loads((tmp_path / "payload.pickle").read_bytes())
    assert mark.exists()


def test_mutated_models_are_answered_or_refused_in_one_line(arena: Path, report: Callable[[str], None]) -> None:
    cases = [
        (base, f"{SEED} {k}", models.VERBS[k // len(models.MODELS) % len(models.VERBS)], arena)
        for k, base in zip(range(MODELS), len(models.MODELS) * MODELS * [*models.MODELS], strict=False)
    ]
    record = Record(f"models-{SEED}")
    before, spent = len(record.ends), 0.0
    left = [k for k in range(MODELS) if k not in record.ends]
    try:
        with LocalProcesses(WORKERS, timeout=PATIENCE, memory=MEMORY) as executor:
            while left and spent < BUDGET:
                some, left = left[: 4 * WORKERS], left[4 * WORKERS :]
                tries = [executor.submit(models.attempt_here, *cases[k]) for k in some]
                for k, future in zip(some, tries, strict=True):
                    record.keep(k, end_of_mutant(future, cases[k]))
                    spent += record.ends[k].seconds
    finally:  # also where it is stopped
        ends = record.ends
        wrong = [
            f"{cases[k][0].name}, mutant {cases[k][1]}, {cases[k][2]}: {ends[k].wrong}" for k in ends if ends[k].wrong
        ]
        status = Counter(end.status for end in ends.values())
        slowest = max((end.seconds for end in ends.values()), default=0.0)
        report(
            f"{len(ends)} of {MODELS} mutated models ({before} of them before) through {', '.join(models.VERBS)}: "
            f"{status[0] + status[1]} answered, {status[2]} refused in one line, {len(wrong)} tracebacks, the longest "
            f"{slowest:.1f} s, {sum(end.seconds for end in ends.values()):.0f} s of CPU time in all"
        )
    assert wrong == []
    assert slowest < LONGEST
    if left:
        pytest.skip(f"{len(left)} mutated models are left after {BUDGET:.0f} s of CPU time: the same command goes on")
    assert min(status[2], status[0] + status[1]) > MODELS // 10
    kept = {path.name.split("-", 1)[1] for path in arena.glob("*.xml")}
    assert kept == {base.name for base in models.MODELS} or before


class Record:
    """How mutants ended, kept in a file until conrod or the attack is another, so that a stopped attack goes on.

    Attributes:
        ends: by number of the mutant.
    """

    def __init__(self, name: str) -> None:
        digest = hashlib.sha256()
        for folder in ("src", "tests/attack", "tests/support"):
            for file in sorted((ROOT / folder).rglob("*.py")):
                digest.update(file.read_bytes())
        self._file = ROOT / ".attack" / f"{name}-{digest.hexdigest()[:12]}.jsonl"
        self._file.parent.mkdir(exist_ok=True)
        self.ends = dict[int, models.End]()
        for line in self._file.read_text(encoding="utf-8").splitlines() if self._file.exists() else ():
            with suppress(ValueError, TypeError):  # the last line of one that was killed
                number, *end = json.loads(line)
                self.ends[number] = models.End(*end)

    def keep(self, number: int, end: models.End) -> None:
        """Keep how a mutant ended."""
        self.ends[number] = end
        with self._file.open("a", encoding="utf-8") as file:
            file.write(json.dumps([number, end.status, end.wrong, end.seconds]) + "\n")


def test_a_stopped_attack_goes_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys.modules[__name__], "ROOT", tmp_path)
    first = Record("models-1")
    first.keep(3, models.End(2, "", 0.5))
    with first._file.open("a") as file:
        file.write("[4, 2, ")
    assert Record("models-1").ends == {3: models.End(2, "", 0.5)}
    assert Record("models-2").ends == {}
    (tmp_path / "src").mkdir()
    (tmp_path / "src/other.py").write_text("")
    assert Record("models-1").ends == {3: models.End(2, "", 0.5)}
    (tmp_path / "src/other.py").write_text("x = 1")
    assert Record("models-1").ends == {}  # of another conrod


def end_of_mutant(future: Future[models.End], case: Any) -> models.End:
    """How a mutant ended; one that took down its process is tried again as a user would, who is to see one line."""
    try:
        return future.result()
    except Exception:
        before = sum(os.times()[2:4])  # of children
        end = models.attempt(*case)
        return models.End(end.status, end.wrong, sum(os.times()[2:4]) - before)


@pytest.mark.parametrize(("study", "most"), STUDIES.items(), ids=[study[0] for study in STUDIES])
def test_killed_study_loses_no_run_and_no_report(
    study: tuple[str, ...], most: int, arena: Path, report: Callable[[str], None]
) -> None:
    chance, ledger, out = random.Random(f"kills {study[0]} {SEED}"), arena / "l.sqlite", arena / REPORT
    study = (*study, "--ledger", "l.sqlite")
    assert start_command(*study[:-1], "undisturbed.sqlite").wait() == 0
    wanted, kills = result_count(arena / "undisturbed.sqlite"), 0
    while kills < most:
        before = result_count(ledger)
        goal = before + min(chance.randint(1, 4), (wanted - before) // (most - kills))
        kills += kill_when(start_command(*study), lambda goal=goal: result_count(ledger) >= goal)
        assert result_count(ledger) >= before
    command = (*study, "--out", REPORT)
    assert start_command(*command).wait() == 0
    assert rows(ledger) == rows(arena / "undisturbed.sqlite")
    whole = files(out)
    # At any step of writing: tests/studies/test_killed_writers.py. Here whatever a few kills hit, or come too late for.
    for _ in range(4):
        shutil.rmtree(out)
        kill_when(start_command(*command), lambda: any(out.glob("**/*")))
        assert conrod("report", REPORT).returncode == (0 if any(out.glob("data/*.json")) else 2)
        assert start_command(*command).wait() == 0
        assert {
            name: text for name, text in files(out).items() if not Path(name).name.startswith(TEMPORARY_PREFIX)
        } == whole
    assert rows(ledger) == rows(arena / "undisturbed.sqlite")
    assert "Traceback" not in (arena / "errors.txt").read_text(encoding="utf-8")
    report(f"{kills} kills of {study[0]}: {wanted} runs, none lost, none other")


def rows(ledger: Path) -> list[dict[str, str]]:
    """The table of a ledger, without what a clock says."""
    assert conrod("results", "--ledger", str(ledger), "--csv", "r.csv").returncode == 0
    with Path("r.csv").open(encoding="utf-8", newline="") as table:
        return [
            {name: value for name, value in row.items() if name not in TIMING_FIELDS} for row in csv.DictReader(table)
        ]


def files(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_fault_in_a_case_costs_that_case_alone(arena: Path, report: Callable[[str], None]) -> None:
    limits: Any = {"timeout": tasks.TIMEOUT, "memory": tasks.MEMORY}
    with Ledger.open(arena / "l.sqlite") as ledger, LocalProcesses(2, **limits) as executor:
        tasks.check_that_faults_cost_their_own_cells(80, ledger, executor)
    report("24 faults in 80 cells, each the outcome of its own cell")
