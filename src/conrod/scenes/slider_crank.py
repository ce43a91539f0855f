"""What all slider-cranks share: dimensions, masses, the check that they turn, and the mechanism."""

from __future__ import annotations

from conrod.errors import InvalidInput
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, ObservedPoint, Point, Prismatic, Revolute
from conrod.mechanism.units import check_proportion
from conrod.scenes.scene import Scene


class SliderCrank(Scene):
    """A crank and a connecting rod that move a slider on a line, which may pass the shaft at an offset.

    Subclasses are frozen dataclasses that state frame, signs and source, and declare these parameters.
    """

    crank: float  # [m], shaft to crank pin
    rod: float  # [m], crank pin to slider pin
    offset: float | None = None  # [m], of the slide's line from the shaft; None for an in-line slider-crank
    crank_mass: float  # [kg], balanced about the shaft
    crank_inertia: float  # [kg m^2], about the shaft
    rod_mass: float  # [kg]
    rod_inertia: float  # [kg m^2], about its centre of gravity
    slider_mass: float  # [kg]
    gravity: float  # [m/s^2], along -y

    def _check_geometry(self) -> None:
        check_proportion("rod", self.rod, "crank", self.crank)
        if self.offset is None and not self.crank < self.rod:
            raise InvalidInput(
                f"crank = {self.crank:g} m is too long to turn fully: it must be shorter than rod = {self.rod:g} m"
            )
        if self.offset is not None and not self.crank + abs(self.offset) < self.rod:
            raise InvalidInput(
                f"crank + |offset| = {self.crank + abs(self.offset):g} m is too long for the crank to turn fully: "
                f"it must be less than rod = {self.rod:g} m"
            )

    def _slider_crank(
        self,
        shaft: Point,
        driver: Driver,
        pin: Point,
        rod_turn: float,
        slider: Point,
        direction: float,
        observed: tuple[ObservedPoint, ObservedPoint],
    ) -> Mechanism:
        """Build the mechanism from its pose at crank angle 0.

        Args:
            shaft, pin, slider: positions [m] of shaft, crank pin and slider, in the document's frame.
            driver: sense and start angle of the crank.
            rod_turn: rotation [rad] of the rod from +x.
            direction: direction of the slide [rad] from +x.
            observed: points on the slider, and at the rod's centre of gravity.
        """
        return Mechanism(
            name=self.kind,
            bodies=(
                Body("crank", self.crank_mass, self.crank_inertia),
                Body("rod", self.rod_mass, self.rod_inertia, observed[1].point),
                Body("slider", self.slider_mass, 0.01 * self.slider_mass),  # any inertia: it cannot turn
            ),
            joints=(
                Revolute("shaft", GROUND, "crank", shaft, (0.0, 0.0)),
                Revolute("crank-pin", "crank", "rod", (self.crank, 0.0), (0.0, 0.0)),
                Revolute("slider-pin", "rod", "slider", (self.rod, 0.0), (0.0, 0.0)),
                Prismatic("slide", GROUND, "slider", (0.0, 0.0), (0.0, 0.0), direction=direction),
            ),
            driver=driver,
            poses={"crank": (*shaft, driver.start), "rod": (*pin, rod_turn), "slider": (*slider, 0.0)},
            observed=observed,
            gravity=(0.0, -self.gravity),
        )
