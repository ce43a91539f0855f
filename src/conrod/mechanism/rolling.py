"""Bodies that roll on each other without slip: gears, a rack with its wheel, wheels on tracks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number

RADII = (1e-9, 1e9)  # [m]

Point: TypeAlias = tuple[float, float]  # [m], in the frame of a body


@dataclass(frozen=True)
class Rolling:
    """Two circles that roll on each other without slip: a pair of gears, or a wheel on a round track.

    Other joints hold the centres at the distance |radius_a + radius_b|. With the direction alpha of the line from the
    centre on `a` to that on `b`, what rolls off is radius_a (phi_a - alpha) + radius_b (phi_b - alpha) = offset: turns
    count against the line of centres, so it may stand still or go round with a carrier.

    A circle that holds the other inside it (a ring gear, a concave track) has a negative radius.
    """

    name: str
    a: str
    b: str
    point_a: Point  # the centres
    point_b: Point
    radius_a: float  # [m]
    radius_b: float  # [m]
    offset: float = 0.0  # [m], up to whole turns of the line of centres

    def __post_init__(self) -> None:
        for radius in (self.radius_a, self.radius_b):
            check_number(f"radius of {self.name}", abs(radius), *RADII, "m")
        largest = max((self.radius_a, self.radius_b), key=abs)
        if self.radius_a + self.radius_b == 0.0 or (min(self.radius_a, self.radius_b) < 0.0 < largest):
            raise InvalidInput(
                f"{self.name}: radii {self.radius_a:g} m and {self.radius_b:g} m; the negative one, of the circle that "
                "holds the other, must be the larger"
            )
        if max(self.radius_a, self.radius_b) < 0.0:
            raise InvalidInput(f"{self.name}: of two circles that roll on each other, one at most holds the other")

    @property
    def distance(self) -> float:
        """Between the centres [m]."""
        return abs(self.radius_a + self.radius_b)


@dataclass(frozen=True)
class Rack:
    """A wheel of body `a` rolls without slip on a straight line of body `b`: a rack, or a flat track.

    The wheel's centre is held by other joints on the left of the line, one radius from it. With its way s along the
    line, what rolls off is s + radius (phi_a - phi_b) = offset.
    """

    name: str
    a: str
    b: str
    point_a: Point  # the wheel's centre
    point_b: Point  # on the line
    radius: float  # [m]
    direction: float  # [rad], of the line, in the frame of `b`
    offset: float = 0.0  # [m]

    def __post_init__(self) -> None:
        check_number(f"radius of {self.name}", self.radius, *RADII, "m")


Mesh: TypeAlias = Rolling | Rack
