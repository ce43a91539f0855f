"""The base class of all scenes, those with a closed form and those that files describe."""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property, partial
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from conrod.errors import Named
from conrod.exact.kinematics import ExactReference
from conrod.exact.motion import Array, Derivatives, Motion, PointDerivatives, Side, diameter, motion_in_time
from conrod.mechanism.units import REVOLUTION, Parameter, parameters_of

# Samples from which a point's travel is computed: extremes between samples exceed it by at most
# (pi / 7200)^2 / 2 = 1e-7, far below what a normalising length needs.
SAMPLES_PER_REVOLUTION = 7200
SAMPLES_TOGETHER = 8192  # computed at once: more would not fit the cache, fewer would be mostly overhead


_encode = json.JSONEncoder(sort_keys=True, allow_nan=False, separators=(",", ":")).encode  # made once for all keys


def canonical_json(values: Any) -> str:
    """JSON text of plain values with sorted keys; it is hashed into the keys of runs, so it must never change.

    Raises:
        ValueError: a float is not finite.
        TypeError: a value is not plain.
    """
    return _encode(values)


class Scene(ExactReference):
    """A mechanism with parameters, masses and an exact motion; its subclasses are frozen dataclasses."""

    closed_form: ClassVar[bool] = True  # whether its motion is known without the generic solver
    drawn_at: ClassVar[float] = 60.0  # [deg], a crank angle at which the links stand clear of each other and the frame

    # Texts of a class of scenes; a scene from a file has its own.
    kind: str  # name of the kind of machine
    title: str  # heading of a report
    source: str  # document, and what was taken from it
    output: str  # the observed point that does the machine's work
    description: str  # for the report; {parameter} stands for a parameter's value with its unit
    frame: str  # origin, axes and the crank angle's sense
    assumptions: tuple[str, ...] = ()  # where the source is silent, a sentence or clause each

    def __post_init__(self) -> None:
        for name, parameter in parameters_of(type(self)).items():
            parameter.check(getattr(self, name))
        self._check_geometry()

    def as_saved(self) -> dict[str, object]:
        """Plain values to save: the scene's kind and its parameters."""
        return {"machine": self.kind, "parameters": dict(self.parameters)}

    def __reduce__(self) -> tuple[object, ...]:
        # A pickle holds the parameters alone, so that no computed value outlives the code that computed it.
        return partial(type(self), **self.parameters), ()

    @abstractmethod
    def _check_geometry(self) -> None:
        """Refuse a machine that cannot be assembled or cannot turn fully; raises InvalidInput."""

    @abstractmethod
    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        """x and y of every observed point with three derivatives by the crank angle at (T,) [rad], exact."""

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        theta = np.atleast_1d(np.asarray(angle, dtype=float))
        return motion_in_time(
            lambda some: self._angle_derivatives(some, side), theta, speed, acceleration, SAMPLES_TOGETHER
        )

    # -- facts -------------------------------------------------------------------------------------------------

    @property
    def start_rates(self) -> dict[str, float]:
        """Turn rates [rad/s] of bodies, counter-clockwise, at the start of a free motion: the crank's speed."""
        mechanism = self.kinematics.mechanism
        return {mechanism.crank: mechanism.driver.sense * self.speed}

    @cached_property
    def parameters(self) -> dict[str, float]:
        """Values of all parameters, SI, by name."""
        return Named({name: getattr(self, name) for name in parameters_of(type(self))}, "parameter")

    def identity(self) -> dict[str, Any]:
        """Plain values that distinguish this scene from others of its kind."""
        return dict(self.parameters)

    @cached_property
    def parameters_text(self) -> str:
        """Canonical JSON of `identity`, which distinguishes scenes in any process."""
        return canonical_json(self.identity())

    def with_parameters(self, **values: float) -> Self:
        """Return the scene with other parameter values, SI; raises InvalidInput as the constructor does."""
        for name in values:
            _ = self.parameters[name]  # an unknown name raises an error with the nearest one
        return type(self)(**(self.parameters | values))

    def with_nearby_parameters(self, **values: float) -> Self:
        """Return `with_parameters`, where these values are near the scene's own: to rounding as exact, and sooner.

        What it rounds to depends on this scene: it is for fits, and no run or verdict is made with it.
        """
        return self.with_parameters(**values)

    def parameter_facts(self) -> dict[str, Parameter]:
        """Unit, meaning and range of each parameter, by name."""
        return parameters_of(type(self))

    def disc_radii(self) -> dict[str, float]:
        """Radii [m] of the bodies that are described as uniform discs, about their centres of gravity."""
        return {}

    @cached_property
    def lengths(self) -> dict[str, float]:
        span = self.mechanism().driver.span
        angles = np.linspace(*(span or (0.0, REVOLUTION)), SAMPLES_PER_REVOLUTION, endpoint=span is not None)
        travel = {name: diameter(p.position) for name, p in self.motion(angles, self.speed).points.items()}
        return Named(travel, "observed point")


# -- closed forms ------------------------------------------------------------------------------------------------------
#
# Functions of the crank angle with three derivatives, each an array (T,), or a number if it is constant.


def projection(length: Array | float, across: Derivatives) -> Derivatives:
    """Extent w = sqrt(length^2 - u^2) of a rod of fixed length along an axis, with three derivatives.

    It is the only radical of the closed forms here. From w^2 = l^2 - u^2, differentiated: w w' = -u u';
    w'^2 + w w'' = -(u'^2 + u u''); 3 w' w'' + w w''' = -(3 u' u'' + u u''').

    Args:
        length: l [m], with |u| < l.
        across: u, u', u'', u''' [m], the rod's extent across the axis.
    """
    u, u1, u2, u3 = across
    w = np.sqrt((length - u) * (length + u))
    # In place, because this takes most of the time of an exact motion.
    back = -w
    w1 = u * u1
    w1 /= back
    w2 = u1 * u1
    w2 += u * u2
    w2 += w1 * w1
    w2 /= back
    w3 = u1 * u2
    w3 += w1 * w2
    w3 *= 3.0
    w3 += u * u3
    w3 /= back
    return w, w1, w2, w3


def circular(radius: Array | float, sine: Array, cosine: Array) -> tuple[Derivatives, Derivatives]:
    """Functions radius cos t and radius sin t with three derivatives by t."""
    x, y = radius * cosine, radius * sine
    back_x, back_y = -x, -y
    return (x, back_y, back_x, y), (y, x, back_y, back_x)


def constant(value: float) -> Derivatives:
    """A constant with its derivatives, which are zero."""
    return value, 0.0, 0.0, 0.0


def combine(*terms: tuple[float, Derivatives]) -> Derivatives:
    """Weighted sum of functions with their derivatives."""
    w, x, y, z = (_weighted_sum([(weight, values[k]) for weight, values in terms]) for k in range(4))
    return w, x, y, z


def _weighted_sum(terms: list[tuple[float, Array | float]]) -> Array | float:
    # Zeros and weights of 1 need no pass over the samples.
    """Weighted sum of numbers and arrays (T,), without passes over the samples for zeros and weights of 1."""
    found = [v if w == 1.0 else w * v for w, v in terms if not (isinstance(v, float) and v == 0.0)]
    return sum(found[1:], found[0]) if found else 0.0
