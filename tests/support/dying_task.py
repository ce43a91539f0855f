"""A task that dies a few times, in a module that a worker loads at once."""

from __future__ import annotations

import os
import signal
from pathlib import Path


def die_and_return(folder: Path, times: int) -> str:
    """Return when called once more than a number of times, and die of a SIGKILL before; each call leaves a file."""
    before = len(list(folder.iterdir()))
    (folder / str(before)).touch()
    if before < times:
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"
