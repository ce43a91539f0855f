"""Springs, dampers, forces and torques of a mechanism as forces applied to a pymunk `Space` before every step.

Chipmunk's own springs (`DampedSpring`, `DampedRotarySpring`) have order 2, but their dampers act half a step late, with
order 1, and they have no other laws. A force of the state before the step has order 1, one of the state at the right
instant order 2 with every law; for a spring it equals that of `DampedSpring`. Largest error of a pose of a slider-crank
that swings for a second on a spring and a damper, at h = 0.5 ms: 1.8e-5, 9.8e-5 with `DampedSpring`, 3.6e-3 with forces
of the step's start.

The right instant is the one to which the difference of two velocities belongs: the step's end for joints, its middle
for contact (see `SampleInstants`). Positions are extrapolated to it by the step's own rule, rates by their last
difference.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, assert_never

import numpy as np

from conrod.engines.engine import DeferredLibrary
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.space import PymunkSpace
from conrod.mechanism.loads import Coordinate, Displacement, Distance, Turn
from conrod.mechanism.mechanism import GROUND, Point

if TYPE_CHECKING:
    import pymunk
else:
    pymunk = DeferredLibrary("pymunk")

State = list[float]  # three numbers for each body: for its centre of gravity, and its angle


@dataclass(frozen=True)
class _PointState:
    """A point of a body: position [m], velocity [m/s], and arm from the centre of gravity [m]."""

    x: float
    y: float
    vx: float
    vy: float
    rx: float
    ry: float


def driven_loads(made: PymunkSpace, settings: PymunkSettings) -> LoadForces | None:
    """The loads of a machine that is driven at constant speed, or None if it has none.

    A velocity belongs to half a step after its step, with contact to the step's end (`SampleInstants`).
    """
    ahead = 0.0 if made.mechanism.cam_contacts else 0.5 * settings.timestep
    return LoadForces(made, settings.timestep, ahead) if made.mechanism.loads else None


class LoadForces:
    """Applies a machine's loads to the bodies of its space.

    Args:
        step: time step of the space [s].
        ahead: time from the end of a step to the instant of its velocity [s].
    """

    def __init__(self, made: PymunkSpace, step: float, ahead: float) -> None:
        self._made, self._step, self._ahead = made, step, ahead
        self._known: tuple[float, State] | None = None
        constant = dict(made.constant_forces)
        self._constant = [constant.get(body, (0.0, 0.0)) for body in made.bodies]

    def apply_for_step(self, time: float) -> State:
        """Apply forces for the step that starts at a time [s]; return the loads' generalised forces (3 n,)."""
        places, rates = _read_states(self._made.bodies)
        now = time + self._ahead
        goal = time + 0.5 * self._step + self._ahead
        expected = rates
        if self._known is not None and now > self._known[0]:
            share = (goal - now) / (now - self._known[0])
            expected = [v + share * (v - before) for v, before in zip(rates, self._known[1], strict=True)]
        self._known = now, rates
        way = goal - time
        return self._apply_forces([x + way * v for x, v in zip(places, rates, strict=True)], expected, goal)

    def apply_now(self, time: float) -> State:
        """Apply the forces of the present state at a time [s]; return the loads' generalised forces (3 n,)."""
        places, rates = _read_states(self._made.bodies)
        self._known = time, rates
        return self._apply_forces(places, rates, time)

    def _apply_forces(self, places: State, rates: State, time: float) -> State:
        """Apply loads and constant forces in a state; return the loads' generalised forces (3 n,)."""
        sums = [0.0] * len(places)
        for load in self._made.mechanism.loads:
            value, rate, gradient = self._coordinate_and_gradient(load.along, places, rates)
            force = float(load.law.force(np.array(value), np.array(rate), np.array(time)))
            for body, parts in gradient:
                if body != GROUND:
                    i = 3 * self._made.mechanism.body_index[body]
                    for k, part in enumerate(parts):
                        sums[i + k] += force * part
        for i, (own, (x, y)) in enumerate(zip(self._made.bodies, self._constant, strict=True)):
            own.force = (sums[3 * i] + x, sums[3 * i + 1] + y)
            own.torque = sums[3 * i + 2]
        return sums

    def _coordinate_and_gradient(
        self, coordinate: Coordinate, places: State, rates: State
    ) -> tuple[float, float, list[tuple[str, tuple[float, float, float]]]]:
        """A load's coordinate, its rate, and its gradient by the bodies it depends on."""
        match coordinate:
            case Distance():
                a, b = (
                    self._point_state(body, point, places, rates)
                    for body, point in ((coordinate.a, coordinate.point_a), (coordinate.b, coordinate.point_b))
                )
                dx, dy = b.x - a.x, b.y - a.y
                length = math.hypot(dx, dy)
                ux, uy = (dx / length, dy / length) if length > 0.0 else (0.0, 0.0)
                rate = ux * (b.vx - a.vx) + uy * (b.vy - a.vy)
                return length, rate, [(coordinate.b, _unit_force(b, ux, uy)), (coordinate.a, _unit_force(a, -ux, -uy))]
            case Turn():
                turn_a, spin_a = self._body_angle(coordinate.a, places, rates)
                turn_b, spin_b = self._body_angle(coordinate.b, places, rates)
                return (
                    turn_b - turn_a,
                    spin_b - spin_a,
                    [(coordinate.b, (0.0, 0.0, 1.0)), (coordinate.a, (0.0, 0.0, -1.0))],
                )
            case Displacement():
                place = self._point_state(coordinate.body, coordinate.point, places, rates)
                ux, uy = math.cos(coordinate.direction), math.sin(coordinate.direction)
                way, rate = place.x * ux + place.y * uy, place.vx * ux + place.vy * uy
                return way, rate, [(coordinate.body, _unit_force(place, ux, uy))]
            case _:
                assert_never(coordinate)

    def _body_angle(self, body: str, places: State, rates: State) -> tuple[float, float]:
        """Angle [rad] and angular rate [rad/s] of a body at a state."""
        if body == GROUND:
            return 0.0, 0.0
        i = 3 * self._made.mechanism.body_index[body] + 2
        return places[i], rates[i]

    def _point_state(self, body: str, point: Point, places: State, rates: State) -> _PointState:
        """State of a body's point, from the states of all bodies."""
        px, py = self._made.to_body_frame(body, point)
        if body == GROUND:
            return _PointState(px, py, 0.0, 0.0, px, py)
        i = 3 * self._made.mechanism.body_index[body]
        cosine, sine, spin = math.cos(places[i + 2]), math.sin(places[i + 2]), rates[i + 2]
        rx, ry = cosine * px - sine * py, sine * px + cosine * py
        return _PointState(places[i] + rx, places[i + 1] + ry, rates[i] - spin * ry, rates[i + 1] + spin * rx, rx, ry)


def _unit_force(place: _PointState, ux: float, uy: float) -> tuple[float, float, float]:
    """Force and moment (3,) on a body of a unit force at one of its points."""
    return ux, uy, place.rx * uy - place.ry * ux


def _read_states(bodies: tuple[pymunk.Body, ...]) -> tuple[State, State]:
    """Positions with angles and their rates of all bodies, read through public properties."""
    places: State = []
    rates: State = []
    for body in bodies:
        places += (*body.position, body.angle)
        rates += (*body.velocity, body.angular_velocity)
    return places, rates
