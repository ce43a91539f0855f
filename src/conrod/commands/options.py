"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

DEFAULT_GRID = "default"
Command = TypeVar("Command", bound=Callable[..., Any])

assignments = click.option(
    "--set", "assignments", multiple=True, metavar="NAME=VALUE", help="Override a parameter, e.g. --set crank=80mm."
)
engine = click.option("--engine", metavar="ENGINE", help="One engine only: mujoco or pymunk.")
grid = click.option("--grid", default=DEFAULT_GRID, show_default=True, metavar="GRID", help="coarse, default or fine.")
ledger = click.option(
    "--ledger", metavar="FILE", help="Where finished runs are kept [a file in the user's cache folder]."
)
retime = click.option("--retime", is_flag=True, help="Time again what the ledger has, without running it again.")
jobs = click.option("--jobs", type=int, metavar="N", help="Runs at a time on this machine [one a core].")

RUNS = (
    ledger,
    click.option("--fresh", is_flag=True, help="Do again what the ledger has."),
    jobs,
    click.option("--cluster", metavar="ADDRESS", help="Run on a Dask cluster instead, e.g. tcp://host:8786."),
    click.option("--cell-timeout", type=float, metavar="SECONDS", help="End a run that takes longer [600]."),
    click.option("--cell-memory", metavar="SIZE", help="End a run that needs more, e.g. 4GB [no limit]."),
)


def runs(command: Command) -> Command:
    """Options of how runs are made and where they are kept."""
    for option in reversed(RUNS):
        command = option(command)
    return command
