"""Whole commands: some that the ledger answers, where start, look-up and print are left, and some with runs to make."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from benchmarks.process_cost import ROOT, cost_of_process
from benchmarks.row import Row

COMMAND = str(Path(sys.executable).parent / "conrod")
SAW = "saw-500rpm"
MODEL = f"{ROOT}/mjcf/{SAW}.xml"
CHECK = ("check", MODEL, "--scene", SAW, "--crank", "crank", "--point", "C=site:C", "--point", "M=site:M")
# What tells one command of a verb from another in the table.
SHOWN_OPTIONS = ("--scene", "--drive", "--qualify", "--engine")
RECOMMEND = ("recommend", SAW, "--position", "1e-6", "--engine", "all", "--fresh")
# Command lines, and the CPU time [s] that each may take.
AGAIN = {
    ("validate", SAW): 0.4,
    CHECK: 0.5,
    ("check", MODEL, "--drive", "crank=500rpm"): 0.5,
}
MADE = {("free", SAW, "--fresh"): 5.0, ("harden", MODEL): 1.2, (*CHECK, "--qualify", "--fresh"): 2.5}
COLD_BAR = 1.2  # [s] by the clock on the wall, of a validation of which nothing is kept


def rows(repeats: int) -> list[Row]:
    """CPU time of each command and of its processes; and of importing numpy, which all of them do."""
    with tempfile.TemporaryDirectory() as folder:
        kept = {"CONROD_LEDGER": str(Path(folder, "ledger.sqlite")), "XDG_CACHE_HOME": folder}
        numpy = [cost_of_process([sys.executable, "-c", "import numpy"]).cpu for _ in range(repeats)]
        cold = [cost_of_process([COMMAND, "validate", SAW, "--fresh"], kept).wall for _ in range(repeats)]
        return [
            Row("python -c 'import numpy', CPU time", "s", numpy),
            Row(f"conrod validate {SAW}, nothing kept, on the wall", "s", cold, COLD_BAR),
            *(_command_row(words, bar, repeats, kept, again=True) for words, bar in AGAIN.items()),
            *(_command_row(words, bar, repeats, kept) for words, bar in MADE.items()),
        ]


def recommend_rows(repeats: int) -> list[Row]:
    """CPU time of a recommendation from all engines, of whose compiled functions JAX keeps what it can."""
    with tempfile.TemporaryDirectory() as folder:
        kept = {"CONROD_LEDGER": str(Path(folder, "ledger.sqlite")), "XDG_CACHE_HOME": folder}
        first = cost_of_process([COMMAND, *RECOMMEND], kept).cpu
        return [
            Row("conrod recommend --engine all, CPU time, nothing compiled", "s", [first]),
            _command_row(RECOMMEND, 20.0, repeats, kept, again=True),
        ]


def _command_row(
    words: tuple[str, ...], bar: float, repeats: int, environment: Mapping[str, str], *, again: bool = False
) -> Row:
    """CPU time of a command; `again` after a first time that does not count."""
    command = [COMMAND, *words]
    if again:
        cost_of_process(command, environment)
    times = [cost_of_process(command, environment).cpu for _ in range(repeats)]
    shown = " ".join(["conrod", words[0], Path(words[1]).name, *(word for word in words[2:] if word in SHOWN_OPTIONS)])
    return Row(f"{shown}{', again' if again else ''}, CPU time", "s", times, bar)
