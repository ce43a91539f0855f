"""Constraint equations of all joint kinds, as jets in time or in crank angle, with their Jacobian.

One expression for each joint kind gives the constraint violation with its first and second derivative.

A roller on a cam that is made from a motion law: let H be the position along the follower's line that corresponds to
the roller's distance from the shaft, and u the law's angle that corresponds to its direction. The roller's centre is on
the pitch curve if H = H0 + s(u). The difference is a length along the follower's line; times the cosine of the pressure
angle it is the distance along the common normal. That distance is exact where it is 0, with a gradient of unit length,
and elsewhere off by its square over the radius of curvature.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from conrod.exact.jet import Jet, direction, reciprocal, sine_cosine, square_root
from conrod.exact.motion import Array
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Point, Prismatic, Rack, Revolute, Rolling
from conrod.mechanism.units import REVOLUTION


@dataclass(frozen=True)
class PoseJet:
    """Pose of one body as jets, with the sine and cosine of its rotation phi."""

    x: Jet
    y: Jet
    phi: Jet
    sine: Jet
    cosine: Jet

    def point(self, local: Point) -> tuple[Jet, Jet]:
        """Position (x, y) [m] of a point of the body in the document's frame, as jets."""
        px, py = local
        if py == 0.0:  # so are most pins: on the line from the origin of their body
            return (self.x + self.cosine * px, self.y + self.sine * px) if px != 0.0 else (self.x, self.y)
        return self.x + self.cosine * px - self.sine * py, self.y + self.sine * px + self.cosine * py


def pose_jets(mechanism: Mechanism, coefficients: Sequence[Array]) -> dict[str, PoseJet]:
    """Pose jets of all bodies, the ground included.

    Args:
        coefficients: Taylor coefficients of the stacked poses, each (T, 3 n) [m, m, rad].
    """
    poses = {name: pose_jet(mechanism, coefficients, name) for name in mechanism.body_index}
    zero = Jet([0.0] * len(coefficients))
    poses[GROUND] = PoseJet(zero, zero, zero, zero, zero + 1.0)
    return poses


def pose_jet(mechanism: Mechanism, coefficients: Sequence[Array], name: str) -> PoseJet:
    """Pose jet of one moving body; arguments as for `pose_jets`."""
    i = mechanism.body_index[name]
    x, y, phi = (Jet([c[:, 3 * i + k] for c in coefficients]) for k in range(3))
    return PoseJet(x, y, phi, *sine_cosine(phi))


def active_arcs(joint: CamContact, poses: dict[str, PoseJet]) -> NDArray[np.intp]:
    """Index (T,) of the cam's arc, or of its law's segment, that the roller touches in each pose."""
    cam = poses[joint.a]
    x, y = _roller_from_cam(joint, poses)
    c, s = cam.cosine.coefficients[0], cam.sine.coefficients[0]
    x0, y0 = x.coefficients[0], y.coefficients[0]
    return joint.profile.active_arc(np.asarray(c * x0 + s * y0), np.asarray(c * y0 - s * x0))


def joint_residual(joint: Joint, poses: dict[str, PoseJet], arcs: NDArray[np.intp] | None = None) -> list[Jet]:
    """Residuals of a joint's equations: lengths [m]; the second one of a slide is an angle [rad].

    Args:
        arcs: for a cam contact the arc (or segment) in contact at each sample, if the poses do not determine it.
    """
    a, b = poses[joint.a], poses[joint.b]
    match joint:
        case Revolute():
            ax, ay = a.point(joint.point_a)
            bx, by = b.point(joint.point_b)
            return [bx - ax, by - ay]
        case Prismatic():
            ax, ay = a.point(joint.point_a)
            bx, by = b.point(joint.point_b)
            nx, ny = -np.sin(joint.direction), np.cos(joint.direction)
            normal_x = a.cosine * nx - a.sine * ny
            normal_y = a.sine * nx + a.cosine * ny
            return [(bx - ax) * normal_x + (by - ay) * normal_y, b.phi - a.phi - joint.angle]
        case CamContact():
            x, y = _roller_from_cam(joint, poses)
            active = active_arcs(joint, poses) if arcs is None else arcs
            if isinstance(joint.profile, LawProfile):
                return [law_cam_distance(joint.profile, x, y, a.phi, active)]
            cx, cy, radius = joint.profile.arc_geometry(active)
            dx = x - (a.cosine * cx - a.sine * cy)
            dy = y - (a.sine * cx + a.cosine * cy)
            return [square_root(dx * dx + dy * dy) - (radius + joint.roller_radius)]
        case Rolling():
            ax, ay = a.point(joint.point_a)
            bx, by = b.point(joint.point_b)
            line = direction(bx - ax, by - ay)
            rolled = (a.phi - line) * joint.radius_a + (b.phi - line) * joint.radius_b - joint.offset
            turn = REVOLUTION * joint.distance  # the line of centres is known up to whole ones
            return [rolled - turn * np.rint(rolled.coefficients[0] / turn)]
        case Rack():
            ax, ay = a.point(joint.point_a)
            bx, by = b.point(joint.point_b)
            ux, uy = np.cos(joint.direction), np.sin(joint.direction)
            displacement = (ax - bx) * (b.cosine * ux - b.sine * uy) + (ay - by) * (b.sine * ux + b.cosine * uy)
            return [displacement + (a.phi - b.phi) * joint.radius - joint.offset]
        case _:
            assert_never(joint)


def _roller_from_cam(joint: CamContact, poses: dict[str, PoseJet]) -> tuple[Jet, Jet]:
    """Position of the roller's centre from the cam's origin [m], in the document's directions."""
    x, y = poses[joint.b].point(joint.roller_centre)
    return x - poses[joint.a].x, y - poses[joint.a].y


def joint_jacobian(joint: Joint, poses: dict[str, PoseJet], arcs: NDArray[np.intp] | None = None) -> list[Rows]:
    """Derivatives of `joint_residual` by the poses of bodies `a` and `b`, one pair of rows an equation."""
    a, b = _BodyFrame(poses[joint.a]), _BodyFrame(poses[joint.b])
    match joint:
        case Revolute():
            (ax, ay), (bx, by) = a.to_document_frame(joint.point_a), b.to_document_frame(joint.point_b)
            return [((-1.0, 0.0, ay), (1.0, 0.0, -by)), ((0.0, -1.0, -ax), (0.0, 1.0, bx))]
        case Prismatic():
            bx, by = b.to_document_frame(joint.point_b)
            nx, ny = a.to_document_frame((-np.sin(joint.direction), np.cos(joint.direction)))
            px, py = b.x + bx - a.x, b.y + by - a.y
            # The line turns about the origin of `a` with its anchor, so the arm reaches to point_b.
            offset = ((-nx, -ny, nx * py - ny * px), (nx, ny, ny * bx - nx * by))
            return [offset, ((0.0, 0.0, -1.0), (0.0, 0.0, 1.0))]
        case CamContact():
            bx, by = b.to_document_frame(joint.roller_centre)
            active = active_arcs(joint, poses) if arcs is None else arcs
            if isinstance(joint.profile, LawProfile):
                ax, ay = b.x + bx - a.x, b.y + by - a.y  # from the cam's axis to the roller
                ux, uy = a.to_document_frame(law_cam_gradient(joint.profile, *a.to_body_frame(ax, ay), active))
            else:
                cx, cy, _ = joint.profile.arc_geometry(active)
                ax, ay = a.to_document_frame((cx, cy))
                dx, dy = b.x + bx - a.x - ax, b.y + by - a.y - ay
                distance = np.hypot(dx, dy)
                ux, uy = dx / distance, dy / distance
            return [((-ux, -uy, ux * ay - uy * ax), (ux, uy, uy * bx - ux * by))]
        case Rolling():
            (ax, ay), (bx, by) = a.to_document_frame(joint.point_a), b.to_document_frame(joint.point_b)
            dx, dy = b.x + bx - a.x - ax, b.y + by - a.y - ay
            # A displacement d of its end rotates the line of centres by u . d; bodies turn against that line.
            over = (joint.radius_a + joint.radius_b) / (dx * dx + dy * dy)
            ux, uy = over * dy, -over * dx
            return [((-ux, -uy, joint.radius_a + ux * ay - uy * ax), (ux, uy, joint.radius_b + uy * bx - ux * by))]
        case Rack():
            (ax, ay), (bx, by) = a.to_document_frame(joint.point_a), b.to_document_frame(joint.point_b)
            ux, uy = b.to_document_frame((np.cos(joint.direction), np.sin(joint.direction)))
            # The line turns about the origin of `b`, so the arm reaches to the wheel's centre.
            px, py = a.x + ax - b.x, a.y + ay - b.y
            return [((ux, uy, uy * ax - ux * ay + joint.radius), (-ux, -uy, ux * py - uy * px - joint.radius))]
        case _:
            assert_never(joint)


Entry = float | Array
Rows = tuple[tuple[Entry, Entry, Entry], tuple[Entry, Entry, Entry]]


class _BodyFrame:
    """Origin and directions of a body at the samples, from the leading coefficients of its pose jet."""

    def __init__(self, pose: PoseJet) -> None:
        self.x, self.y = pose.x.coefficients[0], pose.y.coefficients[0]
        self._cosine, self._sine = pose.cosine.coefficients[0], pose.sine.coefficients[0]

    def to_document_frame(self, local: tuple[Entry, Entry]) -> tuple[Entry, Entry]:
        """Rotate a vector of the body into the document's directions."""
        px, py = local
        if isinstance(px, float) and isinstance(py, float) and px == py == 0.0:
            return 0.0, 0.0
        return self._cosine * px - self._sine * py, self._sine * px + self._cosine * py

    def to_body_frame(self, x: Entry, y: Entry) -> tuple[Array, Array]:
        """Rotate a vector of the document's directions into the body's."""
        return np.asarray(self._cosine * x + self._sine * y), np.asarray(self._cosine * y - self._sine * x)


def law_cam_distance(profile: LawProfile, x: Jet, y: Jet, turn: Jet, segment: NDArray[np.intp]) -> Jet:
    """Distance [m] between roller and profile of a cam with a motion law, positive outside.

    Args:
        x, y: the roller's centre from the cam's origin [m], in the document's directions.
        turn: rotation of the cam [rad].
        segment: segment of the law in contact at each sample.
    """
    e, sense = profile.offset, profile.sense
    height = square_root(x * x + y * y - e * e)
    polar = direction(x, y) - turn
    if e != 0.0:
        polar = polar - direction(height, height * 0.0 + e)
    angle = (profile.begin - polar) * sense
    derivatives = profile.lift(np.asarray(angle.coefficients[0]), len(angle.coefficients), segment)
    on_curve = _compose(derivatives[:-1], angle) + profile.least_height
    across = _compose(derivatives[1:], angle) + sense * e
    cosine = on_curve * reciprocal(square_root(across * across + on_curve * on_curve))
    return (height - on_curve) * cosine


def law_cam_gradient(profile: LawProfile, x: Array, y: Array, segment: NDArray[np.intp]) -> tuple[Array, Array]:
    """Gradient of `law_cam_distance` by the roller's centre (x, y) [m], all in the cam's frame."""
    e, sense = profile.offset, profile.sense
    square = x * x + y * y
    reach, height = np.sqrt(square), np.sqrt(square - e * e)
    lift, first, second = profile.lift(profile.law_angle(x, y), 2, segment)
    on_curve, across = profile.least_height + lift, first + sense * e
    rate = np.hypot(across, on_curve)
    cosine = on_curve / rate
    cosine_first = first / rate - on_curve * (across * second + on_curve * first) / rate**3
    # Derivatives of H and of the law's angle, radially outwards and counter-clockwise around the axis.
    height_out = reach / height
    angle_out, angle_round = -sense * e / (reach * height), -sense / reach
    by_angle = (height - on_curve) * cosine_first - cosine * first
    out, around = cosine * height_out + by_angle * angle_out, by_angle * angle_round
    return (x * out - y * around) / reach, (y * out + x * around) / reach


def _compose(derivatives: list[Array], angle: Jet) -> Jet:
    """Taylor series of f(angle) from the derivatives of f at the angle's value."""
    departure = Jet((0.0, *angle.coefficients[1:]))
    terms = [derivative / math.factorial(k) for k, derivative in enumerate(derivatives)]
    total = Jet([terms[-1], *(0.0 for _ in terms[1:])])
    for term in reversed(terms[:-1]):
        total = total * departure + term
    return total
