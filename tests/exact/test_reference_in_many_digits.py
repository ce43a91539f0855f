"""The exact motion against equations of its own in 50 digits: poses, observed points, and derivatives to jerk.

Those equations, in complex numbers, know nothing of conrod's own. Derivatives come from differences of poses at
neighbouring angles, which lose half of the digits.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from catalogue import CAMS, EVERY_SCENE, slow_but_for_a_few
from mpmath import mpc

from conrod.exact.motion import Array
from conrod.mechanism.cam import CamProfile
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Prismatic, Rack, Revolute, Rolling
from conrod.scenes import SCENES, Scene, catalogue_names, catalogue_scene

PARTS = np.array([0.05, 0.23, 0.41, 0.59, 0.77, 0.95])  # of the turn or the pass
# Of each kind one: a change point, wheels, laws; the rest with `make test-all`.
QUICK = ("parallelogram", "planetary-gear", "cam-simple-harmonic", "cam-4-5-6-7")
AGREED, CLOSED_FORM = 1e-12, 1e-13
MACHINES = {**EVERY_SCENE, **CAMS}
DIGITS = 50
SPACING, BESIDE = "1e-4", 4  # [rad] between neighbouring poses, and how many there are on each side


class ManyDigits:
    """Equations of one mechanism."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.index = {body.name: i for i, body in enumerate(mechanism.bodies)}
        driver = next(joint for joint in mechanism.joints if joint.name == mechanism.driver.joint)
        self.crank = self.index[driver.b]

    def residual(self, q: list[Any], angle: Any, parts: dict[str, int]) -> list[Any]:
        """What poses x, y, phi of all bodies leave of all equations; the parts of cams that rollers are on."""
        places = {name: (mpc(q[3 * i], q[3 * i + 1]), q[3 * i + 2]) for name, i in self.index.items()}
        places[GROUND] = (mpc(0), 0)
        left = []
        for joint in self.mechanism.joints:
            left += _residual(joint, places[joint.a], places[joint.b], parts.get(joint.name))
        driver = self.mechanism.driver
        return [*left, q[3 * self.crank + 2] - driver.start - driver.sense * angle]

    def part(self, joint: CamContact, q: list[Any]) -> int:
        """Which arc of a cam, or segment of its law, the roller touches."""
        za, zb = (mpc(*q[3 * i : 3 * i + 2]) for i in (self.index[joint.a], self.index[joint.b]))
        fa, fb = (q[3 * self.index[name] + 2] for name in (joint.a, joint.b))
        w = (zb + mpmath.expj(fb) * mpc(*joint.roller_centre) - za) * mpmath.expj(-fa)
        profile = joint.profile
        if isinstance(profile, CamProfile):
            inside = []
            for i, arc in enumerate(profile.arcs):
                way = complex(w) - complex(*arc.centre)
                turned = math.remainder(np.angle(way) - 0.5 * (arc.start + arc.stop), 2.0 * math.pi)
                if abs(turned) <= 0.5 * (arc.stop - arc.start) + 1e-9:
                    inside.append((abs(way) - arc.radius, i))
            return max(inside)[1]
        ends = np.cumsum([segment.over for segment in profile.segments])
        return int(np.searchsorted(ends[:-1], float(_law_angle(profile, w)) % (2.0 * math.pi), side="right"))

    def derivatives(self, near: Array, angle: float) -> tuple[list[Array], dict[str, list[Array]]]:
        """Poses (3 n,) with three derivatives by the angle, and observed points (2,) with theirs, near a pose."""
        with mpmath.workdps(DIGITS):
            by, middle, first = mpmath.mpf(SPACING), mpmath.mpf(angle), [mpmath.mpf(float(value)) for value in near]
            parts = {c.name: self.part(c, first) for c in self.mechanism.cam_contacts}
            inverse: Array = np.linalg.inv(self._jacobian(first, middle, parts))
            rows = [self._exact(first, middle + k * by, inverse, parts) for k in range(-BESIDE, BESIDE + 1)]
            poses = [_differences(column, by) for column in zip(*rows, strict=True)]
            points = {}
            for observed in self.mechanism.observed:
                i = 3 * self.index[observed.body]
                arm = mpc(*observed.point)
                track = [mpc(q[i], q[i + 1]) + mpmath.expj(q[i + 2]) * arm for q in rows]
                planar = [_differences([p.real for p in track], by), _differences([p.imag for p in track], by)]
                points[observed.name] = [np.array(values) for values in zip(*planar, strict=True)]
            return [np.array(values) for values in zip(*poses, strict=True)], points

    def _jacobian(self, q: list[Any], angle: Any, parts: dict[str, int]) -> Array:
        here, by = self.residual(q, angle, parts), mpmath.mpf(10) ** (-DIGITS // 2)
        moved = [self.residual([*q[:k], q[k] + by, *q[k + 1 :]], angle, parts) for k in range(len(q))]
        return np.array([[float((m - h) / by) for m, h in zip(one, here, strict=True)] for one in moved]).T

    def _exact(self, q: list[Any], angle: Any, inverse: Array, parts: dict[str, int]) -> list[Any]:
        """Poses in many digits; each step with a neighbour's Jacobian gains four."""
        for _ in range(40):
            left = self.residual(q, angle, parts)
            # Residuals in floats have digits enough for a correction, however small they are.
            largest = max(abs(value) for value in left)
            if largest < mpmath.mpf(10) ** (4 - DIGITS):
                return q
            step = inverse @ np.array([float(value / largest) for value in left])
            q = [value - largest * mpmath.mpf(float(by)) for value, by in zip(q, step, strict=True)]
        raise ArithmeticError(f"{self.mechanism.name} at {angle}")


def _residual(joint: Joint, a: tuple[Any, Any], b: tuple[Any, Any], part: int | None) -> list[Any]:
    (za, fa), (zb, fb) = a, b
    ea, eb = mpmath.expj(fa), mpmath.expj(fb)
    if isinstance(joint, CamContact):
        w = (zb + eb * mpc(*joint.roller_centre) - za) / ea
        assert part is not None
        if isinstance(joint.profile, CamProfile):
            arc = joint.profile.arcs[part]
            return [abs(w - mpc(*arc.centre)) - arc.radius - joint.roller_radius]
        return [_above_law(joint.profile, w, part)]
    gap = zb + eb * mpc(*joint.point_b) - za - ea * mpc(*joint.point_a)
    match joint:
        case Revolute():
            return [gap.real, gap.imag]
        case Prismatic():
            return [(gap / (ea * mpmath.expj(joint.direction))).imag, fb - fa - joint.angle]
        case Rolling():
            both = joint.radius_a + joint.radius_b
            rolled = joint.radius_a * fa + joint.radius_b * fb - both * mpmath.arg(gap) - joint.offset
            return [rolled - 2 * mpmath.pi * both * mpmath.nint(rolled / (2 * mpmath.pi * both))]
        case Rack():
            return [(-gap / (eb * mpmath.expj(joint.direction))).real + joint.radius * (fa - fb) - joint.offset]
    raise TypeError(joint)


def _law_angle(profile: Any, w: Any) -> Any:
    along = mpmath.sqrt(abs(w) ** 2 - profile.offset**2)
    return profile.sense * (profile.begin - mpmath.arg(w) + mpmath.atan(profile.offset / along))


def _above_law(profile: Any, w: Any, part: int) -> Any:
    """How far along its line the roller's centre is above where its law wants it."""
    pi, before, segment = mpmath.pi, profile.segments[:part], profile.segments[part]
    x = (_law_angle(profile, w) - sum(s.over for s in before)) / segment.over
    turn = 2 * pi / segment.over
    x = x - turn * mpmath.nint((x - 0.5) / turn)
    rise = {
        "dwell": lambda: x * 0,
        "simple-harmonic": lambda: (1 - mpmath.cos(pi * x)) / 2,
        "cycloidal": lambda: x - mpmath.sin(2 * pi * x) / (2 * pi),
        "3-4-5": lambda: x**3 * (10 - 15 * x + 6 * x**2),
        "4-5-6-7": lambda: x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3),
    }[segment.law]()
    lift = sum(s.lift for s in before) + segment.lift * rise
    least = mpmath.sqrt((mpmath.mpf(profile.base_radius) + profile.roller_radius) ** 2 - profile.offset**2)
    return mpmath.sqrt(abs(w) ** 2 - profile.offset**2) - least - lift


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


def disagreement(scene: Scene, mechanism: Mechanism, turns: float = 1.0, bend: float = 0.7) -> tuple[float, float]:
    """Of poses and of observed points with three derivatives: largest difference, over the largest value of each.

    Points move at an angular acceleration of `bend` times the square of the speed.
    """
    kinematics, exact = scene.kinematics, ManyDigits(mechanism)
    low, high = kinematics.span
    angles = low + turns * (high - low) * PARTS
    poses, moved = kinematics.derivatives(angles), scene.motion(angles, 1.0, 0.7).points
    scale = np.tile([kinematics.size, kinematics.size, 1.0], len(mechanism.bodies))
    of_poses = of_points = 0.0
    for j, angle in enumerate(angles):
        places, tracks = exact.derivatives(poses[0][j], float(angle))
        of_poses = max(
            of_poses, *(_relative_difference(p[j] / scale, q / scale, 1.0) for p, q in zip(poses, places, strict=True))
        )
        for name, (place, first, second, third) in tracks.items():
            in_time = (place, first, second + bend * first, third + 3.0 * bend * second)
            found = vars(moved[name]).values()
            of_points = max(
                of_points,
                *(_relative_difference(f[j], t, scene.lengths[name]) for f, t in zip(found, in_time, strict=True)),
            )
    return of_poses, of_points


def _relative_difference(found: Array, exact: Array, least: float) -> float:
    return float(np.abs(found - exact).max() / max(least, np.abs(exact).max()))


@pytest.mark.parametrize("name", [*EVERY_SCENE, *slow_but_for_a_few(CAMS)])
def test_closed_forms_have_13_digits_up_to_jerk(name: str) -> None:
    scene = MACHINES[name]
    of_poses, of_points = disagreement(scene, scene.mechanism(), turns=10.0)
    assert of_poses < AGREED
    assert of_points < CLOSED_FORM


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in catalogue_names()]
)
def test_generic_solver_has_12_digits_up_to_jerk(name: str) -> None:
    scene = catalogue_scene(name)
    assert max(disagreement(scene, scene.mechanism())) < AGREED


def test_digit_comparison_detects_length_off_by_1e_10() -> None:
    for scene in (SCENES["saw-40rpm"], catalogue_scene("web-cutter")):
        mechanism = scene.mechanism()
        joint = next(j for j in mechanism.joints if isinstance(j, Revolute) and (j.point_a[0] or j.point_b[0]))
        (x, y), rest = joint.point_a, [j for j in mechanism.joints if j is not joint]
        wrong = replace(mechanism, joints=(*rest, replace(joint, point_a=(x * (1.0 + 1e-10), y))))
        assert min(disagreement(scene, wrong)) > AGREED


def test_digit_comparison_detects_swapped_acceleration_sign() -> None:
    scene = SCENES["saw-40rpm"]
    assert disagreement(scene, scene.mechanism(), bend=-0.7)[1] > 0.1
