"""Options of `conrod validate --motion`: a motion that no drive prescribes."""

from __future__ import annotations

from dataclasses import dataclass

import click

from conrod.commands.bundles import bundled


@dataclass(frozen=True)
class MotionOptions:
    """What was given; None where nothing was."""

    motion: str | None = None
    seconds: float | None = None
    step: str | None = None


OPTIONS = (
    click.option(
        "--motion",
        metavar="KIND",
        help="Nothing holds the crank's speed: free, without a torque that drives it, or torque, with its torques.",
    ),
    click.option("--seconds", type=float, metavar="S", help="Of --motion: how long [10]."),
    click.option("--step", metavar="TIME", help="Of --motion: the engines' time step, e.g. 2ms [5 ms or less]."),
)
of_a_motion = bundled("motion", MotionOptions, OPTIONS)
