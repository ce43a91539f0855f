"""The linkages of document 001 whose drawings are lost, at their printed instants, as far as the print fixes them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from audits.pin_instant import PinInstant, Vectors, size, turned
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Prismatic, Revolute
from conrod.scenes import catalogue_scene

SIX_BAR = "six-bar"  # in the catalogue
SIX_BAR_SPEED = 600.0 * 2.0 * math.pi / 60.0  # [rad/s], clockwise


class SixBar:
    """Example 6.15 in the frame of link 4: B at the origin, D on +x, X4 the auxiliary point on the line AB.

    The places are those of the catalogue's file at its crank angle 0, the printed instant: the printed lengths of link
    4 fix B, C, D and X4, and with them the slide (at right angles to D-X4) and A. The directions of O12-A and O15-C are
    lost: they were fitted to the printed velocities. Velocities and accelerations are computed here from the places
    alone, by other equations than the catalogue's motion.
    """

    @cached_property
    def places(self) -> Vectors:
        """Points [m] by name, each (2,)."""
        scene = catalogue_scene(SIX_BAR)
        points = scene.motion([0.0], scene.speed).points
        pivots = {joint.name: joint for joint in scene.mechanism().joints if isinstance(joint, Revolute)}
        return {
            **{name: np.array(pivots[name].point_a) for name in ("O12", "O15")},
            **{name: points[name].position[0] for name in "ABCD"},
        }

    @cached_property
    def slide(self) -> Array:
        """Unit vector (2,) along which D slides."""
        guides = [joint for joint in catalogue_scene(SIX_BAR).mechanism().joints if isinstance(joint, Prismatic)]
        return np.array([math.cos(guides[0].direction), math.sin(guides[0].direction)])

    @cached_property
    def auxiliary(self) -> Array:
        """X4 [m], where the line AB meets the line through D across the slide."""
        along, across = self.places["A"] - self.places["B"], turned(self.slide)
        far = np.linalg.solve(np.column_stack([along, -across]), self.places["D"] - self.places["B"])
        return np.asarray(self.places["B"] + far[0] * along)

    @cached_property
    def _instant(self) -> PinInstant:
        bars = (("A", "B"), ("D", "B"), ("B", "C"), ("C", "D"), ("O15", "C"), ("X", "B"), ("X", "C"), ("X", "D"))
        return PinInstant({**self.places, "X": self.auxiliary}, bars, {"D": turned(self.slide)})

    @cached_property
    def velocities(self) -> Vectors:
        """Velocities [m/s] at the printed instant."""
        crank = self.places["A"] - self.places["O12"]
        return self._instant.velocities(self._driven(-SIX_BAR_SPEED * turned(crank)))

    @cached_property
    def accelerations(self) -> Vectors:
        """Accelerations [m/s^2] at the printed instant, at constant crank speed."""
        crank = self.places["A"] - self.places["O12"]
        return self._instant.accelerations(self._driven(-(SIX_BAR_SPEED**2) * crank), self.velocities)

    @staticmethod
    def _driven(pin: Array) -> Vectors:
        return {"O12": np.zeros(2), "O15": np.zeros(2), "A": pin}

    def speed(self, point: str, other: str | None = None) -> float:
        """Speed of a point, or of one against another [m/s]."""
        return size(self.velocities[point] - (0.0 if other is None else self.velocities[other]))

    def acceleration(self, point: str) -> float:
        """Size of a point's acceleration [m/s^2]."""
        return size(self.accelerations[point])

    def tangential(self, point: str, centre: str) -> float:
        """Size of the part of the relative acceleration across the line from centre to point [m/s^2]."""
        arm = self._instant.places[point] - self._instant.places[centre]
        return abs(float((self.accelerations[point] - self.accelerations[centre]) @ turned(arm))) / size(arm)


# The velocities of Example 6.15's polygon [m/s]: of a point, or of a pair against each other; without V_X4/B, which the
# others contradict.
SIX_BAR_POLYGON = {"C": 7.4, "D": 6.4, "B": 12.2, "X": 25.6, "BA": 4.0, "XC": 25.4, "XD": 18.8, "DC": 9.4}
SCAN = np.radians(np.arange(0.0, 360.0, 0.5))


def least_misfit() -> float:
    """The largest deviation [m/s] that is left in the polygon by the pose that suits it best.

    All poses of the printed lengths are tried, in steps of half a degree: the directions of O12-A and of O15-C. X4
    moves along the slide, and as fast along AB as A does; link 4 turns so that C moves across O15-C.
    """
    bar = SixBar()
    place = {**bar.places, "X": bar.auxiliary}
    crank, rocker = np.meshgrid(SCAN, SCAN[: len(SCAN) // 2], indexing="ij")
    velocity = {"A": 0.2 * -SIX_BAR_SPEED * np.array([np.sin(crank), -np.cos(crank)])}
    along = (place["A"] - place["B"]) / size(place["A"] - place["B"])
    pace = np.tensordot(along, velocity["A"], 1) / (bar.slide @ along)
    velocity["X"] = bar.slide[:, None, None] * pace
    arm = np.array([np.cos(rocker), np.sin(rocker)])
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = -np.sum(velocity["X"] * arm, 0) / np.tensordot(turned(place["C"] - place["X"]), arm, 1)
        for name in "BCD":
            velocity[name] = velocity["X"] + turn * turned(place[name] - place["X"])[:, None, None]
        off = [
            np.abs(np.hypot(*(velocity[pair[0]] - (velocity[pair[1]] if len(pair) == 2 else 0.0))) - printed)
            for pair, printed in SIX_BAR_POLYGON.items()
        ]
    return float(np.nanmin(np.max(off, axis=0)))


@dataclass(frozen=True)
class RackLinkage:
    """Example 6.18, built from its velocity triangle: V_B, V_C and V_C/B [m/s] fix the directions of all links."""

    speed_b: float = 6.0
    speed_c: float = 6.9
    relative: float = 5.0
    arm_b, arm_c, rod = 0.3, 0.13, 0.25  # O14-B, O12-C, B-C [m]

    def tangential(self, normal_b: float) -> tuple[float, float]:
        """Tangential accelerations of C and of B against C [m/s^2], in size, from the normal one of B.

        The acceleration of B points to O14 with that size, since its wheel turns at constant speed.
        """
        turn = (self.speed_b**2 + self.speed_c**2 - self.relative**2) / (2.0 * self.speed_b * self.speed_c)
        b, c = complex(self.speed_b), self.speed_c * complex(turn, math.sqrt(1.0 - turn**2))
        # A link of length l whose end moves at v against the other lies along v/(i w), w = +-|v|/l; the signs are
        # those of the recovered drawing (link 2 turns against links 3 and 4).
        to_b = b / (1j * self.speed_b / self.arm_b)
        to_c, rod = c / (-1j * self.speed_c / self.arm_c), (c - b) / (1j * self.relative / self.rod)
        normal_c = -((self.speed_c / self.arm_c) ** 2) * to_c
        normal_rod = -((self.relative / self.rod) ** 2) * rod
        # normal_c + x i to_c = a_B + normal_rod + y i rod, solved for x and y.
        rest = -normal_b * to_b / abs(to_b) + normal_rod - normal_c
        columns = np.array([[(1j * to_c).real, -(1j * rod).real], [(1j * to_c).imag, -(1j * rod).imag]])
        x, y = np.linalg.solve(columns, [rest.real, rest.imag])
        return abs(float(x)) * self.arm_c, abs(float(y)) * self.rod

    def spread(self, normal_b: float, part: int, reading: float) -> float:
        """Change that reading V_C and V_C/B wrong by that much makes to a tangential acceleration [m/s^2]."""
        middle = self.tangential(normal_b)[part]
        corners = [
            RackLinkage(self.speed_b, self.speed_c + s * reading, self.relative + t * reading).tangential(normal_b)
            for s in (-1, 1)
            for t in (-1, 1)
        ]
        return max(abs(corner[part] - middle) for corner in corners)
