"""Tasks performed: each command in a process and a folder of its own, with a ledger that nobody else has."""

from __future__ import annotations

import importlib.util
import lzma
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tests.golden import extract
from tests.golden.record import Record
from tests.golden.store import KERNELS
from tests.golden.tasks import FROM_LEDGER, Task

LONGEST = 900.0  # [s] of a command
BAD_USAGE = 2  # the exit status of what is refused: there is no file then
LEDGER = "ledger.sqlite"

Answers = dict[Task, dict[str, Record]]


def perform(tasks: Iterable[Task], jobs: int, data: Path, say: Callable[[str], None]) -> Answers:
    """Records of all tasks, in the order of the tasks.

    Args:
        jobs: commands at a time.
        data: folder with the kept ledger.
        say: takes a line for each task that is done.

    Raises:
        RuntimeError: a command crashed, or two records of one have the same name.
    """
    tasks = list(tasks)
    answers: Answers = {}
    begun = time.monotonic()
    with ThreadPoolExecutor(jobs) as threads:
        futures = {threads.submit(records_of, task, data): task for task in tasks}
        try:
            for future in as_completed(futures):
                task = futures[future]
                answers[task] = future.result()
                passed = time.monotonic() - begun
                say(f"[{len(answers)}/{len(tasks)}] {passed:5.0f} s  {task.group}/{task.name}")
        except BaseException:
            threads.shutdown(wait=False, cancel_futures=True)
            raise
    return {task: answers[task] for task in tasks}


def records_of(task: Task, data: Path) -> dict[str, Record]:
    """Records of one task."""
    found: dict[str, Record] = {}
    with tempfile.TemporaryDirectory(prefix="golden-") as name:
        folder = Path(name)
        for place, record in _command(task, folder) if task.arguments else _from_ledger(folder, data):
            if place in found:
                raise RuntimeError(f"{task.group}/{task.name}: two records are named {place}")
            found[place] = record
    return found


def source() -> Path:
    """Folder of the conrod that is checked: the one that this process would import."""
    found = importlib.util.find_spec("conrod")
    assert found is not None
    assert found.origin is not None
    return Path(found.origin).resolve().parents[1]


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A command of conrod as it ended.

    Raises:
        RuntimeError: it crashed.
    """
    path = os.pathsep.join([str(source()), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, **KERNELS, "PYTHONPATH": path, "CONROD_LEDGER": str(folder / "own.sqlite")}
    done = subprocess.run(
        [sys.executable, "-m", "conrod", *arguments],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False,
    )  # fmt: skip
    if done.returncode not in (0, 1, BAD_USAGE) or "Traceback (most recent call last)" in done.stderr:
        raise RuntimeError(f"conrod {' '.join(arguments)}: exit status {done.returncode}\n{done.stderr[-3000:]}")
    return done


def _command(task: Task, folder: Path) -> extract.Records:
    option, file = task.output
    status = run(folder, *task.arguments, option, file).returncode
    yield "exit status", Record(status)
    if status != BAD_USAGE:
        yield from extract.written(task.group, folder / file)


# -- the ledger of the day when the data were made ---------------------------------------------------------------------


def _from_ledger(folder: Path, data: Path) -> extract.Records:
    """What studies find in a copy of the kept ledger, in which everything they ask for has been run."""
    ledger = folder / LEDGER
    ledger.write_bytes(lzma.decompress((data / f"{LEDGER}.xz").read_bytes()))
    before = extract.kept_runs(ledger)
    for command in FROM_LEDGER:
        new, kept = extract.announced(_study(folder, ledger, command))
        yield f"{command[0]}/new runs", Record(new)
        yield f"{command[0]}/runs in the ledger", Record(kept)
    after = extract.kept_runs(ledger)
    yield "runs", Record(len(after))
    yield "runs changed, lost or new", Record(sum(before.get(key) != after.get(key) for key in before | after))
    run(folder, "results", "--ledger", str(ledger), "--json", "rows.json")
    yield from extract.result_rows(folder / "rows.json")


def _study(folder: Path, ledger: Path, command: tuple[str, ...]) -> str:
    file = f"{command[0]}.json"
    return run(folder, *command, "--jobs", "1", "--ledger", str(ledger), "--json", file).stderr


def make_ledger(data: Path) -> None:
    """Put a ledger of today in the place of the kept one: what was run before is then known no more."""
    with tempfile.TemporaryDirectory(prefix="golden-") as name:
        folder = Path(name)
        ledger = folder / LEDGER
        for command in FROM_LEDGER:
            _study(folder, ledger, command)
        extract.compact(ledger)
        (data / f"{LEDGER}.xz").write_bytes(lzma.compress(ledger.read_bytes(), preset=9 | lzma.PRESET_EXTREME))
