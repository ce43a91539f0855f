"""At how many steps per revolution each engine and preset leaves its tolerance, and at how many it breaks."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report.limits.words import BOUNDARIES, EVERYWHERE, boundary_of, not_held, text_at
from conrod.report.styles import engine_title
from conrod.report.tables import table
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.results import Walk

STEPS = AXES["steps"].name


def steps_table(walks: Sequence[Walk]) -> str:
    """A row for each scene, engine and preset whose steps were walked; nothing where there is none."""
    rows = [
        [walk.scene, engine_title(walk.engine), walk.preset, *(_held(walk, criterion) for criterion in BOUNDARIES)]
        for walk in walks
        if walk.axis == STEPS and walk.boundaries
    ]
    return table(["machine", "engine", "preset", *BOUNDARIES.values()], rows)


def _held(walk: Walk, criterion: str) -> str:
    """The last number of steps that keeps a criterion, and how the next one ended: `34 (33: opened, quiet)`."""
    boundary = boundary_of(walk, criterion)
    if boundary.first_bad is None:
        return EVERYWHERE
    bad = next(probe for probe in walk.probes if probe.value == boundary.first_bad)
    ended = bad.level if bad.outcome == "completed" else bad.outcome
    held = not_held(boundary) if boundary.last_good is None else _number(text_at(walk, boundary.last_good))
    return f"{held} ({_number(bad.text)}: {ended}{', quiet' if boundary.quiet else ''})"


def _number(text: str) -> str:
    """Without the unit, which stands in the heading."""
    return text.removesuffix(" steps")
