"""Options of `conrod validate MODEL.xml`: what is what in a user's own model."""

from __future__ import annotations

from dataclasses import dataclass, field

import click

from conrod.cli.options import bundled


@dataclass(frozen=True)
class ModelOptions:
    """What was given; None or empty where nothing was."""

    crank: str | None = None
    points: tuple[str, ...] = field(default=(), metadata={"option": "--point"})
    plane: str | None = None
    rotation: str | None = None
    crank_zero: str | None = None
    length_unit: str | None = None
    keyframe: str | None = None
    touching: str | None = None


OPTIONS = (
    click.option("--crank", metavar="JOINT", help="Of a model: the hinge that is driven."),
    click.option(
        "--point",
        "points",
        multiple=True,
        metavar="NAME=site:SITE",
        help="Of a model: where an observed point is (site:, body: or geom:); may be given again.",
    ),
    click.option("--plane", metavar="PLANE", help="Of a model: directions right and up, e.g. xz or -xz [worked out]."),
    click.option("--rotation", metavar="ANGLE", help="Of a model: of the scene's x axis in it [worked out]."),
    click.option("--crank-zero", metavar="ANGLE", help="Of a model: hinge at crank angle 0 [worked out]."),
    click.option("--length-unit", metavar="UNIT", help="Of a model: m, cm, mm or inch [worked out]."),
    click.option("--keyframe", metavar="NAME", help="Of a model: assemble it from there [its reference pose]."),
    click.option("--touching", metavar="CAM,ROLLER", help="Of a model: geoms of its cam contact [worked out]."),
)
of_a_model = bundled("model", ModelOptions, OPTIONS)
