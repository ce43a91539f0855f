"""Springs, dampers, friction, forces and torques of a mechanism, each as a law along one coordinate.

A load acts along a coordinate xi of the configuration: the distance of two points, the rotation of a body against
another, or the displacement of a point in a direction. Its law gives the force, or torque, F(xi, xi', t) in the sense
of growing xi, so its power is F xi'. A spring on a distance, a cutting force along a slide and a motor's torque are
cases of this; the generalised force on the bodies is F times the coordinate's gradient.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from conrod.errors import InvalidInput
from conrod.mechanism.cam import Array

Point: TypeAlias = tuple[float, float]  # [m], in the frame of a body


@dataclass(frozen=True)
class Distance:
    """Coordinate: distance [m] of a point of body `b` from a point of body `a`."""

    a: str
    b: str
    point_a: Point
    point_b: Point


@dataclass(frozen=True)
class Turn:
    """Coordinate: rotation [rad] of body `b` against body `a`, counter-clockwise."""

    a: str
    b: str


@dataclass(frozen=True)
class Displacement:
    """Coordinate: position [m] of a body's point along a direction, from the document's origin."""

    body: str
    point: Point
    direction: float  # [rad]


Coordinate: TypeAlias = Distance | Turn | Displacement


@dataclass(frozen=True)
class Elastic:
    """A linear spring: force -stiffness (xi - rest)."""

    stiffness: float  # [N/m] or [N m/rad]
    rest: float = 0.0  # [m] or [rad]

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        return np.asarray(-self.stiffness * (value - self.rest))

    def energy(self, value: Array) -> Array:
        return np.asarray(0.5 * self.stiffness * (value - self.rest) ** 2)


@dataclass(frozen=True)
class Viscous:
    """A linear damper: force -damping xi'."""

    damping: float  # [N s/m] or [N m s/rad]

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        return np.asarray(-self.damping * rate)


@dataclass(frozen=True)
class Steady:
    """A constant force."""

    size: float  # [N] or [N m]

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        return np.asarray(self.size + 0.0 * value)

    def energy(self, value: Array) -> Array:
        return np.asarray(-self.size * value)


@dataclass(frozen=True)
class Friction:
    """Dry friction with a smooth change of sign: -size tanh(xi' / creep)."""

    size: float  # [N] or [N m]
    creep: float  # [m/s] or [rad/s], the rate below which it has not come up yet

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        return np.asarray(-self.size * np.tanh(rate / self.creep))


@dataclass(frozen=True)
class SpeedLine:
    """A motor's linear characteristic: size (1 - xi' / idle)."""

    size: float  # [N m], at rest
    idle: float  # [rad/s], where it gives nothing

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        return np.asarray(self.size * (1.0 - rate / self.idle))


@dataclass(frozen=True)
class StrokePulse:
    """A working force over a part of a stroke, against one direction of motion only, as of a press or a saw.

    The force is -sense x peak x sin^2(pi (xi - start) / (stop - start)) between start and stop while xi' has the sense.
    It rises and falls without a kink if start and stop lie within the stroke, where xi' is not 0.
    """

    peak: float  # [N]
    start: float  # [m]
    stop: float  # [m]
    sense: int  # +1: resists growth of xi; -1: resists its fall

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        share = np.clip((value - self.start) / (self.stop - self.start), 0.0, 1.0)
        cuts = np.asarray(rate) * self.sense > 0.0
        return np.asarray(np.where(cuts, -self.sense * self.peak * np.sin(math.pi * share) ** 2, 0.0))


@dataclass(frozen=True)
class TimePulse:
    """A pulse of one squared half wave: peak sin^2(pi (t - start) / (stop - start)) between two times."""

    peak: float  # [N] or [N m]
    start: float  # [s]
    stop: float  # [s]

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        share = np.clip((time - self.start) / (self.stop - self.start), 0.0, 1.0)
        return np.asarray(self.peak * np.sin(math.pi * share) ** 2 + 0.0 * value)


@dataclass(frozen=True)
class Sampled:
    """A force given at instants; constant before the first and after the last.

    Attributes:
        times: instants [s], growing.
        sizes: force at each [N] or [N m].
        between: between two instants `linear`, or held: the value of the `previous` or of the `next` one.
    """

    times: tuple[float, ...]
    sizes: tuple[float, ...]
    between: str = "linear"

    def force(self, value: Array, rate: Array, time: Array) -> Array:
        return np.asarray(self._sizes_at(time) + 0.0 * value)

    def _sizes_at(self, time: Array) -> Array:
        times, sizes = self._arrays
        if self.between == "linear":
            return np.asarray(np.interp(time, times, sizes))
        if self.between == "previous":
            place = np.searchsorted(times, time, side="right") - 1
        else:
            place = np.searchsorted(times, time, side="left")
        return np.asarray(sizes[np.clip(place, 0, len(sizes) - 1)])

    @cached_property
    def _arrays(self) -> tuple[Array, Array]:
        return np.array(self.times), np.array(self.sizes)

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Instants [s] at which the force jumps, or its first derivative does."""
        times, sizes = self._arrays
        if self.between != "linear":
            jumps = np.flatnonzero(np.diff(sizes) != 0.0)
            return tuple(times[jumps + (self.between == "previous")].tolist())
        slopes = np.concatenate([[0.0], np.diff(sizes) / np.diff(times), [0.0]])
        return tuple(times[np.diff(slopes) != 0.0].tolist())


# `force` is along the coordinate (T,) [N], or [N m] of a turn, at values, rates and times (T,), SI; `energy` [J] is
# what a conservative one stores.
LoadLaw: TypeAlias = Elastic | Viscous | Steady | Friction | SpeedLine | StrokePulse | TimePulse | Sampled
CONSERVATIVE = (Elastic, Steady)


@dataclass(frozen=True)
class Load:
    """A law along a coordinate; raises InvalidInput if a pulse ends before it begins."""

    name: str
    along: Coordinate
    law: LoadLaw

    def __post_init__(self) -> None:
        if isinstance(self.law, StrokePulse | TimePulse) and not self.law.start < self.law.stop:
            raise InvalidInput(f"{self.name}: begin = {self.law.start:g} must be less than end = {self.law.stop:g}")

    @property
    def unit(self) -> str:
        """Unit of the coordinate: rad or m."""
        return "rad" if isinstance(self.along, Turn) else "m"

    @property
    def conservative(self) -> bool:
        """True if the force derives from a potential of the configuration."""
        return isinstance(self.law, CONSERVATIVE)

    def identity(self) -> dict[str, Any]:
        """All values of the load, with the class names of its coordinate and its law."""
        parts = {"along": self.along, "law": self.law}
        return {"name": self.name} | {
            part: {"kind": type(value).__name__} | asdict(value) for part, value in parts.items()
        }
