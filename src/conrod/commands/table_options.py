"""Options of `conrod validate TRAJECTORY.csv`: what is what in a table of any tool."""

from __future__ import annotations

from dataclasses import dataclass, field

import click

from conrod.commands.bundles import bundled


@dataclass(frozen=True)
class TableOptions:
    """What was given; None or empty where nothing was."""

    columns: tuple[str, ...] = field(default=(), metadata={"option": "--column"})
    units: tuple[str, ...] = field(default=(), metadata={"option": "--unit"})
    estimate: str | None = None


OPTIONS = (
    click.option(
        "--column", "columns", multiple=True, metavar="Q=NAME", help="Of a table: which column is what, e.g. C.x=px."
    ),
    click.option(
        "--unit", "units", multiple=True, metavar="UNIT | Q=UNIT", help="Of a table: units that no heading gives."
    ),
    click.option(
        "--estimate",
        metavar="WHAT,...",
        help="Of a table: what is unknown and to be worked out, of time, phase, sense and frame.",
    ),
)
of_a_table = bundled("table", TableOptions, OPTIONS)
