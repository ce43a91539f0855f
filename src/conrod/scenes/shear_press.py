"""The steel-plate shear press of document 000, an in-line slider-crank."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array, PointDerivatives, Side
from conrod.mechanism import units as parameters
from conrod.mechanism.mechanism import Driver, Mechanism, ObservedPoint
from conrod.scenes.scene import circular, combine, constant, projection
from conrod.scenes.slider_crank import SliderCrank


@dataclass(frozen=True)
class ShearPress(SliderCrank):
    """Steel-plate shear press of document 000, an in-line slider-crank with crank r and rod a.

    Frame: shaft at the origin, x right, y up; the crank pin is at (r sin t, r cos t), and the slider A moves on x = 0
    above the shaft. G, the centre of gravity of the connecting rod, lies a third of the rod from the crank pin.

    Signs: the crank angle t counts clockwise from the upward vertical.

    Units: SI, with lengths in m and speed in rad/s.

    Source: document 000, sections IV.1 and IV.2. It gives no masses; these are conrod's.
    """

    kind = "shear-press"
    title = "Shear press (in-line slider-crank)"
    source = "document 000 (analysis of a steel-plate shear press), sections IV.1 and IV.2"
    drawn_at = 50.0
    output = "A"
    description = (
        "A steel-plate shear press: a crank of {crank} turns at {speed} and moves the slider with the upper "
        "blade, A, through a connecting rod of {rod}. The slide's line passes through the shaft. G is the "
        "rod's centre of gravity, a third of the rod from the crank pin."
    )
    frame = (
        "shaft at the origin, x right, y up. The crank angle t counts clockwise from the upward vertical, so "
        "that the crank pin is at (r sin t, r cos t). The slider A moves on x = 0 above the shaft."
    )

    crank: float = parameters.length(0.0325, "crank, shaft to crank pin")
    rod: float = parameters.length(0.390, "connecting rod, crank pin to slider")
    speed: float = parameters.speed(5.75)
    crank_mass: float = parameters.mass(5.0, "crank, balanced about the shaft")
    crank_inertia: float = parameters.inertia(0.02, "crank, about the shaft")
    rod_mass: float = parameters.mass(8.0, "connecting rod, centre of gravity at G")
    rod_inertia: float = parameters.inertia(0.12, "connecting rod, about G")
    slider_mass: float = parameters.mass(60.0, "slider with blade")
    gravity: float = parameters.gravity(9.81, "acceleration of free fall, along the slide (-y)")

    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        # Document 000, section IV.2: y_G = r cos t + sqrt(a^2 - r^2 sin^2 t) / 3, x_G = (2/3) r sin t.
        up, right = circular(self.crank, np.sin(angle), np.cos(angle))
        along = projection(self.rod, right)
        return {
            "A": (constant(0.0), combine((1.0, up), (1.0, along))),
            "G": (combine((2.0 / 3.0, right)), combine((1.0, up), (1.0 / 3.0, along))),
        }

    def mechanism(self) -> Mechanism:
        """Build ground, crank, connecting rod and slider, joined by pins at crank and slider."""
        up, driver = math.pi / 2, Driver("shaft", sense=-1, start=math.pi / 2)
        observed = (ObservedPoint("A", "slider"), ObservedPoint("G", "rod", (self.rod / 3.0, 0.0)))
        top = (0.0, self.crank + self.rod)
        return self._slider_crank((0.0, 0.0), driver, (0.0, self.crank), up, top, up, observed)
