"""The slider-cranks of the documents: the power hacksaw of 002, which is offset, and the shear press of 000."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array, PointDerivatives, Side
from conrod.mechanism import units as parameters
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, ObservedPoint, Point, Prismatic, Revolute
from conrod.scenes.scene import Scene, circular, combine, constant, projection

RPM = 2.0 * math.pi / 60.0  # [rad/s]


@dataclass(frozen=True)
class Saw(Scene):
    """Power hacksaw, document 002, section 3 and its MATLAB listing (r2 = crank, r3 = rod, r1 - r5 = offset).

    Frame: the slider C is at (0, 0) for crank angle 0 and moves along x, y up; the shaft is at
    (sqrt(l^2 - e^2) - r, -e) and the crank pin at the shaft + r (cos t, sin t). M is the middle of the connecting
    rod and its centre of gravity. The document gives no masses; these are conrod's. SI throughout.
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

    def _check_geometry(self) -> None:
        parameters.check_proportion("rod", self.rod, "crank", self.crank)
        if not self.crank + abs(self.offset) < self.rod:
            raise InvalidInput(
                f"crank + |offset| = {self.crank + abs(self.offset):g} m is too long for the crank to turn fully: "
                f"it must be less than rod = {self.rod:g} m"
            )

    @property
    def shaft(self) -> tuple[float, float]:
        """Place of the shaft [m]."""
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
        """Ground, crank disc, connecting rod and slider; crank pin and slider pin as revolute joints."""
        pin = (self.shaft[0] + self.crank, -self.offset)
        rod_turn = math.atan2(self.offset, -(self.shaft[0] + self.crank))
        observed = (ObservedPoint("C", "slider"), ObservedPoint("M", "rod", (self.rod / 2.0, 0.0)))
        return _slider_crank(self, self.shaft, Driver("shaft"), pin, rod_turn, (0.0, 0.0), 0.0, observed)


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
        up, driver = math.pi / 2, Driver("shaft", sense=-1, start=math.pi / 2)
        observed = (ObservedPoint("A", "slider"), ObservedPoint("G", "rod", (self.rod / 3.0, 0.0)))
        top = (0.0, self.crank + self.rod)
        return _slider_crank(self, (0.0, 0.0), driver, (0.0, self.crank), up, top, up, observed)


def _slider_crank(
    scene: Saw | ShearPress,
    shaft: Point,
    driver: Driver,
    pin: Point,
    rod_turn: float,
    slider: Point,
    direction: float,
    observed: tuple[ObservedPoint, ObservedPoint],
) -> Mechanism:
    """The mechanism with crank pin and slider at their places at crank angle 0 [m], the slide in a direction [rad].

    Args:
        observed: on the slider, and at the rod's centre of gravity.
    """
    return Mechanism(
        name=scene.kind,
        bodies=(
            Body("crank", scene.crank_mass, scene.crank_inertia),
            Body("rod", scene.rod_mass, scene.rod_inertia, observed[1].point),
            Body("slider", scene.slider_mass, 0.01 * scene.slider_mass),  # any inertia: it cannot turn
        ),
        joints=(
            Revolute("shaft", GROUND, "crank", shaft, (0.0, 0.0)),
            Revolute("crank-pin", "crank", "rod", (scene.crank, 0.0), (0.0, 0.0)),
            Revolute("slider-pin", "rod", "slider", (scene.rod, 0.0), (0.0, 0.0)),
            Prismatic("slide", GROUND, "slider", (0.0, 0.0), (0.0, 0.0), direction=direction),
        ),
        driver=driver,
        poses={"crank": (*shaft, driver.start), "rod": (*pin, rod_turn), "slider": (*slider, 0.0)},
        observed=observed,
        gravity=(0.0, -scene.gravity),
    )
