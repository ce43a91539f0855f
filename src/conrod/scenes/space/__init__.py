"""Spatial machines whose motion is known in closed form, each with its MuJoCo model."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

from conrod.errors import Named
from conrod.scenes.space.cardan import cardan_joint, double_cardan
from conrod.scenes.space.four_bar import rssr, spherical_four_bar
from conrod.scenes.space.machine import SpatialMachine, SpatialMotion
from conrod.scenes.space.overconstrained import bennett, sarrus
from conrod.scenes.space.parallel import delta, stewart
from conrod.scenes.space.tilted import tilted_slider_crank

# Each builds its machine, with its parameters as keywords.
_BUILDERS: dict[str, Callable[..., SpatialMachine]] = {
    "cardan": cardan_joint,
    "double-cardan": double_cardan,
    "double-cardan-misphased": partial(double_cardan, phasing=0.5 * math.pi),
    "spherical-four-bar": spherical_four_bar,
    "rssr": rssr,
    "rssr-idle-spin": partial(rssr, rod_joint="ball"),
    "bennett": bennett,
    "sarrus": sarrus,
    "delta": delta,
    "stewart": stewart,
    "tilted-slider-crank": tilted_slider_crank,
}
# The word that stands for all of them.
SPATIAL = "spatial"
MACHINES: Mapping[str, Callable[..., SpatialMachine]] = Named(_BUILDERS, "spatial machine")

__all__ = ["MACHINES", "SPATIAL", "SpatialMachine", "SpatialMotion"]
