"""Validation of machines in space: one with many joints, and all of them side by side."""

from __future__ import annotations

from benchmarks.command_cost import COMMAND
from benchmarks.process_cost import cost_of_process
from benchmarks.row import Row

# What is validated, and the CPU time [s] that it may take.
SUBJECTS = {"stewart": 2.5, "spatial": 10.0}


def rows(repeats: int) -> list[Row]:
    """CPU time of `conrod validate` and of its processes, of machines that no ledger keeps."""
    return [
        Row(
            f"conrod validate {subject}, CPU time",
            "s",
            [cost_of_process([COMMAND, "validate", subject]).cpu for _ in range(repeats)],
            bar,
        )
        for subject, bar in SUBJECTS.items()
    ]
