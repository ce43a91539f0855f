"""The exact motion of a mechanism without a closed form, with the interface of a scene: a ruler and a machine."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from conrod.joint_equations import active_arcs, pose_jets
from conrod.kinematics import Kinematics
from conrod.mechanism import Mechanism
from conrod.motion import Array, Break, Motion, Side, breaks_between

SAMPLES, HALVINGS = 720, 60


@dataclass(frozen=True)
class GenericReference:
    """A mechanism driven at constant speed, solved by Newton iteration on its joint equations.

    It can be run in an engine like a scene, and a trajectory can be compared with it like with a scene.

    Attributes:
        described: the mechanism.
        speed: crank speed [rad/s]; the crank angle is speed x time.
    """

    described: Mechanism
    speed: float

    @cached_property
    def kinematics(self) -> Kinematics:
        """The solver."""
        return Kinematics(self.described)

    @property
    def lengths(self) -> dict[str, float]:
        """L [m] of each observed point."""
        return self.kinematics.lengths

    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.described

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """Exact motion of the observed points; as `Scene.motion`."""
        theta = np.atleast_1d(np.asarray(angle, dtype=float))
        rate, turn = np.asarray(speed, dtype=float), np.asarray(acceleration, dtype=float)
        return self.kinematics.motion(theta, rate, turn, side)

    def reference(self, times: ArrayLike, side: Side = "right") -> Motion:
        """Exact motion at times (T,) [s] at constant speed; `side` is seen along increasing time."""
        backward: Side = "left" if side == "right" else "right"
        seen = side if self.speed > 0 else backward
        return self.motion(self.speed * np.atleast_1d(np.asarray(times, dtype=float)), self.speed, 0.0, seen)

    def break_angles(self) -> tuple[float, ...]:
        """Angles [rad] in [0, 2 pi) where a roller passes from one arc of its cam to the next, by bisection."""
        found: list[float] = []
        angles = np.linspace(*self.kinematics.span, SAMPLES + 1)
        for k in range(len(self.described.cam_contacts)):
            arcs = self._arcs(angles, k)
            for left in np.flatnonzero(arcs[:-1] != arcs[1:]):
                found.append(self._bisect(float(angles[left]), float(angles[left + 1]), k))
        return tuple(sorted(found))

    def breaks(self) -> tuple[Break, ...]:
        """Where acceleration or jerk jump at constant speed, with the values on both sides."""
        angles = np.array(self.break_angles())
        if not len(angles):
            return ()
        return breaks_between(self.motion(angles, self.speed, side="left"), self.motion(angles, self.speed))

    def _arcs(self, angles: Array, contact: int) -> Array:
        bodies = pose_jets(self.described, [self.kinematics.poses(angles)])
        return active_arcs(self.described.cam_contacts[contact], bodies).astype(float)

    def _bisect(self, low: float, high: float, contact: int) -> float:
        before = self._arcs(np.array([low]), contact)[0]
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if self._arcs(np.array([middle]), contact)[0] == before:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)
