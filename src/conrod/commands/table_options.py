"""Options of `conrod validate TRAJECTORY.csv`: what is what in a table of any tool."""

from __future__ import annotations

from dataclasses import dataclass, field

import click

from conrod.commands.bundles import bundled


@dataclass(frozen=True)
class TableOptions:
    """What was given; None or empty where nothing was."""

    columns: tuple[str, ...] = field(default=(), metadata={"option": "--column"})


OPTIONS = (
    click.option(
        "--column", "columns", multiple=True, metavar="QUANTITY=NAME", help="Of a table: which column is what."
    ),
)
of_a_table = bundled("table", TableOptions, OPTIONS)
