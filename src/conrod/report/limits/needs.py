"""The mass ratio that holds with a number of iterations that stays: chart and table."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from conrod.report.limits.boundary_chart import boundary_chart
from conrod.report.limits.passages import falling
from conrod.report.limits.words import BOUNDARIES, beyond, up_to
from conrod.report.styles import engine_title
from conrod.report.tables import table
from conrod.studies.limits.iteration_need import IterationNeed

WAYS = {False: "heavier", True: "lighter"}
NOTHING = "-"


def needs_chart(needs: Sequence[IterationNeed]) -> Figure | None:
    """A bar for each number of iterations; None where there is none."""
    return boundary_chart({f"{engine_title(n.engine)} {n.preset}, {_count(n.iterations)}": n.walks for n in needs})


def needs_table(needs: Sequence[IterationNeed]) -> str:
    """A row for each number of iterations and each way from equal masses."""
    rows = [
        [
            engine_title(need.engine),
            need.preset,
            str(need.iterations),
            WAYS[falling(walk)],
            *(up_to(walk, criterion) for criterion in BOUNDARIES),
            beyond(walk) or NOTHING,
        ]
        for need in needs
        for walk in need.walks
    ]
    return table(["engine", "preset", "iterations", "slider", *BOUNDARIES.values(), "beyond 10 %"], rows)


def _count(iterations: int) -> str:
    return f"{iterations} iteration" + ("s" if iterations > 1 else "")
