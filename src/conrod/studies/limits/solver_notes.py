"""What is to be said of an engine's solver."""

from __future__ import annotations

from conrod.studies.limits.extremes import SolverWatch


def solver_note(solver: SolverWatch) -> str:
    """Empty where all is well."""
    return "stopped after 0 iterations" if solver.most == 0 else ""
