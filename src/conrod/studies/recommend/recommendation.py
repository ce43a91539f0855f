"""Findings of `conrod recommend`: plain, frozen data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics.inverse import mass_ratio
from conrod.exact.linkage.transmission import least_transmission_angle
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing


@dataclass(frozen=True)
class Groups:
    """Dimensionless groups that a recommendation depends on, free of size, mass and speed.

    Attributes:
        steps_per_revolution: 2 pi over the step of the crank angle.
        time_constant: crank speed x time constant of what closes the joints [rad]; 0 where they are closed at once.
        mass_ratio: heaviest link over the lightest that a joint feels.
        transmission_angle: the least over a turn [rad]; None where there is none.
    """

    steps_per_revolution: int
    time_constant: float
    mass_ratio: float
    transmission_angle: float | None


def groups_of(scene: Scene, settings: Settings) -> Groups:
    """The groups of a setting on a scene."""
    mechanism = scene.kinematics.mechanism
    return Groups(
        settings.steps_per_revolution,
        abs(scene.speed) * settings.time_constant(bool(mechanism.cam_contacts)),
        mass_ratio(mechanism),
        least_transmission_angle(scene.kinematics),
    )


@dataclass(frozen=True)
class Confirmation:
    """A run that the grid does not contain.

    Attributes:
        what: is other about it.
        errors: of the quantities that a tolerance was given for; None unless it completed.
    """

    what: str
    outcome: str
    errors: Mapping[str, float] | None
    held: bool


@dataclass(frozen=True)
class Rejected:
    """A cheaper setting that the grid's runs allow and a confirming run does not."""

    rule: str
    steps_per_revolution: int
    why: tuple[Confirmation, ...]


@dataclass(frozen=True)
class Savings:
    """A setting beside the stock ones at all steps of the grid, by quantity where it is a mapping.

    Attributes:
        digits: decimal digits gained at equal cost; None where no stock run is as cheap as this.
        best: least error that any stock run reaches; empty where none completed.
        cost_factor: cost of the cheapest stock run within all tolerances over this one's; None where there is none.
    """

    digits: Mapping[str, float | None]
    best: Mapping[str, float]
    cost_factor: float | None


@dataclass(frozen=True)
class Recommendation:
    """The cheapest confirmed setting of one engine.

    Attributes:
        errors: largest error of each quantity that a tolerance was given for.
        margin: least of allowed over found.
        paste: the setting as lines for a model or a program.
    """

    engine: str
    rule: str
    preset: str | None
    case: RunCase
    errors: Mapping[str, float]
    margin: float
    timing: Timing
    confirmations: tuple[Confirmation, ...]
    rejected: tuple[Rejected, ...]
    savings: Savings
    groups: Groups
    paste: str


@dataclass(frozen=True)
class Refusal:
    """No setting of one engine qualifies: the nearest one, and how far each quantity is out.

    Attributes:
        excess: quantity -> found over allowed, of those that are out.
        why: a line for people where there is no nearest setting.
    """

    engine: str
    rule: str
    steps_per_revolution: int
    errors: Mapping[str, float]
    excess: Mapping[str, float]
    rejected: tuple[Rejected, ...]
    why: str = ""


def savings_of(
    measurement: Measurement,
    timing: Timing,
    cases: Sequence[RunCase],
    measurements: Mapping[str, Measurement],
    timings: Mapping[str, Timing],
    allowed: Mapping[str, float],
) -> Savings:
    """A measured and timed setting beside completed stock runs.

    Args:
        cases: of the stock settings, at increasing numbers of steps; those without a timing do not count.
        allowed: largest error by quantity.
    """
    timed = [(timings[c.key].seconds_per_revolution, measurements[c.key]) for c in cases if c.key in timings]
    cost = timing.seconds_per_revolution
    within = [c for c, m in timed if all((m.largest(q) or 0.0) <= limit for q, limit in allowed.items())]
    errors = {q: [(c, m.largest(q) or 0.0) for c, m in timed] for q in allowed}
    return Savings(
        digits={q: _digits(errors[q], cost, measurement.largest(q) or 0.0) for q in allowed},
        best={q: min(error for _, error in errors[q]) for q in allowed if timed},
        cost_factor=min(within) / cost if within else None,
    )


def _digits(stock: Sequence[tuple[float, float]], cost: float, error: float) -> float | None:
    """Decimal digits between the stock error at a cost, interpolated between (cost, error), and an error."""
    points = sorted(stock)
    if not points or cost < points[0][0] or error <= 0.0:
        return None
    costs, errors = (np.log([max(p[k], 1e-300) for p in points]) for k in (0, 1))
    return float(np.interp(math.log(cost), costs, errors) - math.log(error)) / math.log(10.0)
