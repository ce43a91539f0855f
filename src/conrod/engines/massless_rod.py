"""The two forms in which an engine can be given a link that carries nothing but two pins.

As a body it has its mass and two pin joints. As a distance joint it is left out: its pins are held apart by its length,
and its own motion, which the engine then does not know, is reported from theirs at the same instants. Its mass is left
out with it.

Near a limit of the linkage neither form always holds longer: pymunk's saw in line, with crank and rod of 0.299 m and
0.3 m, runs with the rod as a body and opens as a distance joint; with an offset of 0.1999 m it is the other way round
(tuned, 2000 steps a revolution).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.jet import Jet, reciprocal, square_root
from conrod.exact.joint_equations import PoseJet, pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import Distance
from conrod.mechanism.mechanism import GROUND, Mechanism, Point, Revolute

BODY, DISTANCE_JOINT = "body", "distance-joint"
ROD_FORMS = (BODY, DISTANCE_JOINT)


@dataclass(frozen=True)
class DistanceJoint(Distance):
    """A link that is left out, and what stands in for it: the distance of two points, which does not change."""

    link: str
    pin_a: Point  # of the link, where `a` is pinned to it
    pin_b: Point
    start_turn: float  # [rad], of the link at crank angle 0, about

    @property
    def length(self) -> float:
        """Distance of the link's pins [m]."""
        return math.dist(self.pin_a, self.pin_b)


@dataclass(frozen=True)
class ModelForm:
    """A mechanism as an engine is given it.

    Attributes:
        whole: with all its links.
        mechanism: without those that are left out, and without what is observed on them.
        distances: what stands in for them.
    """

    whole: Mechanism
    mechanism: Mechanism
    distances: tuple[DistanceJoint, ...] = ()

    def kept(self, stacked: Array) -> Array:
        """Of a stacked state of all links (..., 3 n), the part that the engine has."""
        if not self.distances:
            return stacked
        return np.concatenate([stacked[..., self._columns(body.name)] for body in self.mechanism.bodies], axis=-1)

    def completed(self, derivatives: Sequence[Array], after: Array | None = None) -> list[Array]:
        """Poses of all links (T, 3 n), their rates and accelerations, as many as are given of the engine's (T, 3 m).

        Instants follow each other closely enough that no left-out link turns by half a turn between two.

        Args:
            after: poses (3 n,) of all links that these follow in a run reported in pieces; None at its beginning.
        """
        if not self.distances:
            return list(derivatives)
        whole = [np.empty((len(d), 3 * len(self.whole.bodies))) for d in derivatives]
        for i, body in enumerate(self.mechanism.bodies):
            for full, part in zip(whole, derivatives, strict=True):
                full[:, self._columns(body.name)] = part[:, 3 * i : 3 * i + 3]
        # A state that is not finite any more stays so; how the run ended is judged elsewhere.
        with np.errstate(all="ignore"):
            bodies = pose_jets(self.mechanism, [d / math.factorial(k) for k, d in enumerate(derivatives)])
            for joint in self.distances:
                near = joint.start_turn if after is None else float(after[self._columns(joint.link)][2])
                pose = _between_pins(joint, bodies, near)
                for k, values in enumerate(zip(*(c.coefficients for c in pose), strict=True)):
                    whole[k][:, self._columns(joint.link)] = math.factorial(k) * np.column_stack(values)
        return whole

    def _columns(self, body: str) -> slice:
        i = 3 * self.whole.body_index[body]
        return slice(i, i + 3)


def _between_pins(joint: DistanceJoint, bodies: dict[str, PoseJet], near: float) -> tuple[Jet, Jet, Jet]:
    """Pose of the left-out link: along the line of its pins, its middle in theirs; its first turn near the given."""
    (ax, ay), (bx, by) = bodies[joint.a].point(joint.point_a), bodies[joint.b].point(joint.point_b)
    dx, dy = bx - ax, by - ay
    inverse = reciprocal(square_root(dx * dx + dy * dy))
    along_x, along_y = dx * inverse, dy * inverse
    own_x, own_y = ((q - p) / joint.length for p, q in zip(joint.pin_a, joint.pin_b, strict=True))
    cosine, sine = along_x * own_x + along_y * own_y, along_y * own_x - along_x * own_y
    middle_x, middle_y = (0.5 * (p + q) for p, q in zip(joint.pin_a, joint.pin_b, strict=True))
    x = 0.5 * (ax + bx) - cosine * middle_x + sine * middle_y
    y = 0.5 * (ay + by) - sine * middle_x - cosine * middle_y
    return x, y, _angle(cosine, sine, near)


def _angle(cosine: Jet, sine: Jet, near: float) -> Jet:
    """The angle of a direction, continuous, by phi' = c s' - s c'; its first value within half a turn of `near`."""
    c, s = cosine.coefficients, sine.coefficients
    turn = np.arctan2(s[0], c[0])
    # Whole turns are counted, so that the same comes of it wherever a run is cut.
    back = np.rint(np.diff(turn, prepend=near) / (2.0 * np.pi))
    angle = [turn - 2.0 * np.pi * np.cumsum(back)]
    for k in range(1, len(c)):
        angle.append(sum((j * (c[k - j] * s[j] - s[k - j] * c[j]) for j in range(1, k + 1)), start=0.0 * c[0]) / k)
    return Jet(angle)


def model_form(mechanism: Mechanism, rod: str) -> ModelForm:
    """The mechanism with its binary links in a form of `ROD_FORMS`.

    Raises:
        InvalidInput: there is no link to leave out.
    """
    if rod == BODY:
        return ModelForm(mechanism, mechanism)
    reason = form_refusal(mechanism, rod)
    if reason:
        raise InvalidInput(f"{mechanism.name}: {reason}")
    distances = _left_out(mechanism)
    gone = {joint.link for joint in distances}
    left = replace(
        mechanism,
        bodies=tuple(body for body in mechanism.bodies if body.name not in gone),
        joints=tuple(joint for joint in mechanism.joints if joint.a not in gone and joint.b not in gone),
        poses={name: pose for name, pose in mechanism.poses.items() if name not in gone},
        observed=tuple(point for point in mechanism.observed if point.body not in gone),
    )
    return ModelForm(mechanism, left, distances)


def form_refusal(mechanism: Mechanism, rod: str) -> str | None:
    """None, or the reason why a mechanism cannot be given in this form."""
    if rod == BODY or _left_out(mechanism):
        return None
    return "no link carries nothing but two pins to other moving links, so none can be a distance joint"


def _left_out(mechanism: Mechanism) -> tuple[DistanceJoint, ...]:
    """Links that can be left out; of two that are pinned to each other the first alone."""
    found: list[DistanceJoint] = []
    partners: set[str] = set()
    for body in mechanism.bodies:
        joint = _as_distance(mechanism, body.name)
        if joint is not None and body.name not in partners:
            found.append(joint)
            partners |= {joint.a, joint.b}
    return tuple(found)


def _as_distance(mechanism: Mechanism, link: str) -> DistanceJoint | None:
    """The distance joint that can stand in for a link; None if it carries more or less than two pins, or a force."""
    joints = [joint for joint in mechanism.joints if link in (joint.a, joint.b)]
    loaded = set(mechanism.pushes).union(*(load.ends for load in mechanism.loads))
    if len(joints) != 2 or link == mechanism.crank or link in loaded:
        return None
    ends = [_ends(joint, link) for joint in joints if isinstance(joint, Revolute)]
    if len(ends) != 2 or GROUND in (ends[0][0], ends[1][0]):
        return None
    if any({mesh.a, mesh.b} <= {ends[0][0], ends[1][0]} for mesh in mechanism.meshes):
        return None  # a rolling pair's turns count against it
    (a, point_a, pin_a), (b, point_b, pin_b) = ends
    return DistanceJoint(a, b, point_a, point_b, link, pin_a, pin_b, mechanism.poses[link][2])


def _ends(joint: Revolute, link: str) -> tuple[str, Point, Point]:
    """The link at the other side of a pin, the pin's place on it, and on the link itself."""
    if joint.b == link:
        return joint.a, joint.point_a, joint.point_b
    return joint.b, joint.point_b, joint.point_a
