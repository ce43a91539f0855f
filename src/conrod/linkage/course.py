"""All poses that a linkage passes, the crank's whole turn or what it reaches of one, and the limits of its input."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from conrod.kinematics import Kinematics
from conrod.linkage.continuation import TURN, End, corrected, crank_angle, tangents, whole_range
from conrod.motion import Array

SAMPLES = 720  # of a full turn


@dataclass(frozen=True)
class CrankRange:
    """What the crank can do.

    Attributes:
        start, stop: least and greatest crank angle [rad] that is reached from angle 0 without changing the assembly
            branch; 0 and 2 pi if the crank turns fully.
        start_end, stop_end: what ends it there: "limit", where the crank has to turn back; "change point", where two
            branches meet, and the motion may go on on either; "none" if the crank turns fully.
        change_points: crank angles [rad] that a crank which turns fully passes smoothly where two branches meet.
    """

    start: float
    stop: float
    start_end: End
    stop_end: End
    change_points: tuple[float, ...] = ()

    @property
    def full(self) -> bool:
        """Whether the crank turns fully."""
        return self.start_end == self.stop_end == "none"


@dataclass(frozen=True)
class Course:
    """Poses that a linkage passes.

    Attributes:
        kinematics: the mechanism's solver.
        periodic: whether they are those of a whole turn, and of every other one too.
        by_angle: whether the parameter is the crank angle [rad], as for a turn or a driver's span; else it is the arc
            length of the poses [1], 0 at crank angle 0.
        parameter: that the samples are taken at, (T,), growing; both ends of a turn are there.
        samples: stacked poses (T, 3 n) [m, m, rad].
        tangents: their derivative by the parameter (T, 3 n).
    """

    kinematics: Kinematics
    periodic: bool
    by_angle: bool
    parameter: Array
    samples: Array
    tangents: Array

    def poses(self, parameter: Array) -> Array:
        """Exact poses (T, 3 n) at parameters (T,) within those of the samples."""
        if self.by_angle:
            return self.kinematics.poses(parameter)
        near = np.abs(self.parameter[:, None] - parameter).argmin(axis=0)
        way = (parameter - self.parameter[near])[:, None]
        guess = self.samples[near] + way * self.tangents[near]
        return corrected(self.kinematics, guess, self.tangents[near])

    def rates(self, parameter: Array) -> Array:
        """Derivative (T, 3 n) of the poses by the parameter, up to a positive factor."""
        if self.by_angle:
            return self.kinematics.derivatives(parameter, 1)[1]
        near = np.abs(self.parameter[:, None] - parameter).argmin(axis=0)
        return tangents(self.kinematics, self.poses(parameter), self.tangents[near])

    def crank_angle(self, poses: Array) -> Array:
        """Crank angles (T,) [rad] of poses (T, 3 n)."""
        return crank_angle(self.kinematics, poses)


def course_of(kinematics: Kinematics) -> Course:
    """All poses that the machine passes on its assembly branch: a turn, its driver's span, or all that it reaches.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0, or does not reach its driver's span.
    """
    span = kinematics.mechanism.driver.span
    if span is not None or kinematics.turns_fully:
        angles = np.linspace(*(span or (0.0, TURN)), SAMPLES + 1)
        return Course(kinematics, kinematics.repeats, True, angles, *kinematics.derivatives(angles, 1))
    columns = (np.array(column) for column in zip(*whole_range(kinematics)[1], strict=True))
    return Course(kinematics, False, False, *columns)


def crank_range(kinematics: Kinematics) -> CrankRange:
    """What the crank can do on the assembly branch of the start poses, whatever span its driver is given.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0.
    """
    driver = kinematics.mechanism.driver
    free = kinematics
    if driver.span is not None:
        free = Kinematics(replace(kinematics.mechanism, driver=replace(driver, span=None)))
    elif kinematics.turns_fully:
        return CrankRange(0.0, TURN, "none", "none", tuple(float(angle) for angle in kinematics.change_angles))
    start_end, places, stop_end = whole_range(free)
    if "none" in {start_end, stop_end}:
        return CrankRange(0.0, TURN, "none", "none")
    start, stop = (float(a) for a in crank_angle(free, np.array([places[0][1], places[-1][1]])))
    return CrankRange(start, stop, start_end, stop_end)
