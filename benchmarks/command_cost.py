"""Whole commands: some that the ledger answers, where start, look-up and print are left, and some with runs to make."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from benchmarks.process_cost import ROOT, cost_of_process
from benchmarks.row import Row

COMMAND = str(Path(sys.executable).parent / "conrod")
SAW = "saw-500rpm"
MODEL = f"{ROOT}/mjcf/{SAW}.xml"
CHECK = ("check", MODEL, "--scene", SAW, "--crank", "crank", "--point", "C=site:C", "--point", "M=site:M")
# Command lines, and the CPU time [s] that each may take.
AGAIN = {
    ("validate", SAW): 0.4,
    CHECK: 0.5,
    ("check", MODEL, "--drive", "crank=500rpm"): 0.5,
}
MADE = {("free", SAW, "--fresh"): 5.0, ("harden", MODEL): 1.2, (*CHECK, "--qualify", "--fresh"): 2.5}


def rows(repeats: int) -> list[Row]:
    """CPU time of each command and of its processes; and of importing numpy, which all of them do."""
    numpy = [cost_of_process([sys.executable, "-c", "import numpy"]).cpu for _ in range(repeats)]
    found = [Row("python -c 'import numpy', CPU time", "s", numpy)]
    with tempfile.TemporaryDirectory() as folder:
        ledger = {"CONROD_LEDGER": str(Path(folder, "ledger.sqlite"))}
        for words, bar in AGAIN.items():
            command = [COMMAND, *words]
            cost_of_process(command, ledger)
            times = [cost_of_process(command, ledger).cpu for _ in range(repeats)]
            shown = f"conrod {words[0]} {Path(words[1]).name}" + (f" {words[2]}" if len(words) > 2 else "")
            found.append(Row(f"{shown}, again, CPU time", "s", times, bar))
        for words, bar in MADE.items():
            times = [cost_of_process([COMMAND, *words], ledger).cpu for _ in range(repeats)]
            found.append(Row(f"conrod {words[0]} {Path(words[1]).name}, CPU time", "s", times, bar))
    return found
