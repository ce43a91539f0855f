"""Loads of a machine as functions of a standalone Python module: the forces of `LoadForces`, without conrod."""

from __future__ import annotations

from collections.abc import Callable
from typing import assert_never

from conrod.errors import InvalidInput
from conrod.mechanism.loads import (
    Coordinate,
    Displacement,
    Distance,
    Elastic,
    Friction,
    Load,
    LoadLaw,
    Point,
    Sampled,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)

PlaceText = Callable[[str, Point], str]  # a body's point as Python, in pymunk's frame of the body


def load_calls(loads: tuple[Load, ...], place: PlaceText) -> list[tuple[str, str, str]]:
    """Name of each load, its coordinate as a call of a module's function, and its force as an expression.

    The expression has the coordinate's `value` and `rate`, and the `instant` [s].
    """
    return [(load.name, _coordinate_call(load.along, place), _force_expression(load.law)) for load in loads]


def _coordinate_call(coordinate: Coordinate, place: PlaceText) -> str:
    """Call that returns value, rate and gradient of a coordinate."""
    match coordinate:
        case Distance():
            ends = ((coordinate.a, coordinate.point_a), (coordinate.b, coordinate.point_b))
            return f"_distance(state, {', '.join(f'({body!r}, {place(body, point)})' for body, point in ends)})"
        case Turn():
            return f"_turn(state, {coordinate.a!r}, {coordinate.b!r})"
        case Displacement():
            point = f"({coordinate.body!r}, {place(coordinate.body, coordinate.point)})"
            return f"_displacement(state, {point}, {coordinate.direction!r})"
        case _:
            assert_never(coordinate)


def _force_expression(law: LoadLaw) -> str:
    """Force [N], or torque [N m], along the coordinate, by the equations of `conrod.mechanism.loads`."""
    match law:
        case Elastic():
            found = f"{-law.stiffness!r} * (value - {law.rest!r})"
        case Viscous():
            found = f"{-law.damping!r} * rate"
        case Steady():
            found = repr(law.size)
        case Friction():
            found = f"{-law.size!r} * math.tanh(rate / {law.creep!r})"
        case SpeedLine():
            found = f"{law.size!r} * (1.0 - rate / {law.idle!r})"
        case StrokePulse():
            pulse = f"_pulse(value, {law.start!r}, {law.stop!r})"
            found = f"{-law.sense * law.peak!r} * {pulse} if rate * {law.sense} > 0.0 else 0.0"
        case TimePulse():
            found = f"{law.peak!r} * _pulse(instant, {law.start!r}, {law.stop!r})"
        case Sampled():
            raise InvalidInput("a force given at instants is not written into a module: set it at each step")
        case _:
            assert_never(law)
    return found
