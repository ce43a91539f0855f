"""Validation of machines in space: one with many joints, and all of them side by side."""

from __future__ import annotations

from benchmarks.command_cost import COMMAND
from benchmarks.process_cost import cost_of_process
from benchmarks.row import Row

ONE, STEWART_BAR = "stewart", 2.5  # CPU time [s]
WITHIN_OR_OUT = (0, 1)  # some machines are out of tolerance with their own settings, which is a verdict
ALL, SPATIAL_BAR = "spatial", 10.0  # time [s] by the clock on the wall, of two idle cores


def rows(repeats: int) -> list[Row]:
    """Time of `conrod validate` and of its processes, of machines that no ledger keeps."""
    one = [cost_of_process([COMMAND, "validate", ONE]).cpu for _ in range(repeats)]
    every = [cost_of_process([COMMAND, "validate", ALL], statuses=WITHIN_OR_OUT) for _ in range(repeats)]
    return [
        Row(f"conrod validate {ONE}, CPU time", "s", one, STEWART_BAR),
        Row(f"conrod validate {ALL}, on the wall, both cores", "s", [cost.wall for cost in every], SPATIAL_BAR),
        Row(f"conrod validate {ALL}, CPU time", "s", [cost.cpu for cost in every]),
    ]
