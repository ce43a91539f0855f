"""The mass ratio that holds with a number of iterations that stays: chart and table.

What was found on a scene, a sentence for each axis; every figure in it is computed from the walks.
"""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from conrod.report.charts.styles import engine_title
from conrod.report.limits.axis_scale import place
from conrod.report.limits.axis_section import by_axis
from conrod.report.limits.boundary_chart import boundary_chart
from conrod.report.limits.plain_words import names_of
from conrod.report.limits.words import BOUNDARIES, beyond, boundary_of, falling, span_text, text_at, up_to
from conrod.report.tables import table
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.results import IterationNeed, Walk

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


CRITERION = "rough"  # the boundary that is told: where the error leaves ten per cent


def findings(walks: Sequence[Walk]) -> list[str]:
    """A sentence on what is dangerous, and one for each axis and direction that has boundaries."""
    return [*_danger(walks), *(s for axis, these in by_axis(walks).items() for s in axis_findings(axis, these))]


def _danger(walks: Sequence[Walk]) -> list[str]:
    walked = [walk for walk in walks if walk.probes]
    runs = [probe for walk in walked for probe in walk.probes]
    quiet = sum(probe.undetected for probe in runs)
    if not runs:
        return []
    affected = sum(any(probe.undetected for probe in walk.probes) for walk in walked)
    return [f"**Wrong, and nothing says so:** {quiet} of {len(runs)} runs, on {affected} of {len(walked)} walks."]


def axis_findings(axis: str, walks: Sequence[Walk]) -> list[str]:
    """How far ten per cent holds, for the furthest and the least far, in each direction of an axis."""
    ways: dict[bool, list[Walk]] = {}
    for walk in walks:
        if walk.boundaries:
            ways.setdefault(walk.probes[-1].value < walk.probes[0].value, []).append(walk)
    return [f"**{AXES[axis].title}**, {span_text(way[0].probes)}: {_told(way)}." for way in ways.values()]


def _told(walks: Sequence[Walk]) -> str:
    left = [walk for walk in walks if boundary_of(walk, CRITERION).first_bad is not None]
    throughout = [walk for walk in walks if walk not in left]
    if not left:
        return f"within 10 % throughout with {'every preset' if len(walks) > 1 else names_of(walks)}"
    unheld = [walk for walk in left if boundary_of(walk, CRITERION).last_good is None]
    nowhere = [walk for walk in unheld if not boundary_of(walk, CRITERION).good_again]
    late = [walk for walk in unheld if walk not in nowhere]
    somewhere = sorted((walk for walk in left if walk not in unheld), key=_reach)
    parts = [f"within 10 % throughout with {names_of(throughout)}"] if throughout else []
    if somewhere and not throughout and _reach(somewhere[-1]) > _reach(somewhere[0]):
        parts.append(f"within 10 % furthest with {names_of(_equal(somewhere, -1))} ({_limit(somewhere[-1])})")
    if somewhere:
        how = "least far" if parts else "within 10 %"
        parts.append(f"{how} with {names_of(_equal(somewhere, 0))} ({_limit(somewhere[0])})")
    if nowhere:
        parts.append(f"nowhere with {names_of(nowhere)}")
    if late:
        parts.append(f"not at first, but further on with {names_of(late)}")
    return f"{', '.join(parts)}; {_quietly(left)}"


def _quietly(left: Sequence[Walk]) -> str:
    """How many of those that leave ten per cent do so without a sign."""
    quiet = sum(boundary_of(walk, CRITERION).undetected for walk in left)
    if quiet == 0:
        return "none leaves it quietly"
    return "all that leave it do so quietly" if quiet == len(left) else f"{quiet} of {len(left)} leave it quietly"


def _equal(walks: Sequence[Walk], k: int) -> list[Walk]:
    """All that reach as far as one of them."""
    return [walk for walk in walks if _reach(walk) == _reach(walks[k])]


def _reach(walk: Walk) -> float:
    """How far ten per cent holds, along the axis' own scale."""
    scale, last = AXES[walk.axis].scale, boundary_of(walk, CRITERION).last_good
    return 0.0 if last is None else abs(place(scale, last) - place(scale, walk.probes[0].value))


def _limit(walk: Walk) -> str:
    last = boundary_of(walk, CRITERION).last_good
    assert last is not None
    return ("down to " if walk.probes[-1].value < walk.probes[0].value else "up to ") + text_at(walk, last)
