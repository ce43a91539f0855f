"""The command line as a user types it, run in this process: a start of Python takes longer than most commands."""

from __future__ import annotations

import atexit
import io
import itertools
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import pytest

from conrod import SAFE_PATH
from conrod.cli import main
from conrod.execution.worker_process import CallLimits, WorkerProcess

# What is run again and again by many tests is kept here: no test reads or writes the ledger of whoever runs them.
_FOLDER = tempfile.TemporaryDirectory(prefix="conrod-tests-")
os.environ.setdefault("CONROD_LEDGER", str(Path(_FOLDER.name) / "ledger.sqlite"))


class Kept(WorkerProcess):
    """A worker that serves one command after another: to start one takes longer than most commands."""

    folder: Path

    def move_to(self, folder: Path) -> None:
        """Work in a folder: files of a command are named from there."""
        if folder != self.folder:
            self.call(os.chdir, folder)
            self.folder = folder

    def kill(self) -> None:
        if not self.ready:
            super().kill()

    def end(self) -> None:
        if self.ready:
            _idle[self._limits, tuple(sys.path)].append(self)
        else:
            super().end()


_idle: defaultdict[tuple[CallLimits, tuple[str, ...]], list[Kept]] = defaultdict(list)


@atexit.register
def _end_all() -> None:
    for worker in itertools.chain.from_iterable(_idle.values()):
        WorkerProcess.kill(worker)


def kept_worker(limits: CallLimits, interpreter: str | None = None) -> WorkerProcess:
    """A worker of these limits, in this folder, that imports from where this process does now; a new one of another
    interpreter.
    """
    if interpreter is not None:
        return WorkerProcess(limits, interpreter)
    idle, folder = _idle[limits, tuple(sys.path)], Path.cwd()
    while idle:
        if (worker := idle.pop()).ready:
            worker.move_to(folder)
            return worker
    started = Kept(limits)
    started.folder = folder
    return started


def conrod(
    *arguments: str, cwd: Path | None = None, ledger: Path | None = None, own_workers: bool = False
) -> subprocess.CompletedProcess[str]:
    """Run a command; return its output and exit status, or raise its unhandled exception.

    Args:
        cwd: folder that it is run in, this one where it is None.
        ledger: file of results that commands use unless told otherwise.
        own_workers: whether its worker processes are started for it alone, as a user's are.
    """
    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", ["conrod", *arguments])
        for name, value in SAFE_PATH.items():
            patch.setenv(name, value)  # as the command does, and it is taken back
        patch.setattr("conrod.cli.WAITING_NOTICE_DELAY", 1e6)  # however slow the machine is
        if not own_workers:
            patch.setattr("conrod.execution.local.WorkerProcess", kept_worker)
        if cwd is not None:
            patch.chdir(cwd)
        if ledger is not None:
            patch.setenv("CONROD_LEDGER", str(ledger))
        status: Any = 0
        try:
            main()
        except SystemExit as ended:
            status = ended.code
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())


def conrod_process(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command in a separate Python, for claims about the process."""
    return subprocess.run(
        [sys.executable, "-m", "conrod", *arguments], capture_output=True, text=True, cwd=cwd, timeout=300, check=False
    )


def refusal(*arguments: str, **how: Any) -> str:
    """The one line of a command that ends with status 2 before anything is run or written; see `conrod`."""
    done = conrod(*arguments, **how)
    lines = error_lines(done)
    assert (done.returncode, done.stdout, len(lines)) == (2, "", 1), done
    assert lines[0].startswith("conrod: ")
    assert len(lines[0]) < 700
    return lines[0]


def error_lines(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Lines of standard error without the progress of runs, which depends on earlier runs."""
    return [line for line in done.stderr.splitlines() if not line.startswith("runs: ")]
