"""The shear press of document 000: an in-line slider-crank."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array, PointDerivatives, Side
from conrod.mechanism import parameters
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, ObservedPoint, Prismatic, Revolute
from conrod.scenes.scene import Scene, circular, combine, constant, projection


@dataclass(frozen=True)
class ShearPress(Scene):
    """Steel-plate shear press, document 000, section IV.1.

    Frame: shaft at the origin, x right, y up; the crank angle counts clockwise from the upward vertical, so the
    crank pin is at (r sin t, r cos t). The slider A moves on x = 0 above the shaft. G, the centre of gravity of the
    connecting rod, lies a third of the rod from the crank pin. The document gives no masses; these are conrod's.
    Lengths in m, speed in rad/s, SI throughout.
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

    def _check_geometry(self) -> None:
        parameters.check_proportion("rod", self.rod, "crank", self.crank)
        if not self.crank < self.rod:
            raise InvalidInput(
                f"crank = {self.crank:g} m is too long to turn fully: it must be shorter than rod = {self.rod:g} m"
            )

    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        # Document 000, section IV.2: y_G = r cos t + sqrt(a^2 - r^2 sin^2 t) / 3, x_G = (2/3) r sin t.
        up, right = circular(self.crank, np.sin(angle), np.cos(angle))
        along = projection(self.rod, right)
        return {
            "A": (constant(0.0), combine((1.0, up), (1.0, along))),
            "G": (combine((2.0 / 3.0, right)), combine((1.0, up), (1.0 / 3.0, along))),
        }

    def mechanism(self) -> Mechanism:
        """Ground, crank, connecting rod and slider; crank pin and slider pin as revolute joints."""
        third = (self.rod / 3.0, 0.0)
        return Mechanism(
            name=self.kind,
            bodies=(
                Body("crank", self.crank_mass, self.crank_inertia),
                Body("rod", self.rod_mass, self.rod_inertia, third),
                Body("slider", self.slider_mass, 0.01 * self.slider_mass),  # any inertia: it cannot turn
            ),
            joints=(
                Revolute("shaft", GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
                Revolute("crank-pin", "crank", "rod", (self.crank, 0.0), (0.0, 0.0)),
                Revolute("slider-pin", "rod", "slider", (self.rod, 0.0), (0.0, 0.0)),
                Prismatic("slide", GROUND, "slider", (0.0, 0.0), (0.0, 0.0), direction=math.pi / 2),
            ),
            driver=Driver("shaft", sense=-1, start=math.pi / 2),
            poses={
                "crank": (0.0, 0.0, math.pi / 2),
                "rod": (0.0, self.crank, math.pi / 2),
                "slider": (0.0, self.crank + self.rod, 0.0),
            },
            observed=(ObservedPoint("A", "slider"), ObservedPoint("G", "rod", third)),
            gravity=(0.0, -self.gravity),
        )
