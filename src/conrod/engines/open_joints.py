"""A machine whose joints stand open: where its links then are, and how far its observed points are off."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from conrod.engines.capabilities import Softness
from conrod.engines.engine import Machine
from conrod.engines.massless_rod import DistanceJoint, ModelForm
from conrod.engines.numerics import self_consistent
from conrod.exact.jet import Jet
from conrod.exact.joint_equations import PoseJet, pose_jets
from conrod.exact.motion import Array, diameter

TURNS = 2
SAMPLES = 720  # in a turn
NEWTON_STEPS = 4
NEWTON_DONE = 1e-13  # [m, rad]


class OpenJoints:
    """Two turns at constant crank speed, sampled, with gaps in the joints.

    Gaps are stacked like the joint equations, (T, 3 n): what each of them leaves. The driver's, the last, is zero.
    Violations (T, k) are those gaps that an engine leaves open, and what its distance joints are too long by.

    Attributes:
        open_rows: joint equations that the engine leaves open, in the order of the violations.
        angle: crank angles (T,) [rad], in the sense of the speed.
        step: time between two samples [s].
        exact: poses with closed joints, (T, 3 n).
        rows: first equation of each joint, by name.
    """

    def __init__(self, machine: Machine, form: ModelForm, samples: int = SAMPLES) -> None:
        self.kinematics, self.speed, self.form = machine.kinematics, machine.speed, form
        self.step = 2.0 * math.pi / abs(machine.speed) / samples
        self.angle: Array = np.asarray(machine.speed * self.step * np.arange(TURNS * samples + 1), dtype=float)
        self.exact = machine.kinematics.poses(self.angle)
        self.rows: dict[str, int] = {}
        row = 0
        for joint in form.whole.joints:
            self.rows[joint.name] = row
            row += machine.kinematics.equations_of(joint)
        self.open_rows: list[int] = []
        self._turn, self._near = samples, self.exact

    @property
    def size(self) -> int:
        """Number of violations, k."""
        return len(self.open_rows) + len(self.form.distances)

    def along(self, poses: Array) -> Array:
        """The gaps of all joint equations by the violations; (T, 3 n, k)."""
        columns: list[Array] = []
        for row in self.open_rows:
            gap = np.zeros_like(poses)
            gap[:, row] = 1.0
            columns.append(gap)
        columns += [self.lengthening(joint, poses) for joint in self.form.distances]
        return np.stack(columns, axis=2)

    def opened(self, violations: Array) -> Array:
        """Poses with these violations (T, k)."""
        self._near = self.poses((self.along(self._near) @ violations[:, :, None])[:, :, 0], self._near)
        return self._near

    def settled(self, respond: Callable[[Array], Array], width: int, law: str) -> Softness | None:
        """Errors in the state (T, width) that responds with itself, its first k columns the violations.

        Returns:
            None where nothing may open, or where the violations have no end.
        """
        closed = np.zeros((len(self.angle), width))
        state = self_consistent(respond, closed) if closed.size else None
        return None if state is None else self.softness(self.opened(state[:, : self.size]), law)

    def poses(self, gaps: Array, near: Array) -> Array:
        """Poses that leave these gaps, by Newton iteration from poses near them."""
        poses = near.copy()
        for _ in range(NEWTON_STEPS):
            left = self.kinematics.residual([poses], self.angle) - gaps
            step = np.linalg.solve(self.kinematics.jacobian(poses), left[:, :, None])[:, :, 0]
            poses -= step
            if np.abs(step).max() < NEWTON_DONE:
                break
        return poses

    def rates(self, poses: Array, gap_rates: Array) -> Array:
        """Rates that open the gaps at these rates [m/s]."""
        at_rest = self.kinematics.residual([poses, np.zeros_like(poses)], np.full(len(poses), self.speed))
        opening = (gap_rates - at_rest)[:, :, None]
        return np.asarray(np.linalg.solve(self.kinematics.jacobian(poses), opening)[:, :, 0])

    def distance(self, joint: DistanceJoint, derivatives: list[Array]) -> Jet:
        """Of the two points that a distance joint holds, from poses, rates, accelerations, as many as are given."""
        return joint.distance(self._bodies(derivatives))

    def lengthening(self, joint: DistanceJoint, poses: Array) -> Array:
        """Gaps (T, 3 n) that a distance joint longer by one leaves, where its link stays on its first pin."""
        dx, dy = joint.way(self._bodies([poses]))
        pin = next(pin for pin in self.form.whole.joints if pin.name == joint.joint_b)
        way = np.column_stack([dx.coefficients[0], dy.coefficients[0]])
        gaps, row = np.zeros_like(poses), self.rows[pin.name]
        sign = 1.0 if pin.a == joint.link else -1.0
        gaps[:, row : row + 2] = sign * way / np.linalg.norm(way, axis=1)[:, None]
        return gaps

    def _bodies(self, derivatives: list[Array]) -> dict[str, PoseJet]:
        return pose_jets(self.form.whole, [d / math.factorial(k) for k, d in enumerate(derivatives)])

    def softness(self, poses: Array, law: str) -> Softness:
        """Largest errors of the observed points in these poses."""
        completed_poses = self.form.completed([self.form.kept(poses)])
        exact, moved = (self.kinematics.point_derivatives(p) for p in ([self.exact], completed_poses))
        errors = [
            np.linalg.norm(moved[name][0] - places[0], axis=1)
            / max(diameter(places[0][: self._turn]), self.kinematics.lengths[name])
            for name, places in exact.items()
        ]
        largest = np.max(errors, axis=0)
        return Softness(float(largest.max()), float(largest[self._turn :].max()), law)
