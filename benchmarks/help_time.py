"""`conrod --help`, from the shell to the end of the process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from benchmarks.row import Row
from benchmarks.side_by_side import wall_seconds

COMMAND = Path(sys.executable).parent / "conrod"


def rows(repeats: int) -> list[Row]:
    """Wall time, the files in the system's memory."""
    _help()
    return [Row("conrod --help", "s", [wall_seconds(_help) for _ in range(repeats)], 0.3)]


def _help() -> None:
    subprocess.run([str(COMMAND), "--help"], check=True, stdout=subprocess.DEVNULL)
