"""The exact flight of a cam's follower: thrown off at constant speed, pulled back by a constant force.

Without gravity and friction the follower parts from the cam where the acceleration that the cam gives falls below
-F/m, and then moves on a parabola until it meets the cam again. In primes by the crank angle and g = F / (m omega^2):

    y(p) = y0 + y0' p - g p^2 / 2,    p = angle - separation.

It depends on the speed by g alone. At s times the float speed, where F/m is the follower's largest downward
acceleration A omega^2, g is A / s^2.

**Short flights.** Where the flank ends and the nose begins, y'' jumps from above zero to -A, and rises from there:
y'' = -A (1 - k p + ..), k = y''' / A just after the joint. The height above the cam is then

    d(p) = A (e p^2 / 2 - k p^3 / 6),    e = 1 - 1/s^2,

which is zero again at p = 3 e / k and largest, 2/3 A e^3 / k^2, at p = 2 e / k; the gap along the common normal is that
times the cosine of the pressure angle. So nothing jumps at the onset although the acceleration does: the flight begins
at the joint itself and grows from nothing, its length with the excess of speed, its gap with the third power of that.

**What a rebound makes of it.** An engine's follower leaves the joint with a small speed u (per radian) of its own. Then
d = u p + A (e p^2 / 2 - k p^3 / 6), and it flies below the onset too: for 2 u / (A |e|) well below it, for
sqrt(6 u / (A k)) at it. Where u shrinks as h does, such flights shrink as h below the onset, as the square root of h at
it, and not at all above: their order in h passes through one half at the onset. Where u shrinks faster, as its square,
the order passes through one half a little above, the nearer the finer h is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.optimize import bisect, minimize_scalar

from conrod.exact.motion import Array
from conrod.mechanism.cam import CamProfile, symmetric_cam
from conrod.scenes.cam_follower import CamFollower

TURN = 2.0 * math.pi
SAMPLES = 7200  # of a turn, among which separation is looked for, the joints of the arcs beside
# Landing is looked for in steps that grow with the flight, up to a milliradian: a landing that the follower leaves
# again within one of them is not seen.
STEPS = np.geomspace(1e-6, 1e-3, 350)  # [rad]
# The least height above the cam that counts, over the base circle's radius: rounding leaves a ten-thousandth of it.
LEAST_HEIGHT = 1e-12
# Among so many evenly spaced angles of a flight, and of each of its turns, the widest gap is looked for: more would not
# differ from their neighbours in the least flight.
WIDTHS, WIDTHS_PER_TURN = 65, 720
FINEST = {"xtol": 1e-15, "rtol": 4.0 * np.finfo(float).eps}


@dataclass(frozen=True)
class ExactFlight:
    """A flight, from the separation to the first landing.

    Attributes:
        start, landing: crank angles [rad].
        gap: the largest, between roller and cam along their common normal [m].
    """

    start: float
    landing: float
    gap: float


def float_speed(scene: CamFollower) -> float:
    """Crank speed [rad/s] at which the force is just mass x the largest downward acceleration."""
    return abs(scene.speed) * math.sqrt(scene.preload)


@lru_cache(maxsize=1024)  # every engine and preset is compared at the same speeds
def exact_flight(scene: CamFollower) -> ExactFlight | None:
    """The first flight of a turn that begins in the middle of the dwell; None where the follower is held throughout.

    (Held means within `LEAST_HEIGHT`: the default cam is, up to 1.00002 times the float speed.)

    Angles to 1e-12 rad or what double precision leaves of that: height over the cam is known to 1e-17 m, so that a
    flight of a gap G is off by 1e-17 / G of its length.
    """
    start = separation(scene)
    if start is None:
        return None
    fall = Fall(scene, start)
    landing = fall.landing()
    if landing is None:
        return None
    angles = np.linspace(start, landing, max(WIDTHS, round(WIDTHS_PER_TURN * (landing - start) / TURN)))
    top = int(np.argmax(fall.gap(angles)[1:-1])) + 1
    around = angles[top - 1], angles[top + 1]
    finely = {"bounds": around, "method": "bounded", "options": {"xatol": 1e-9}}
    widest = minimize_scalar(lambda angle: -fall.gap(np.array([angle]))[0], **finely)
    return ExactFlight(start, landing, -float(widest.fun))


def separation(scene: CamFollower) -> float | None:
    """First crank angle [rad] after which the cam no longer presses; None where there is none.

    At a joint of the arcs, where the acceleration jumps, it is the joint itself.
    """
    joints = np.array(scene.break_angles())
    angles = np.sort(np.concatenate([np.linspace(0.0, TURN, SAMPLES, endpoint=False), joints]))
    excess = _excess(scene, angles)
    if excess.min() >= 0.0:
        return None
    k = int(np.argmax(excess < 0.0))
    if k == 0 or angles[k] in joints:
        return float(angles[k])
    return float(bisect(lambda angle: _excess(scene, np.array([angle]))[0], angles[k - 1], angles[k], **FINEST))


@dataclass(frozen=True)
class Fall:
    """A follower let go at a crank angle: its parabola beside the cam that turns on beneath it.

    The angle is the one that the crank has turned through; the cam is symmetric, so either sense gives the same.
    """

    scene: CamFollower
    start: float  # [rad]

    @cached_property
    def _state(self) -> tuple[float, float]:
        height, slope, _ = _height(self.scene, np.array([self.start]))
        return float(height[0]), float(slope[0])

    @cached_property
    def _profile(self) -> CamProfile:
        scene = self.scene
        return symmetric_cam(scene.base_radius, scene.flank, scene.nose_radius, scene.centre_distance)

    def height(self, angle: Array) -> Array:
        """Of the roller's centre in flight [m]; (T,) at crank angles (T,)."""
        y, slope = self._state
        turned = angle - self.start
        return np.asarray(y + slope * turned - 0.5 * fall_per_radian(self.scene) * turned**2)

    def above(self, angle: Array) -> Array:
        """Height over where the cam would carry it [m]; (T,)."""
        return np.asarray(self.height(angle) - _height(self.scene, angle)[0])

    def gap(self, angle: Array) -> Array:
        """Distance between roller and cam along their common normal [m], negative where they overlap; (T,)."""
        return np.asarray(self._profile.distance(*self._in_cam(angle)) - self.scene.roller_radius)

    def _in_cam(self, angle: Array) -> tuple[Array, Array]:
        # The nose, on the cam's +x, is up at half a turn.
        height = self.height(angle)
        return -height * np.cos(angle), height * np.sin(angle)

    def landing(self) -> float | None:
        """First crank angle [rad] at which it is on the cam again; None where it never rises by `LEAST_HEIGHT`."""
        y, slope = self._state
        fall, drop = fall_per_radian(self.scene), y - self.scene.base_radius - self.scene.roller_radius
        longest = (slope + math.sqrt(slope**2 + 2.0 * fall * drop)) / fall  # until it is as low as the dwell
        steps = np.concatenate([STEPS, np.full(int(longest / STEPS[-1]) + 1, STEPS[-1])])
        angles = self.start + np.cumsum(steps)
        above, noise = self.above(angles), LEAST_HEIGHT * self.scene.base_radius
        left = int(np.argmax(above > noise))
        if above[left] <= noise or np.any(above[:left] < -noise):
            return None
        back = left + int(np.argmax(above[left:] <= 0.0))
        return float(bisect(lambda angle: self.above(np.array([angle]))[0], angles[back - 1], angles[back], **FINEST))


def fall_per_radian(scene: CamFollower) -> float:
    """g = F / (m omega^2) [m]: what the force alone does to y''."""
    return scene.preload_force / (scene.follower_mass * scene.speed**2)


def _excess(scene: CamFollower, angle: Array) -> Array:
    """Contact force over mass x speed^2 [m], of the side after a jump."""
    return np.asarray(_height(scene, angle)[2] + fall_per_radian(scene))


def _height(scene: CamFollower, angle: Array) -> tuple[Array, Array, Array]:
    """Height of the roller's centre on the cam, y, y' and y'' [m]."""
    motion = scene.motion(angle, 1.0).point("roller")
    return motion.position[:, 1], motion.velocity[:, 1], motion.acceleration[:, 1]
