"""Tasks for executors, in a module of their own because a worker process imports them."""

from __future__ import annotations

import ctypes
import dataclasses
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from copy import copy
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from conrod import InvalidInput, MuJoCoSettings, PymunkSettings
from conrod.comparison.trajectory import Settings
from conrod.execution.case import Case, Study, pursue
from conrod.execution.ledger import Ledger
from conrod.execution.ledger_file import Claims
from conrod.execution.local import LocalProcesses, RetryingExecutor
from conrod.execution.run import RunCase, RunResult, measure
from conrod.execution.runner import Watcher, run_cases
from conrod.execution.worker_process import CallLimits
from conrod.scenes import SCENES
from conrod.studies.limits.case import LimitCase

SAW = SCENES["saw-500rpm"]
SETTINGS = (PymunkSettings.tuned(SAW, 20), MuJoCoSettings.hardened(SAW, 20), PymunkSettings.tuned(SAW, 30))
# Far more than any of these takes on a busy machine, and the time that a test of a hang takes.
TIMEOUT = 5.0
MEMORY = 3_000_000_000
CRASHES = 3
HERE = str(Path(__file__).parent)


def cells(count: int) -> list[RunCase]:
    """Cheap runs in both engines, every tenth watched; a task tells them apart by the angle that they start from."""
    kinds = [RunCase if k % 10 else LimitCase for k in range(count)]
    return [kind("saw-500rpm", SAW, SETTINGS[k % 3], 1.0, start_angle=1e-3 * k) for k, kind in enumerate(kinds)]


@dataclasses.dataclass(frozen=True)
class SubstitutedCase(Case):
    """A case with its key and its result type, which performs a task of a test instead."""

    study: ClassVar[str] = "sweep"

    case: RunCase
    task: Callable[[Any], RunResult]

    @property
    def result_type(self) -> type[RunResult]:  # type: ignore[override]
        """The class of the case's result."""
        return self.case.result_type

    def perform(self) -> RunResult:
        return self.task(dataclasses.replace(self.case, scene=self.scene))

    def key_fields(self) -> dict[str, Any]:
        return self.case.key_fields()

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return self.case._identity(parameters)


def substitute_task(cases: Sequence[RunCase], task: Callable[[Any], RunResult]) -> list[SubstitutedCase]:
    """Substitute a task for the run of each case."""
    return [SubstitutedCase(case.name, case.scene, case, task) for case in cases]


def number(cell: Any) -> int:
    return round(1e3 * getattr(cell, "case", cell).start_angle)


def answer_study(study: Study[Any], answer: Callable[[Any], RunResult] = lambda case: case.perform()) -> Any:
    """Findings of a study whose cases are answered by a function."""
    return pursue([study], lambda cases: {case.key: answer(case) for case in cases})[0]


def note_start(cell: Any) -> RunResult:
    """Note the start in a file that the environment names; return when another process has started, or hang."""
    own, others = (Path(os.environ[name]) for name in ("CONROD_STARTS", "CONROD_OTHER_STARTS"))
    with own.open("a", encoding="ascii") as file:
        file.write(f"{number(cell)}\n")
    while "CONROD_HANGS" in os.environ or not others.exists():
        time.sleep(0.01)
    return RunResult("completed", str(number(cell)))


class EndPrinter(Watcher):
    """Watcher that prints how each cell ended."""

    def on_case_end(self, case: Case, how: str) -> None:
        print(how, flush=True)


def main(ledger: str, count: str, task: str, jobs: str) -> None:
    """Run a number of cells, or a named task for each, on a ledger; print their reasons in the end."""
    if "CONROD_SELFISH" in os.environ:
        Claims.take = lambda self, name: True  # type: ignore[method-assign]
    asked: Sequence[Case] = cells(int(count))
    asked = substitute_task(cells(int(count)), globals()[task]) if task else asked
    with Ledger.open(Path(ledger)) as opened, LocalProcesses(int(jobs)) as executor:
        print([m.reason for m in run_cases(asked, opened, executor, watcher=EndPrinter()).values()])


@contextmanager
def cells_in_process(
    ledger: Path, count: int, task: str = "", jobs: int = 2, **environment: str
) -> Iterator[subprocess.Popen[str]]:
    """Run `main` in a separate process, which is killed at the end of the context."""
    # Not by `python -m`: its workers have to find the tasks in a module of this name.
    code = f"import sys; sys.path.insert(0, {HERE!r}); import cell_tasks; cell_tasks.main(*sys.argv[1:])"
    asked = [sys.executable, "-c", code, str(ledger), str(count), task, str(jobs)]
    with subprocess.Popen(asked, stdout=subprocess.PIPE, text=True, env=os.environ | environment) as begun:
        try:
            yield begun
        finally:
            begun.kill()


class ActingWatcher(Watcher):
    """Watcher that calls a function after a number of results, and keeps the numbers of their cells."""

    def __init__(self, count: int, act: Callable[[], None]) -> None:
        self.count, self.act, self.seen = count, act, list[int]()

    def on_case_end(self, case: Case, how: str) -> None:
        self.seen.append(number(case))
        if len(self.seen) == self.count:
            self.act()


class InProcessExecutor(RetryingExecutor):
    """Executor that makes its calls in this process one by one, and keeps their cases."""

    def __init__(self, limits: CallLimits | None = None) -> None:
        super().__init__(limits or CallLimits(), 64, 1)
        self.cases: list[Case] = []

    @property
    def ran(self) -> list[int]:
        return [number(case) for case in self.cases]

    def call(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        self.cases.append(arguments[-1])
        return function(*arguments, **named)

    def stop(self) -> None: ...


def echo(cell: RunCase) -> RunResult:
    return RunResult("completed", str(number(cell)))


def count_processes(cell: RunCase) -> RunResult:
    return RunResult("completed", str(os.getpid()))


def refuse(cell: RunCase) -> RunResult:
    if number(cell) == CRASHES:
        raise InvalidInput("this cell cannot be run")
    return echo(cell)


def kill_dask_worker(cell: RunCase) -> RunResult:
    """Kill the Dask worker of one cell, as a batch system does when memory runs out."""
    if number(cell) == CRASHES:
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(1000.0)
    time.sleep(0.05)
    return echo(cell)


def name_by_folder(folder: Path, cells: list[RunCase]) -> list[RunCase]:
    """The cells, with a folder for their tasks to write to."""
    return [dataclasses.replace(cell, name=str(folder)) for cell in cells]


KILLS = {3: signal.SIGKILL, 7: signal.SIGTERM}


def die_at_first_attempt(cell: RunCase) -> RunResult:
    """Kill the process of some cells at the first attempt; each attempt leaves a file with its span of time."""
    span = Path(cell.name) / f"{number(cell)}-{os.getpid()}"
    begun, first = time.monotonic(), not list(Path(cell.name).glob(f"{number(cell)}-*"))
    span.write_text(f"{begun} inf")
    time.sleep(0.05)
    if first and number(cell) in KILLS:
        os.kill(os.getpid(), KILLS[number(cell)])
        time.sleep(1000.0)
    span.write_text(f"{begun} {time.monotonic()}")
    return echo(cell)


# -- what engines do to their process ----------------------------------------------------------------------------------

HELD: list[Any] = []


def unchecked_settings(settings: Settings, **changes: Any) -> Settings:
    """Settings with values that their class refuses, for tests of the engine's reaction."""
    changed = copy(settings)
    for name, value in changes.items():
        object.__setattr__(changed, name, value)
    return changed


def abort() -> None:
    """Abort by an engine's own assertion."""
    measure(RunCase("saw-500rpm", SAW, unchecked_settings(SETTINGS[0], iterations=0)))


def segfault() -> None:
    """Read from address 0."""
    ctypes.string_at(0)


def hang() -> None:
    """Wait in C, where no Python signal gets through, for a lock that this thread has itself."""
    c, lock = ctypes.CDLL(None), ctypes.create_string_buffer(256)
    c.pthread_mutex_init(lock, None)
    while True:
        c.pthread_mutex_lock(lock)


def hoard() -> None:
    """Take memory to the last kilobyte and keep it; large pieces stay untouched, to spare other processes."""
    size = 1 << 30
    while True:
        try:
            HELD.append(np.empty(size, dtype=np.uint8))
        except MemoryError:
            if size < 1024:
                raise
            size //= 2


AGAIN = "ended by signal SIGKILL, and again with nothing beside it"
# By the number of a cell, what it does, and how it ends.
FAULTS: dict[int, tuple[Callable[[], Any], str, str]] = {
    CRASHES: (abort, "crashed", "ended by signal SIGABRT"),
    7: (hang, "timed-out", "no result after 5 s"),
    11: (hoard, "out-of-memory", "the limit was 3000000000 bytes more than it began with"),
    13: (lambda: os._exit(3), "crashed", "ended with status 3"),
    17: (segfault, "crashed", "ended by signal SIGSEGV"),
    19: (lambda: os.kill(os.getpid(), signal.SIGKILL), "crashed", AGAIN),
}


def misbehave(cell: RunCase) -> RunResult:
    """Run a cell; six of every twenty commit one of `FAULTS` first."""
    FAULTS.get(number(cell) % 20, (lambda: None,))[0]()
    return cell.perform()


def check_that_faults_cost_their_own_cells(count: int, ledger: Ledger, executor: RetryingExecutor) -> None:
    """Check that each of a number of cells ends as its fault does, or completes."""
    table, ends = run_cases(substitute_task(cells(count), misbehave), ledger, executor), (None, "completed", "")
    assert {key: (found.outcome, found.reason) for key, found in table.items()} == {
        cell.key: FAULTS.get(number(cell) % 20, ends)[1:] for cell in cells(count)
    }
    assert table == ledger.results({cell.key: cell for cell in cells(count)})
    limits = {7: ("timed-out", TIMEOUT), 11: ("out-of-memory", float(MEMORY))}
    stopped = {cell.key: limits.get(number(cell) % 20) for cell in cells(count)}
    assert ledger.stops_at_limits(table) == {key: limit for key, limit in stopped.items() if limit}


def hoard_all_but(megabytes: int) -> None:
    """Take all memory except some megabytes, and keep it."""
    kept_free = np.empty(megabytes << 20, dtype=np.uint8)
    with suppress(MemoryError):
        hoard()
    del kept_free


def engine_with_little(megabytes: int) -> RunResult:
    """A MuJoCo run in a process that has little memory left; it fails in the engine's own ways."""
    hoard_all_but(megabytes)
    return measure(RunCase("saw-500rpm", SAW, MuJoCoSettings.hardened(SAW, 2000), 1.0))


def mistake_with_little(megabytes: int) -> RunResult:
    hoard_all_but(megabytes)
    raise ZeroDivisionError("a mistake in the task")


def wrong_value(megabytes: int) -> RunResult:
    raise ValueError("a mistake in the task")


# -- what an engine or an FMU forks ------------------------------------------------------------------------------------


def fork_and_abort(how: str, note: str) -> None:
    """Leave a process behind that holds all that this one has open, and abort."""
    execs = how in ("exec", "session")
    if execs:
        left = subprocess.Popen(["sleep", "600"], close_fds=False, start_new_session=how == "session").pid
    else:
        left = os.fork()
        if left == 0:
            if how == "double fork" and os.fork():
                os._exit(0)
            Path(note + ".own").write_text(str(os.getpid()))
            while True:
                time.sleep(1.0)
    while not execs and not (Path(note + ".own").exists() and Path(note + ".own").read_text()):
        time.sleep(0.01)
    Path(note).write_text(str(left) if execs else Path(note + ".own").read_text())
    os.abort()


def fork_and_return() -> int:
    """The process that serves the call, from both the process and its copy; the copy comes back first."""
    served_by = os.getpid()
    if copy := os.fork():
        os.waitpid(copy, 0)
    return served_by


def write_into_strays(first: int, last: int) -> str:
    """Write a text into all descriptors of a range, as a faulty FMU may into conrod's files."""
    for descriptor in range(first, last):
        with suppress(OSError):
            os.write(descriptor, b"a line that is meant for a log\n")
    return "written"


def print_hostile() -> None:
    """Print escapes as an engine, or a library in it, may."""
    print("\x1b[2J\u202egnp", flush=True)
    os.write(2, "\x1b]0;owned\x07\u202egnp\n".encode())
