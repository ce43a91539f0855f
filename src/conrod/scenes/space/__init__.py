"""Spatial machines whose motion is known in closed form, each with its MuJoCo model."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

from conrod.errors import Named
from conrod.scenes import SPATIAL
from conrod.scenes.space.machine import SpatialMachine
from conrod.scenes.space.several_loops import delta, double_cardan, sarrus, stewart
from conrod.scenes.space.single_loop import bennett, cardan_joint, rssr, spherical_four_bar, tilted_slider_crank

# Builders of machines, which take the parameters as keywords.
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
MACHINES: Mapping[str, Callable[..., SpatialMachine]] = Named(_BUILDERS, "spatial machine")

__all__ = ["MACHINES", "SPATIAL", "SpatialMachine"]
