"""Results of document 002's MATLAB listing, run as it stands and with each mend, against the exact motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from audits.formulas.saw_listing import (
    Division,
    acceleration,
    arguments,
    elementwise_division,
    matrix_right_division,
    rod_acceleration,
    rod_speed,
    velocity,
)
from conrod.exact.motion import Array
from conrod.scenes import RPM, Saw

SPEEDS = (40.0, 500.0)  # [rpm], of the document's machine and of its figures
# How the listing is run: its operators, and rad/s for one of what is typed in.
WAYS: dict[str, tuple[Division, float]] = {
    "as printed, the speed typed in rpm": (matrix_right_division, 1.0),
    "as printed, the speed typed in rad/s": (matrix_right_division, RPM),
    "with .*, ./ and .^, the speed typed in rpm": (elementwise_division, 1.0),
    "with .*, ./ and .^, the speed typed in rad/s": (elementwise_division, RPM),
}


@dataclass(frozen=True)
class ListingRun:
    """Peaks in size over the listing's angles; mm and s.

    Attributes:
        speed: what is meant [rpm].
        way: how the listing is run; "exact motion" for what ought to come out.
        rod_speed: of w3 [rad/s], `rod_acceleration` of a3 [rad/s^2].
        is_one_number: whether w3 and a3 are one number for all angles.
        velocity_error, acceleration_error: largest deviation from the exact motion, as a share of its peak.
    """

    speed: float
    way: str
    rod_speed: float
    rod_acceleration: float
    is_one_number: bool
    velocity: float
    acceleration: float
    velocity_error: float
    acceleration_error: float


def runs() -> tuple[ListingRun, ...]:
    """All ways at all speeds."""
    return tuple(_run(rpm, way) for rpm in SPEEDS for way in WAYS)


def _run(rpm: float, way: str) -> ListingRun:
    divide, unit = WAYS[way]
    t2, w2 = arguments()["t2"], rpm * unit
    exact = Saw().motion(t2, rpm * RPM).point("C")
    turn, turn_rate = (np.atleast_1d(f(t2, w2, divide)) for f in (rod_speed, rod_acceleration))
    speed, rate = velocity(t2, w2, divide), acceleration(t2, w2, divide)
    return ListingRun(
        rpm,
        way,
        _peak(turn),
        _peak(turn_rate),
        len(turn) == 1,
        _peak(speed),
        _peak(rate),
        _off(speed, exact.velocity[:, 0] / 1e-3),
        _off(rate, exact.acceleration[:, 0] / 1e-3),
    )


def _peak(values: Array) -> float:
    return float(np.abs(values).max())


def _off(values: Array, exact: Array) -> float:
    return _peak(values - exact) / _peak(exact)
