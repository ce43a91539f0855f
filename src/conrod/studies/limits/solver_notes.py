"""What is to be said of an engine's solver: that it stopped before it should, or could not do it in its iterations."""

from __future__ import annotations

import math

from conrod.studies.limits.extremes import SolverWatch

# A residual (normalised) above this is no rounding. MuJoCo's converged runs leave 1e-15 to 1e-13, and up to 2.2e-9
# where a slider is a million times as heavy as usual; pymunk's 1e-16 to 6e-12. With 64 iterations pymunk leaves 7e-9,
# and the press's acceleration error is a hundred times what it is with 128 (1.1e-3, 1.1e-5; at 1000 steps a turn).
LEFT = 4e-9


def solver_note(solver: SolverWatch | None) -> str:
    """A few words, or none where all is well.

    They give the residual by its power of ten, so that runs of which the same is to be said can be told together.
    """
    if solver is None or solver.residual is None or solver.residual <= LEFT:
        # With nothing left to do, to stop at once is right.
        return ""
    return f"{_iterations(solver)}, residual above {10.0 ** math.floor(math.log10(solver.residual)):g}"


def _iterations(solver: SolverWatch) -> str:
    if solver.least is None or solver.most is None:
        return "left its task unfinished"
    if solver.most == 0:
        return "stopped after 0 iterations"
    if solver.least == 0:
        return "stopped after 0 iterations at some steps"
    return "took all its iterations" if solver.most >= solver.allowed else "stopped before all its iterations"
