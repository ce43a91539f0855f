"""Attacks on conrod, see tests/attack: what workers do of them, and what would be executed."""

from __future__ import annotations

import os
import pickle
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

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


# -- kills of a sweep ------------------------------------------------------------------------------------------------


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
