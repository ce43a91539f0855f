"""A pymunk `Space` made of a mechanism, with its bodies and joints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib.metadata import version

import pymunk

from conrod.engines.centres import centre_state
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Point

VERSION = version("pymunk")  # what 7.0.0 says of itself is 2.0.0
Pushed = tuple[tuple[pymunk.Body, tuple[float, float]], ...]  # bodies with the constant force [N] on each


@dataclass(frozen=True)
class Build:
    """A space and its bodies, in the order of the mechanism's."""

    mechanism: Mechanism  # as the engine has it, see `shaft_centred`
    space: pymunk.Space
    bodies: tuple[pymunk.Body, ...]
    # Constant forces have to be given again before every step, which clears them.
    pushed: Pushed
    names: dict[pymunk.Constraint, str]  # the joint that each constraint is of

    @property
    def crank(self) -> pymunk.Body:
        """The driven body."""
        return self.bodies[self.mechanism.body_index[self.mechanism.crank]]

    def place(self, poses: Array, rates: Array) -> None:
        """Put the bodies into poses (3 n,) with rates (3 n,) of all links."""
        for i, (link, body) in enumerate(zip(self.mechanism.bodies, self.bodies, strict=True)):
            own = slice(3 * i, 3 * i + 3)
            gx, gy, turn, vx, vy, spin = centre_state(link, poses[own], rates[own])
            body.position, body.angle = (gx, gy), turn
            body.velocity, body.angular_velocity = (vx, vy), spin
        self.space.reindex_shapes_for_body(self.space.static_body)

    def hold(self, name: str, constraint: pymunk.Constraint) -> None:
        """Add a constraint, of a joint of this name."""
        self.names[constraint] = name
        self.space.add(constraint)

    def link(self, name: str) -> pymunk.Body:
        """The body of a link, or the ground."""
        return self.space.static_body if name == GROUND else self.bodies[self.mechanism.body_index[name]]

    def local(self, name: str, point: Point) -> Point:
        """A point of a link in pymunk's body frame, whose origin is the centre of gravity."""
        if name == GROUND:
            return point
        cx, cy = self.mechanism.body(name).centre_of_gravity
        return (point[0] - cx, point[1] - cy)


def shaft_centred(mechanism: Mechanism) -> Mechanism:
    """The mechanism with the crank's centre of gravity on its shaft.

    A kinematic body turns about its centre of gravity, and its mass acts on nothing: so where its real one lies does
    not matter, but the place about which it turns does.
    """
    shaft = mechanism.driven_joint.point_b
    bodies = tuple(
        replace(body, centre_of_gravity=shaft) if body.name == mechanism.crank else body for body in mechanism.bodies
    )
    return replace(mechanism, bodies=bodies)
