"""The base of all scenes: those with a closed form, and those that files describe."""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property, partial
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from conrod.errors import Named
from conrod.exact import ExactReference
from conrod.exact.motion import Array, Derivatives, Motion, PointDerivatives, Side, diameter, motion_in_time
from conrod.mechanism.units import REVOLUTION, Parameter, parameters_of

# Samples of one turn from which a point's range of positions is read: the extremes lie between samples by at most
# (pi / 7200)^2 / 2 = 1e-7 of it, far below what a normalising length needs.
SAMPLES_PER_TURN = 7200
# Samples computed together: more would not fit the cache, fewer would be mostly calls.
CHUNK = 8192


def canonical(values: Any) -> str:
    """JSON of plain values, keys sorted: what is hashed to the key of a run, so it must never change.

    Raises:
        ValueError: a float is not finite.
        TypeError: a value is not plain.
    """
    return json.dumps(values, sort_keys=True, allow_nan=False, separators=(",", ":"))


class Scene(ExactReference):
    """A mechanism with parameters, masses and an exact motion; its subclasses are frozen dataclasses."""

    closed_form: ClassVar[bool] = True  # whether its motion is known without the generic solver
    drawn_at: ClassVar[float] = 60.0  # [deg], a crank angle at which the links stand clear of each other and the frame

    # What a class of scenes says of itself; a scene that a file describes says it for itself.
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
        """Saved form: its kind and its parameters."""
        return {"machine": self.kind, "parameters": dict(self.parameters)}

    def __reduce__(self) -> tuple[object, ...]:
        # A pickle carries the parameters alone: what was computed from them belongs to the code that computed it.
        return partial(type(self), **self.parameters), ()

    @abstractmethod
    def _check_geometry(self) -> None:
        """Refuse what cannot be assembled or cannot turn fully; raises InvalidInput."""

    @abstractmethod
    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        """x and y of every observed point with their derivatives by the crank angle at angles (T,), exact."""

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        theta = np.atleast_1d(np.asarray(angle, dtype=float))
        return motion_in_time(lambda some: self._angle_derivatives(some, side), theta, speed, acceleration, CHUNK)

    # -- facts -------------------------------------------------------------------------------------------------

    @property
    def start_rates(self) -> dict[str, float]:
        """Turn rates [rad/s] of bodies, counter-clockwise, that a motion without a drive starts with: the crank's."""
        mechanism = self.kinematics.mechanism
        return {mechanism.crank: mechanism.driver.sense * self.speed}

    @cached_property
    def parameters(self) -> dict[str, float]:
        """Values of all parameters, SI."""
        return Named({name: getattr(self, name) for name in parameters_of(type(self))}, "parameter")

    def identity(self) -> dict[str, Any]:
        """All that distinguishes a scene from others of its kind, as plain values."""
        return dict(self.parameters)

    @cached_property
    def parameters_text(self) -> str:
        """The same in one canonical text, which distinguishes scenes in any process."""
        return canonical(self.identity())

    def with_parameters(self, **values: float) -> Self:
        """The same scene with other parameter values, SI; raises InvalidInput as the constructor does."""
        for name in values:
            _ = self.parameters[name]  # an unknown one is answered with the nearest
        return type(self)(**(self.parameters | values))

    def parameter_facts(self) -> dict[str, Parameter]:
        """Unit, meaning and range of all parameters."""
        return parameters_of(type(self))

    @cached_property
    def lengths(self) -> dict[str, float]:
        span = self.mechanism().driver.span
        angles = np.linspace(*(span or (0.0, REVOLUTION)), SAMPLES_PER_TURN, endpoint=span is not None)
        travel = {name: diameter(p.position) for name, p in self.motion(angles, self.speed).points.items()}
        return Named(travel, "observed point")


# -- closed forms ------------------------------------------------------------------------------------------------------


def projection(length: Array | float, across: Derivatives) -> Derivatives:
    """Extent w = sqrt(length^2 - u^2) of a rod of fixed length along an axis, with its first three derivatives.

    It is the one radical that every closed form here is made of.
    From w^2 = l^2 - u^2, differentiated: w w' = -u u'; w'^2 + w w'' = -(u'^2 + u u'');
    3 w' w'' + w w''' = -(3 u' u'' + u u''').

    Args:
        length: l [m], with |u| < l.
        across: u, u', u'', u''' [m], the rod's extent across the axis.
    """
    u, u1, u2, u3 = across
    w = np.sqrt((length - u) * (length + u))
    # In place, because this is most of what an exact motion costs.
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
    """radius x cos t and radius x sin t with their first three derivatives by t."""
    x, y = radius * cosine, radius * sine
    back_x, back_y = -x, -y
    return (x, back_y, back_x, y), (y, x, back_y, back_x)


def constant(value: float) -> Derivatives:
    """A number with its derivatives, which are none."""
    return value, 0.0, 0.0, 0.0


def combine(*terms: tuple[float, Derivatives]) -> Derivatives:
    """Weighted sum of functions with their derivatives."""
    w, x, y, z = (_weighted_sum([(weight, values[k]) for weight, values in terms]) for k in range(4))
    return w, x, y, z


def _weighted_sum(terms: list[tuple[float, Array | float]]) -> Array | float:
    # Numbers that are 0, and weights of 1, take no pass over the samples.
    found = [v if w == 1.0 else w * v for w, v in terms if not (isinstance(v, float) and v == 0.0)]
    return sum(found[1:], found[0]) if found else 0.0
