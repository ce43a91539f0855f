"""What `conrod limits` prints."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from conrod.console import console
from conrod.report.limits.words import BOUNDARIES, beyond, readable, up_to
from conrod.studies.limits.results import Walk
from conrod.studies.limits.study import LimitStudy

WIDE = 170  # where there is no terminal to fit
CAPTION = "quiet: finite numbers, no warning, wrong motion"


def print_limits(studies: Sequence[LimitStudy]) -> None:
    """For each scene and axis, up to where each engine and preset can be relied on, and how it fails beyond."""
    out = console(WIDE)
    for study in studies:
        table = Table(title=f"{study.name}: up to where", title_justify="left", caption=CAPTION, caption_justify="left")
        for heading in ("axis", "engine", "preset", *BOUNDARIES.values(), "beyond that"):
            table.add_column(heading)
        for walk in map(readable, study.walks):
            if walk.boundaries:
                table.add_row(walk.axis, walk.engine, walk.preset, *_boundaries(walk), beyond(walk))
        if table.row_count:
            out.print(table)
        for text in _listed(study):
            out.print(text, markup=False, soft_wrap=True)
        for refused in dict.fromkeys((w.axis, w.engine, w.refusal) for w in study.walks if w.refusal):
            out.print(f"{refused[0]}, {refused[1]}: not walked, {refused[2]}", markup=False, soft_wrap=True)


def _boundaries(walk: Walk) -> list[str]:
    return [up_to(walk, criterion) for criterion in BOUNDARIES]


def _listed(study: LimitStudy) -> list[str]:
    """A line for each walk over a list of values: how many ended well, and which did not."""
    lines = []
    for walk in study.walks:
        if walk.probes and not walk.boundaries:
            bad = [f"{probe.text} {probe.outcome}" for probe in walk.probes if probe.level not in ("safe", "rough")]
            held = f"{len(walk.probes) - len(bad)} of {len(walk.probes)} within 10 %"
            lines.append(f"{walk.axis}, {walk.engine} {walk.preset}: {held}" + (f"; {', '.join(bad)}" if bad else ""))
    return lines
