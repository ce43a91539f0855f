"""Exact motion of a mechanism in many digits, from its joints alone: shares no line with the solver that it judges.

Positions are complex numbers, the Jacobian is one of differences, derivatives are those of the polynomial through
neighbouring poses. The branch is followed from the start poses in small straight steps.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from conrod.exact.motion import Array
from conrod.mechanism.cam import CamProfile
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Prismatic, Rack, Revolute, Rolling

DIGITS = 40
WALK_STEP = 0.02  # [rad]
SPACING, BESIDE = "1e-4", 4  # [rad] between neighbouring poses, and how many there are on each side


@dataclass(frozen=True)
class Numbers:
    """What the equations need of a kind of numbers."""

    complex: Callable[..., Any]
    exp: Callable[[Any], Any]
    phase: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]
    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    atan: Callable[[Any], Any]


FLOATS = Numbers(complex, cmath.exp, cmath.phase, math.sqrt, math.sin, math.cos, math.atan)
MANY = Numbers(mpmath.mpc, mpmath.exp, mpmath.arg, mpmath.sqrt, mpmath.sin, mpmath.cos, mpmath.atan)


class ManyDigits:
    """Equations of one mechanism in floats and in many digits."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.index = {body.name: i for i, body in enumerate(mechanism.bodies)}
        driver = next(joint for joint in mechanism.joints if joint.name == mechanism.driver.joint)
        self.crank = self.index[driver.b]

    # -- equations ---------------------------------------------------------------------------------------------

    def residual(self, q: list[Any], angle: Any, n: Numbers, parts: dict[str, int] | None = None) -> list[Any]:
        """What poses x, y, phi of all bodies leave of all equations."""
        places = {name: (n.complex(q[3 * i], q[3 * i + 1]), q[3 * i + 2]) for name, i in self.index.items()}
        places[GROUND] = (n.complex(0, 0), q[0] * 0)
        left = []
        for joint in self.mechanism.joints:
            a, b = places[joint.a], places[joint.b]
            part = self.part(joint, q) if parts is None and isinstance(joint, CamContact) else None
            left += _left(joint, a, b, n, part if parts is None else parts.get(joint.name))
        driver = self.mechanism.driver
        return [*left, q[3 * self.crank + 2] - driver.start - driver.sense * angle]

    def part(self, joint: CamContact, q: list[Any]) -> int:
        """Which arc of a cam, or segment of its law, the roller touches; told in floats."""
        (za, fa), (zb, fb) = (self._place(name, q) for name in (joint.a, joint.b))
        w = (zb + cmath.exp(1j * fb) * complex(*joint.roller_centre) - za) * cmath.exp(-1j * fa)
        profile = joint.profile
        if isinstance(profile, CamProfile):
            inside = []
            for i, arc in enumerate(profile.arcs):
                way = w - complex(*arc.centre)
                turned = math.remainder(cmath.phase(way) - 0.5 * (arc.start + arc.stop), 2.0 * math.pi)
                if abs(turned) <= 0.5 * (arc.stop - arc.start) + 1e-9:
                    inside.append((abs(way) - arc.radius, i))
            return max(inside)[1]
        angle, passed = _law_angle(profile, w, FLOATS) % (2.0 * math.pi), 0.0
        for i, segment in enumerate(profile.segments):
            passed += segment.over
            if angle < passed:
                return i
        return len(profile.segments) - 1

    def _place(self, name: str, q: list[Any]) -> tuple[complex, float]:
        if name == GROUND:
            return 0j, 0.0
        x, y, turn = (float(value) for value in q[3 * self.index[name] : 3 * self.index[name] + 3])
        return complex(x, y), turn

    def jacobian(self, q: list[float], angle: float, n: Numbers, by: Any) -> Array:
        """Of differences; of all equations by all poses."""
        parts = {c.name: self.part(c, q) for c in self.mechanism.cam_contacts}
        here = self.residual(q, angle, n, parts)
        columns = []
        for k in range(len(q)):
            moved = [*q[:k], q[k] + by, *q[k + 1 :]]
            left = self.residual(moved, angle, n, parts)
            columns.append([float((m - h) / by) for m, h in zip(left, here, strict=True)])
        return np.array(columns).T

    # -- motion ------------------------------------------------------------------------------------------------

    def walk(self, goals: list[float]) -> dict[float, list[float]]:
        """Poses in floats at angles, on the branch of the start poses."""
        start = [value for body in self.mechanism.bodies for value in self.mechanism.poses[body.name]]
        found = {}
        for sign in (1.0, -1.0):
            before = here = self._newton(start, 0.0)
            angle = reached = 0.0
            for goal in sorted((g for g in goals if sign * g >= 0.0), key=abs):
                while angle != goal:
                    last, reached = reached, angle
                    angle = goal if abs(goal - angle) <= WALK_STEP else angle + math.copysign(WALK_STEP, goal)
                    ahead = 0.0 if reached == last else (angle - reached) / (reached - last)
                    guess = [p + ahead * (p - o) for p, o in zip(here, before, strict=True)]
                    before, here = here, self._newton(guess, angle)
                found[goal] = here
        return found

    def _newton(self, q: list[float], angle: float) -> list[float]:
        for _ in range(30):
            step = np.linalg.solve(self.jacobian(q, angle, FLOATS, 1e-7), self.residual(q, angle, FLOATS))
            q = [float(value - by) for value, by in zip(q, step, strict=True)]
            if np.abs(step).max() < 1e-9:
                return q
        raise ArithmeticError(f"{self.mechanism.name} at {angle}")

    def derivatives(self, near: list[float], angle: float) -> tuple[list[Array], dict[str, list[Array]]]:
        """Poses (3 n,) with three derivatives by the angle, and observed points (2,) with theirs, near a pose."""
        with mpmath.workdps(DIGITS):
            by, middle = mpmath.mpf(SPACING), mpmath.mpf(angle)
            parts = {c.name: self.part(c, near) for c in self.mechanism.cam_contacts}
            first = [mpmath.mpf(value) for value in near]
            jacobian = self.jacobian(first, middle, MANY, mpmath.mpf(10) ** (-DIGITS // 2))
            inverse: Array = np.linalg.inv(jacobian).astype(float)
            rows = [self._exact(first, middle + k * by, inverse, parts) for k in range(-BESIDE, BESIDE + 1)]
            poses = [_differences(column, by) for column in zip(*rows, strict=True)]
            points = {}
            for observed in self.mechanism.observed:
                i = 3 * self.index[observed.body]
                arm = mpmath.mpc(*observed.point)
                track = [mpmath.mpc(q[i], q[i + 1]) + mpmath.expj(q[i + 2]) * arm for q in rows]
                planar = [_differences([p.real for p in track], by), _differences([p.imag for p in track], by)]
                points[observed.name] = [np.array(values) for values in zip(*planar, strict=True)]
            return [np.array(values) for values in zip(*poses, strict=True)], points

    def _exact(self, q: list[Any], angle: Any, inverse: Array, parts: dict[str, int]) -> list[Any]:
        """Poses in many digits; each step with a neighbour's Jacobian gains four."""
        for _ in range(40):
            left = self.residual(q, angle, MANY, parts)
            # Residuals in floats have digits enough for a correction, however small they are.
            largest = max(abs(value) for value in left)
            if largest < mpmath.mpf(10) ** (4 - DIGITS):
                return q
            step = inverse @ np.array([float(value / largest) for value in left])
            q = [value - largest * mpmath.mpf(float(by)) for value, by in zip(q, step, strict=True)]
        raise ArithmeticError(f"{self.mechanism.name} at {angle}")


def _left(joint: Joint, a: tuple[Any, Any], b: tuple[Any, Any], n: Numbers, part: int | None) -> list[Any]:
    (za, fa), (zb, fb) = a, b
    ea, eb = n.exp(1j * fa), n.exp(1j * fb)
    match joint:
        case Revolute():
            gap = zb + eb * n.complex(*joint.point_b) - za - ea * n.complex(*joint.point_a)
            return [gap.real, gap.imag]
        case Prismatic():
            gap = zb + eb * n.complex(*joint.point_b) - za - ea * n.complex(*joint.point_a)
            return [(gap / (ea * n.exp(1j * joint.direction))).imag, fb - fa - joint.angle]
        case Rolling():
            way = zb + eb * n.complex(*joint.point_b) - za - ea * n.complex(*joint.point_a)
            line, both = n.phase(way), joint.radius_a + joint.radius_b
            rolled = joint.radius_a * fa + joint.radius_b * fb - both * line - joint.offset
            turn = 2 * n.phase(n.complex(-1, 0)) * both
            return [rolled - turn * round(float(rolled / turn))]
        case Rack():
            way = za + ea * n.complex(*joint.point_a) - zb - eb * n.complex(*joint.point_b)
            return [(way / (eb * n.exp(1j * joint.direction))).real + joint.radius * (fa - fb) - joint.offset]
        case CamContact():
            w = (zb + eb * n.complex(*joint.roller_centre) - za) / ea
            assert part is not None
            if isinstance(joint.profile, CamProfile):
                arc = joint.profile.arcs[part]
                return [abs(w - n.complex(*arc.centre)) - arc.radius - joint.roller_radius]
            return [_above_law(joint.profile, w, n, part)]
    raise TypeError(joint)


def _law_angle(profile: Any, w: Any, n: Numbers) -> Any:
    along = n.sqrt(abs(w) ** 2 - profile.offset**2)
    return profile.sense * (profile.begin - n.phase(w) + n.atan(profile.offset / along))


def _above_law(profile: Any, w: Any, n: Numbers, part: int) -> Any:
    """How far along its line the roller's centre is above where its law wants it."""
    pi = n.phase(n.complex(-1, 0))
    before, segment = profile.segments[:part], profile.segments[part]
    x = (_law_angle(profile, w, n) - sum(s.over for s in before)) / segment.over
    turn = 2 * pi / segment.over
    x = x - turn * round(float((x - 0.5) / turn))
    rise = {
        "dwell": lambda: x * 0,
        "simple-harmonic": lambda: (1 - n.cos(pi * x)) / 2,
        "cycloidal": lambda: x - n.sin(2 * pi * x) / (2 * pi),
        "3-4-5": lambda: x**3 * (10 - 15 * x + 6 * x**2),
        "4-5-6-7": lambda: x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3),
    }[segment.law]()
    lift = sum(s.lift for s in before) + segment.lift * rise
    least = n.sqrt((profile.base_radius + profile.roller_radius) ** 2 - profile.offset**2)
    return n.sqrt(abs(w) ** 2 - profile.offset**2) - least - lift


def _differences(values: Any, by: Any) -> list[float]:
    """Value and three derivatives in the middle of the polynomial through values at equal distances."""
    return [
        float(sum(w * v for w, v in zip(weights, values, strict=True)) / by**order)
        for order, weights in enumerate(STENCILS)
    ]


def _stencils() -> list[list[Any]]:
    """Weights of nine neighbours for the value and the first three derivatives, from their Vandermonde matrix."""
    with mpmath.workdps(DIGITS):
        away = range(-BESIDE, BESIDE + 1)
        powers = mpmath.matrix([[mpmath.mpf(k) ** p for k in away] for p in range(len(away))])
        rights = [[math.factorial(k) if p == k else 0 for p in range(len(away))] for k in range(4)]
        return [list(mpmath.lu_solve(powers, mpmath.matrix(right))) for right in rights]


STENCILS = _stencils()
