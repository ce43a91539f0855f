"""Tasks for executors, in a module of their own because a worker process imports them."""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from conrod import InvalidInput, PymunkSettings, Saw
from conrod.studies.execution.dispatch import Watcher, run_cases
from conrod.studies.execution.local import LocalProcesses, RepeatingExecutor
from conrod.studies.execution.worker_process import Limits
from conrod.studies.frame.case import Case, Measurement
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.ledger_file import Claims
from conrod.studies.frame.run import RunCase

SAW = Saw()
BASE = PymunkSettings.tuned(SAW, 20)
# Far more than any trivial task takes on a busy machine, and the time that a test of a hang takes.
TIMEOUT = 5.0
MEMORY = 3_000_000_000
CRASHES, HANGS, HOARDS, LEAVES = 3, 7, 11, 13
HERE = str(Path(__file__).parent)


def cells(count: int, steps: int = 20) -> list[RunCase]:
    """Cheap runs that differ in the angle that they start from; a task tells them apart by it."""
    settings = dataclasses.replace(BASE, steps_per_revolution=steps, timestep=BASE.timestep * 20 / steps)
    return [RunCase("saw-500rpm", SAW, settings, revolutions=1.0, start_angle=1e-3 * k) for k in range(count)]


@dataclasses.dataclass(frozen=True)
class Assigned(Case):
    """A case in place of which a task of a test is done; its key is that of the case."""

    case: RunCase
    task: Callable[[Any], Measurement]

    def perform(self) -> Measurement:
        return self.task(dataclasses.replace(self.case, scene=self.scene))

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return self.case._identity(parameters)


def assigned(cases: Sequence[RunCase], task: Callable[[Any], Measurement]) -> list[Assigned]:
    """The cases, each with what is to be done in its place."""
    return [Assigned(case.name, case.scene, case, task) for case in cases]


def number(cell: Case) -> int:
    run = cell.case if isinstance(cell, Assigned) else cell
    assert isinstance(run, RunCase)
    return round(1e3 * run.start_angle)


def noted(cell: Any) -> Measurement:
    """Note the start in a file that the environment names, and end when another process has started, too; or hang."""
    own, others = (Path(os.environ[name]) for name in ("CONROD_STARTS", "CONROD_OTHER_STARTS"))
    with own.open("a", encoding="ascii") as file:
        file.write(f"{number(cell)}\n")
    while "CONROD_HANGS" in os.environ or not others.exists():
        time.sleep(0.01)
    return Measurement("completed", str(number(cell)))


class Told(Watcher):
    """Prints how each cell ended."""

    def advanced(self, case: Case, how: str) -> None:
        print(how, flush=True)


def main(ledger: str, count: str, task: str, jobs: str) -> None:
    """Run so many cells on a ledger, with a task in their place if it is named; prints their reasons in the end."""
    if "CONROD_SELFISH" in os.environ:
        Claims.take = lambda self, name: True  # type: ignore[method-assign]
    asked: Sequence[Case] = cells(int(count))
    asked = assigned(cells(int(count)), globals()[task]) if task else asked
    with Ledger.open(Path(ledger)) as opened, LocalProcesses(int(jobs)) as executor:
        print([m.reason for m in run_cases(asked, opened, executor, watcher=Told()).values()])


@contextmanager
def running(
    ledger: Path, count: int, task: str = "", jobs: int = 2, **environment: str
) -> Iterator[subprocess.Popen[str]]:
    """A process of its own that does so, killed in the end."""
    # Not by `python -m`: its workers have to find the tasks in a module of this name.
    code = f"import sys; sys.path.insert(0, {HERE!r}); import cell_tasks; cell_tasks.main(*sys.argv[1:])"
    asked = [sys.executable, "-c", code, str(ledger), str(count), task, str(jobs)]
    with subprocess.Popen(asked, stdout=subprocess.PIPE, text=True, env=os.environ | environment) as begun:
        try:
            yield begun
        finally:
            begun.kill()


class Here(RepeatingExecutor):
    """Runs everything at once in the calling thread, and keeps which cases it ran."""

    def __init__(self, limits: Limits | None = None) -> None:
        super().__init__(limits or Limits(), 64, 1)
        self.cases: list[Case] = []

    @property
    def ran(self) -> list[int]:
        return [number(case) for case in self.cases]

    def submit(self, fn, /, *args, **kwargs):  # type: ignore[no-untyped-def]
        self.cases.append(args[-1])
        future: Future[Measurement] = Future()
        future.set_running_or_notify_cancel()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future

    def call(self, function, *arguments, **named): ...  # type: ignore[no-untyped-def]

    def stop(self) -> None: ...


def echo(cell: RunCase) -> Measurement:
    return Measurement("completed", str(number(cell)))


def count_processes(cell: RunCase) -> Measurement:
    return Measurement("completed", str(os.getpid()))


def misbehave(cell: RunCase) -> Measurement:
    """Most do what they should; every tenth, and some others, do to their process what engines do."""
    k = number(cell)
    if k == HANGS:
        time.sleep(1000.0)
    if k == HOARDS:
        bytearray(2 * MEMORY)
    if k == LEAVES:
        os._exit(3)
    if k % 10 == CRASHES:
        os.abort()
    return echo(cell)


def refuse(cell: RunCase) -> Measurement:
    if number(cell) == CRASHES:
        raise InvalidInput("this cell cannot be run")
    return echo(cell)


def kill_dask_worker(cell: RunCase) -> Measurement:
    """One cell kills the Dask worker that its process belongs to, as a batch system does that sees too much memory."""
    if number(cell) == CRASHES:
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(1000.0)
    time.sleep(0.05)
    return echo(cell)


def kept_in(folder: Path, cells: list[RunCase]) -> list[RunCase]:
    """The cells, with a folder for their tasks to write to."""
    return [dataclasses.replace(cell, name=str(folder)) for cell in cells]


KILLS = {CRASHES: signal.SIGKILL, HANGS: signal.SIGTERM}


def killed_once(cell: RunCase) -> Measurement:
    """Some cells are killed at their first attempt; each attempt leaves a file with its span of time."""
    span = Path(cell.name) / f"{number(cell)}-{os.getpid()}"
    begun, first = time.monotonic(), not list(Path(cell.name).glob(f"{number(cell)}-*"))
    span.write_text(f"{begun} inf")
    time.sleep(0.05)
    if first and number(cell) in KILLS:
        os.kill(os.getpid(), KILLS[number(cell)])
        time.sleep(1000.0)
    span.write_text(f"{begun} {time.monotonic()}")
    return echo(cell)


def kill_itself(cell: RunCase) -> Measurement:
    if number(cell) == CRASHES:
        os.kill(os.getpid(), signal.SIGKILL)
    return echo(cell)
