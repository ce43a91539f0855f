"""Records of a run at an engine's limits, beside its errors, and the exact torque of its drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from conrod.engines.massless_rod import model_form
from conrod.exact.dynamics.coordinates import load_forces
from conrod.exact.dynamics.inverse import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.runs.plain import restore
from conrod.studies.frame.measurement import Measurement


@dataclass(frozen=True)
class SolverRecord:
    """End of the engine's solver over the steps that were sampled.

    Attributes:
        looked_at: number of those steps.
        allowed: iterations that it may take.
        least, most: iterations that it took; None where the engine does not report it.
        residual: largest part of what it was to solve that it left: of the joints' gap acceleration (MuJoCo), over
            omega^2 L, or of their gap rate (pymunk), over omega L.
    """

    looked_at: int
    allowed: int
    least: int | None
    most: int | None
    residual: float | None


@dataclass(frozen=True)
class Mark:
    """A long run at the end of one of its revolutions; errors are the largest since the mark before.

    Attributes:
        revolution: how many have passed.
        position: largest position error, normalised.
        closure: largest gap of a joint, normalised.
        phase: crank angle by the engine's account minus speed x (steps x step length) [rad].
        clock: speed x (the clock that sums its steps, minus the one that counts them) [rad].
    """

    revolution: int
    position: float
    closure: float
    phase: float
    clock: float


@dataclass(frozen=True)
class Flight:
    """A stretch in which a follower is off its cam.

    Attributes:
        start, landing: crank angles [rad].
        gap: the largest [m].
    """

    start: float
    landing: float
    gap: float


# Crank angle [rad], gap there, least and largest gap around it [m].
Gaps = tuple[tuple[float, float, float, float], ...]


@dataclass(frozen=True)
class Extremes:
    """Record of a run, which a ledger keeps beside its errors.

    Attributes:
        samples: how many were recorded and compared.
        finite: whether all poses and rates of the bodies and the motion of the observed points were.
        warnings: what the engine itself warned of, and how often.
        solver: None where the engine has none to look at.
        torque: largest error of the drive torque over its exact peak, from the second sample on: at the first one an
            iterative solver has nothing to start from; None where the engine does not report it.
        penetration: how deep a follower sinks into its cam while it is held [m]; None without a cam.
        flights: of a follower off its cam, the longest first.
        history: marks of a long run, at 1, 2, 5, 10 .. revolutions.
        fingerprint: of the same numbers, to the last bit.
        again: the same of further runs, see `conrod.studies.limits.determinism`.
        gaps: crank angle [rad], gap of a follower there, least and largest one around it [m], see
            `conrod.studies.limits.follower_float`.
    """

    samples: int
    finite: bool
    warnings: Mapping[str, int]
    solver: SolverRecord | None
    torque: float | None
    penetration: float | None
    flights: tuple[Flight, ...]
    history: tuple[Mark, ...]
    fingerprint: str
    again: tuple[str, ...] = ()
    gaps: Gaps = ()

    @classmethod
    def of(cls, measurement: Measurement) -> Extremes | None:
        """Return what was recorded of a measured run; None where it ended before anything could be."""
        return None if measurement.extremes is None else restore(cls, measurement.extremes)


PEAK_SAMPLES = 3600  # of a turn
# Of what all bodies take that move through the travel in a radian: a drive that takes no more than that takes nothing.
NOTHING = 1e-12


class ExactTorque:
    """Torque of a drive at constant speed in the exact motion, of a linkage as an engine is given it.

    By virtual work: what the bodies' inertia and weight take, M q'' - Q, along the motion q' by the crank angle. It is
    the multiplier of the driver's equation, without the joints' reactions, which do no work.

    Args:
        speed: of the crank [rad/s].
        gravity: whether the engine is given any.
        rod: form of links that carry nothing but two pins, see `ROD_FORMS`.
    """

    def __init__(self, kinematics: Kinematics, speed: float, *, gravity: bool, rod: str) -> None:
        self._kinematics, self._speed = kinematics, speed
        self._form = model_form(kinematics.mechanism, rod)
        given = self._form.mechanism
        self._given = given if gravity else replace(given, gravity=(0.0, 0.0))

    @cached_property
    def peak(self) -> float:
        """Largest magnitude over a turn, or over the driver's span [N m]."""
        start, stop = self._kinematics.span
        middle, width = 0.5 * (start + stop), 0.5 * (stop - start)
        for _ in range(2):  # once around, and once more about the highest sample, since a peak can be sharp
            angles = middle + width * np.linspace(-1.0, 1.0, PEAK_SAMPLES)
            if self._kinematics.mechanism.driver.span is not None:
                angles = np.clip(angles, start, stop)
            sizes = np.abs(self.at(angles))
            middle, width = float(angles[np.argmax(sizes)]), 2.0 * width / PEAK_SAMPLES
        return float(sizes.max())

    @cached_property
    def is_nothing(self) -> bool:
        """True where the drive takes nothing but rounding: wheels about their own centres, and no gravity."""
        mass = sum(body.mass for body in self._given.bodies)
        return self.peak <= NOTHING * mass * (self._kinematics.travel * self._speed) ** 2

    def at(self, angle: Array) -> Array:
        """Torque (T,) [N m] about the crank, in the sense of the crank angle, at crank angles (T,) [rad]."""
        poses, first, second = (self._form.kept(d) for d in self._kinematics.derivatives(angle, 2))
        rates = first * self._speed
        forces = inertia_forces(self._given, poses, rates, second * self._speed**2)
        forces -= load_forces(self._given, poses, rates, angle / self._speed)
        return np.asarray(np.sum(forces * first, axis=1), dtype=float)
