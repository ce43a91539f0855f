"""Dimensionless groups that a setting and a scene are compared with others by.

What `conrod recommend` finds: plain, frozen data.

What a setting saves against the engine's stock settings.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics.inverse import mass_ratio
from conrod.exact.transmission import least_transmission_angle
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing


@dataclass(frozen=True)
class Groups:
    """What a recommendation depends on, free of size, mass and speed.

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

    def in_words(self) -> str:
        """One line for people."""
        angle = self.transmission_angle
        words = [
            f"{self.steps_per_revolution} steps per revolution",
            f"omega x time constant = {self.time_constant:.3g}",
            f"mass ratio = {self.mass_ratio:.3g}",
            *([] if angle is None else [f"least transmission angle = {math.degrees(angle):.1f} deg"]),
        ]
        return ", ".join(words)


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
    """A run that the grid does not contain: what is other about it, and its errors (None unless it completed)."""

    what: str
    outcome: str
    errors: Mapping[str, float] | None
    held: bool


@dataclass(frozen=True)
class Rejected:
    """A cheaper setting that the grid's runs allow and a confirming run does not."""

    rule: str
    steps_per_revolution: int
    why: str


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
    cell: RunCase
    errors: Mapping[str, float]
    margin: float
    timing: Timing
    confirmations: tuple[Confirmation, ...]
    rejected: tuple[Rejected, ...]
    stock: StockComparison
    groups: Groups
    paste: str


@dataclass(frozen=True)
class Refusal:
    """Nothing of one engine qualifies: the nearest setting, and how far each quantity is out.

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


@dataclass(frozen=True)
class StockComparison:
    """A setting beside the stock ones at all steps of the grid, by quantity where it is a mapping.

    Attributes:
        digits: decimal digits gained at equal cost; None where no stock run is as cheap as this.
        best: least error that any stock run of the grid reaches; empty where none completed.
        cost_factor: how many times the cost is that the cheapest stock run within all tolerances has; None where the
            stock settings never get there.
    """

    digits: Mapping[str, float | None]
    best: Mapping[str, float]
    cost_factor: float | None


def compared_with_stock(
    measurement: Measurement,
    timing: Timing,
    stock: Sequence[RunCase],
    measurements: Mapping[str, Measurement],
    timings: Mapping[str, Timing],
    allowed: Mapping[str, float],
) -> StockComparison:
    """A measured and timed setting beside completed stock runs.

    Args:
        stock: cells of the stock settings, at increasing numbers of steps; those without a timing do not count.
        allowed: largest error by quantity.
    """
    timed = [(timings[c.key].seconds_per_revolution, measurements[c.key]) for c in stock if c.key in timings]
    cost = timing.seconds_per_revolution
    within = [c for c, m in timed if all((m.largest(q) or 0.0) <= limit for q, limit in allowed.items())]
    digits: dict[str, float | None] = {}
    for quantity in allowed:
        errors = [(c, m.largest(quantity) or 0.0) for c, m in timed]
        digits[quantity] = _digits(errors, cost, measurement.largest(quantity) or 0.0)
    return StockComparison(
        digits=digits,
        best={q: min(m.largest(q) or 0.0 for _, m in timed) for q in allowed} if timed else {},
        cost_factor=min(within) / cost if within else None,
    )


def _digits(stock: Sequence[tuple[float, float]], cost: float, error: float) -> float | None:
    """Decimal digits between the stock error at a cost, interpolated between runs, and an error."""
    points = sorted(stock)
    if not points or cost < points[0][0] or error <= 0.0:
        return None
    costs, errors = (np.log([max(p[k], 1e-300) for p in points]) for k in (0, 1))
    return float(np.interp(math.log(cost), costs, errors) - math.log(error)) / math.log(10.0)
