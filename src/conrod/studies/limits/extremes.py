"""Records of a run at an engine's limits, beside its errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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
