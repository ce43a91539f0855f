"""Places of values along an axis of a figure: the safe end on the left, equal steps of its scale equally long."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from conrod.exact.motion import Array
from conrod.report.charts.canvas import on_grid
from conrod.studies.limits.axes import Scale
from conrod.studies.limits.results import Probe, Walk

MOST_TICKS = 13
ROOM = 0.02  # beside the ends, of the whole length
ROUND = (1.0, 2.0, 5.0)


@dataclass(frozen=True)
class AxisScale:
    """The scale that some walks of one axis share.

    Attributes:
        low, high: smallest and largest place of a value.
        falling: whether values fall from the safe end to the failing one.
    """

    scale: Scale
    low: float
    high: float
    falling: bool

    @classmethod
    def of(cls, scale: Scale, walks: Sequence[Walk]) -> AxisScale:
        """Return the scale that holds all probes; walks both ways from one value have the smaller values left."""
        places = [place(scale, probe.value) for walk in walks for probe in walk.probes]
        ways = {walk.falling for walk in walks if len(walk.probes) > 1}
        return cls(scale, min(places), max(places), ways == {True})

    @property
    def span(self) -> float:
        """Length of the axis, in its own places."""
        return self.high - self.low

    def places(self, probes: Sequence[Probe]) -> Array:
        """Return the places (N,) of the values of some probes, on the grid that is drawn."""
        return on_grid(np.array([place(self.scale, probe.value) for probe in probes]), self.span)

    def apply(self, axes: Axes, label: str) -> None:
        """Give the horizontal axis its ends, its ticks and its label."""
        room = max(ROOM * (self.high - self.low), 1e-3)
        ends = (self.low - room, self.high + room)
        axes.set_xlim(*(reversed(ends) if self.falling else ends))
        ticks = self.ticks()
        axes.set_xticks([place(self.scale, value) for value in ticks], [tick_text(self.scale, v) for v in ticks])
        axes.set_xlabel(label)

    def ticks(self) -> list[float]:
        """Return round values between the ends: one, two and five of each decade, or decades where these are many."""
        if self.scale is Scale.LISTED:
            return _even(self.low, self.high)
        if self.scale is Scale.NEARNESS:
            nines = range(math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9) + 1)
            return (
                [0.1, *(1.0 - 10.0**-k for k in nines if k > 0)] if self.low < 0.1 else [1.0 - 10.0**-k for k in nines]
            )
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        fine = [m * 10.0**k for k in decades for m in ROUND if self._holds(math.log10(m) + k)]
        if len(fine) <= MOST_TICKS:
            return fine
        whole = [10.0**k for k in decades if self._holds(k)]
        every = -(-len(whole) // MOST_TICKS)
        # Counted from one, which every long axis has in it.
        return [value for value in whole if round(math.log10(value)) % every == 0]

    def _holds(self, where: float) -> bool:
        return self.low - 1e-9 <= where <= self.high + 1e-9


def place(scale: Scale, value: float) -> float:
    """Return where a value stands: decades for numbers, decades of the distance to one for nearness, else the value."""
    match scale:
        case Scale.NEARNESS:
            return -math.log10(1.0 - value)
        case Scale.LISTED:
            return value
        case _:
            return math.log10(value)


def tick_text(scale: Scale, value: float) -> str:
    """Return a round value, short."""
    if scale is Scale.NEARNESS and value > 0.9991:
        return f"1 - 1e{round(math.log10(1.0 - value))}"
    if scale is Scale.LISTED or 1e-3 < value < 99999.0:
        return f"{value:.6g}"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")


def _even(low: float, high: float) -> list[float]:
    """Multiples of a round step."""
    step = next(s for s in (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 1e9) if (high - low) / s <= MOST_TICKS)
    return [step * k for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
