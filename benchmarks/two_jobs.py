"""Two local jobs against one, start of the processes included. It means something on two idle cores only."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.row import Row
from benchmarks.side_by_side import interleaved, wall_seconds
from conrod import PymunkSettings, Saw
from conrod.execution.ledger import Ledger
from conrod.execution.local import LocalProcesses
from conrod.execution.run import RunCase
from conrod.execution.runner import run_cases

SAW = Saw(speed=52.36)
CELLS, STEPS_PER_TURN = 40, 20_000


def rows(repeats: int) -> list[Row]:
    """How many times as fast two jobs are."""
    sides = {str(jobs): partial(wall_seconds, partial(run_them, jobs)) for jobs in (1, 2)}
    seconds = interleaved(sides, repeats)
    faster = [one / two for one, two in zip(seconds["1"], seconds["2"], strict=True)]
    return [Row("two local jobs, speed against one", "x", faster, 1.8, at_least=True)]


def run_them(jobs: int) -> None:
    """A sweep of equal cells with an empty ledger."""
    base = PymunkSettings.tuned(SAW, STEPS_PER_TURN)
    cells = [RunCase("saw-500rpm", SAW, replace(base, iterations=30 + k)) for k in range(CELLS)]
    with (
        tempfile.TemporaryDirectory(dir=Path(__file__).parent) as folder,
        Ledger.open(Path(folder) / "ledger.sqlite") as ledger,
        LocalProcesses(jobs) as executor,
    ):
        run_cases(cells, ledger, executor)
