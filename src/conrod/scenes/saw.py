"""The power hacksaw of document 002, an offset slider-crank."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array, PointDerivatives, Side
from conrod.mechanism import units as parameters
from conrod.mechanism.mechanism import Driver, Mechanism, ObservedPoint
from conrod.mechanism.units import RPM
from conrod.scenes.scene import circular, combine, constant, projection
from conrod.scenes.slider_crank import SliderCrank


@dataclass(frozen=True)
class Saw(SliderCrank):
    """Power hacksaw of document 002, an offset slider-crank with crank r, rod l and offset e.

    Frame: the slider C is at (0, 0) for crank angle 0 and moves along x, y up; the shaft is at
    (sqrt(l^2 - e^2) - r, -e) and the crank pin at the shaft + r (cos t, sin t). M is the middle of the connecting
    rod and its centre of gravity.

    Signs: the crank angle t counts counter-clockwise from +x; e > 0 where the slide runs above the shaft.

    Units: SI.

    Source: document 002, section 3 and its MATLAB listing (r2 = crank, r3 = rod, r1 - r5 = offset). It gives no
    masses; these are conrod's.
    """

    kind = "saw"
    title = "Power hacksaw (offset slider-crank)"
    source = "document 002 (kinematic simulation of a power hacksaw by complex numbers), section 3"
    output = "C"
    description = (
        "A power hacksaw: a crank disc of radius {crank} turns at {speed} and moves the slider with the saw "
        "blade, C, through a connecting rod of {rod}. The slide runs {offset} above the shaft (an offset "
        "slider-crank, so that the two strokes take different times). M is the middle of the rod and its "
        "centre of gravity."
    )
    frame = (
        "the slider C is at (0, 0) for crank angle 0 and moves along x; y is up. The shaft is at (sqrt(l² - "
        "e²) - r, -e), the crank pin at the shaft + r (cos t, sin t)."
    )

    crank: float = parameters.length(0.1, "crank, shaft to crank pin")
    rod: float = parameters.length(0.3, "connecting rod, crank pin to slider")
    offset: float = parameters.offset(0.09, "height of the slide above the shaft")
    speed: float = parameters.speed(40.0 * RPM)
    crank_mass: float = parameters.mass(4.0, "crank disc, balanced about the shaft")
    crank_inertia: float = parameters.inertia(0.02, "crank disc, about the shaft")
    rod_mass: float = parameters.mass(1.5, "connecting rod, centre of gravity at M")
    rod_inertia: float = parameters.inertia(0.01125, "connecting rod, about M")
    slider_mass: float = parameters.mass(6.0, "slider with saw blade")
    gravity: float = parameters.gravity(9.81, "acceleration of free fall, across the slide (-y)")

    @property
    def shaft(self) -> tuple[float, float]:
        """Position of the shaft [m]."""
        return (math.sqrt((self.rod - self.offset) * (self.rod + self.offset)) - self.crank, -self.offset)

    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        # Document 002, listing: posisiC = r2 cos t + r3 cos(theta3b) + s0, with r3 sin(theta3) = r1 - r5 - r2 sin t.
        along, up = circular(self.crank, np.sin(angle), np.cos(angle))
        shaft_x, shaft_y = self.shaft
        pin_x, pin_y = combine((1.0, along), (1.0, constant(shaft_x))), combine((1.0, up), (1.0, constant(shaft_y)))
        reach = projection(self.rod, pin_y)
        return {
            "C": (combine((1.0, pin_x), (-1.0, reach)), constant(0.0)),
            "M": (combine((1.0, pin_x), (-0.5, reach)), combine((0.5, pin_y))),
        }

    def mechanism(self) -> Mechanism:
        """Build ground, crank disc, connecting rod and slider, joined by pins at crank and slider."""
        pin = (self.shaft[0] + self.crank, -self.offset)
        rod_turn = math.atan2(self.offset, -(self.shaft[0] + self.crank))
        observed = (ObservedPoint("C", "slider"), ObservedPoint("M", "rod", (self.rod / 2.0, 0.0)))
        return self._slider_crank(self.shaft, Driver("shaft"), pin, rod_turn, (0.0, 0.0), 0.0, observed)
