"""Springs, dampers, forces and torques of a mechanism as forces that a pymunk `Space` is given before every step.

Chipmunk's own springs (`DampedSpring`, `DampedRotarySpring`) have order 2, but their dampers act half a step late, with
order 1, and other laws they cannot have. A force of the state before the step has order 1, that of the state at the
right instant order 2 with every law; with a spring it gives what `DampedSpring` gives. A slider-crank that swings for a
second on a spring and a damper, largest error of a pose at h = 0.5 ms: 1.8e-5, 9.8e-5 with `DampedSpring`, 3.6e-3 with
forces of the step's beginning.

The right instant is the one to which the difference of two velocities belongs: the step's end for joints, its middle
for contact (see `Staggered`). Positions are extrapolated to it by the step's own rule, rates by their last difference.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import assert_never

import numpy as np
import pymunk

from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.space import Build
from conrod.mechanism.loads import Coordinate, Displacement, Distance, Turn
from conrod.mechanism.mechanism import GROUND, Point

State = list[float]  # of all bodies, three numbers each: of the centre of gravity, and of the turn


@dataclass(frozen=True)
class _Place:
    """A point at a state: where it is, its velocity, and its arm from the centre of gravity."""

    x: float
    y: float
    vx: float
    vy: float
    rx: float
    ry: float


def pushes_of(made: Build, settings: PymunkSettings) -> Pushes | None:
    """The loads of a machine in a space that is driven at constant speed; None where it has none.

    A velocity belongs to half a step after its step, with contact to the step's end (`Staggered`).
    """
    ahead = 0.0 if made.mechanism.cam_contacts else 0.5 * settings.timestep
    return Pushes(made, settings.timestep, ahead) if made.mechanism.loads else None


class Pushes:
    """The loads of a machine on the bodies of its space.

    Args:
        step: of the space [s].
        ahead: from the end of a step to the instant of the velocity that it made [s].
    """

    def __init__(self, made: Build, step: float, ahead: float) -> None:
        self._made, self._step, self._ahead = made, step, ahead
        self._known: tuple[float, State] | None = None
        constant = dict(made.pushed)
        self._constant = [constant.get(body, (0.0, 0.0)) for body in made.bodies]

    def give(self, time: float) -> State:
        """Give all bodies the forces for the step that begins now, at a time [s]; generalised, of the loads alone."""
        places, rates = _state(self._made.bodies)
        now = time + self._ahead
        goal = time + 0.5 * self._step + self._ahead
        expected = rates
        if self._known is not None and now > self._known[0]:
            share = (goal - now) / (now - self._known[0])
            expected = [v + share * (v - before) for v, before in zip(rates, self._known[1], strict=True)]
        self._known = now, rates
        way = goal - time
        return self._given([x + way * v for x, v in zip(places, rates, strict=True)], expected, goal)

    def as_they_are(self, time: float) -> State:
        """Give all bodies the forces of their state as it is, at a time [s]."""
        places, rates = _state(self._made.bodies)
        self._known = time, rates
        return self._given(places, rates, time)

    def _given(self, places: State, rates: State, time: float) -> State:
        """Generalised forces of all loads at a state, which the bodies are given beside constant ones."""
        sums = [0.0] * len(places)
        for load in self._made.mechanism.loads:
            value, rate, gradient = self._along(load.along, places, rates)
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

    def _along(
        self, along: Coordinate, places: State, rates: State
    ) -> tuple[float, float, list[tuple[str, tuple[float, float, float]]]]:
        """A coordinate, its rate, and its gradient by the bodies that it depends on."""
        match along:
            case Distance():
                a, b = (
                    self._place(body, point, places, rates)
                    for body, point in ((along.a, along.point_a), (along.b, along.point_b))
                )
                dx, dy = b.x - a.x, b.y - a.y
                length = math.hypot(dx, dy)
                ux, uy = (dx / length, dy / length) if length > 0.0 else (0.0, 0.0)
                rate = ux * (b.vx - a.vx) + uy * (b.vy - a.vy)
                return length, rate, [(along.b, _push(b, ux, uy)), (along.a, _push(a, -ux, -uy))]
            case Turn():
                turn_a, spin_a = self._turn(along.a, places, rates)
                turn_b, spin_b = self._turn(along.b, places, rates)
                return turn_b - turn_a, spin_b - spin_a, [(along.b, (0.0, 0.0, 1.0)), (along.a, (0.0, 0.0, -1.0))]
            case Displacement():
                place = self._place(along.body, along.point, places, rates)
                ux, uy = math.cos(along.direction), math.sin(along.direction)
                way, rate = place.x * ux + place.y * uy, place.vx * ux + place.vy * uy
                return way, rate, [(along.body, _push(place, ux, uy))]
            case _:
                assert_never(along)

    def _turn(self, body: str, places: State, rates: State) -> tuple[float, float]:
        if body == GROUND:
            return 0.0, 0.0
        i = 3 * self._made.mechanism.body_index[body] + 2
        return places[i], rates[i]

    def _place(self, body: str, point: Point, places: State, rates: State) -> _Place:
        px, py = self._made.local(body, point)
        if body == GROUND:
            return _Place(px, py, 0.0, 0.0, px, py)
        i = 3 * self._made.mechanism.body_index[body]
        cosine, sine, spin = math.cos(places[i + 2]), math.sin(places[i + 2]), rates[i + 2]
        rx, ry = cosine * px - sine * py, sine * px + cosine * py
        return _Place(places[i] + rx, places[i + 1] + ry, rates[i] - spin * ry, rates[i + 1] + spin * rx, rx, ry)


def _push(place: _Place, ux: float, uy: float) -> tuple[float, float, float]:
    return ux, uy, place.rx * uy - place.ry * ux


def _state(bodies: tuple[pymunk.Body, ...]) -> tuple[State, State]:
    places: State = []
    rates: State = []
    for body in bodies:
        places += (*body.position, body.angle)
        rates += (*body.velocity, body.angular_velocity)
    return places, rates
