"""What a whole command costs: time and memory of its process and of all that it starts."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]


class Cost(NamedTuple):
    """CPU time [s], the system's included, of a process and its children; the largest memory of one; wall time [s]."""

    cpu: float
    megabytes: float
    wall: float


def cost_of_process(
    command: Sequence[str], environment: Mapping[str, str] | None = None, statuses: Collection[int] = (0,)
) -> Cost:
    """Run a command from the repository's folder to its end, and return what it cost; its output is dropped.

    Args:
        statuses: the exit statuses of a command that has done its work.

    Raises:
        AssertionError: it ended with another exit status.
    """
    # Modules stay compiled, as pip leaves them; a variable that is empty counts as none.
    bytecode = {"PYTHONDONTWRITEBYTECODE": ""}
    begin = time.perf_counter()
    with subprocess.Popen(
        command,
        cwd=ROOT,
        env={**os.environ, **bytecode, **(environment or {})},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in statuses:
        raise AssertionError(f"{' '.join(command)} ended with status {process.returncode}")
    return Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, wall)
