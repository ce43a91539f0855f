"""Options of `conrod validate MODEL.xml`: what is what in a user's own model."""

from __future__ import annotations

from dataclasses import dataclass, field

import click

from conrod.commands.bundles import bundled


@dataclass(frozen=True)
class ModelOptions:
    """What was given; None or empty where nothing was."""

    crank: str | None = None
    points: tuple[str, ...] = field(default=(), metadata={"option": "--point"})


OPTIONS = (
    click.option("--crank", metavar="JOINT", help="Of a model: the hinge that is driven."),
    click.option(
        "--point", "points", multiple=True, metavar="NAME=site:SITE", help="Of a model: where an observed point is."
    ),
)
of_a_model = bundled("model", ModelOptions, OPTIONS)
