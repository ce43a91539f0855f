"""The grid convergence index beside the true error: what a study of convergence alone would have noticed.

Who has no exact solution compares three grids, f1 (fine), f2 and f3 (coarse), at ratios of step r21 and r32. The
observed order p solves

    (f3 - f2) / (f2 - f1) = r21^p (r32^p - s) / (r21^p - s),    s = sign of the left side,

which is equation (3) of Celik et al., J. Fluids Eng. 130 (2008) 078001 (they iterate to a fixed point, which ratios
as unequal as 2 and 10 keep from converging; the right side grows with p, so halving an interval always finds the same
p). The grid convergence index (Roache, J. Fluids Eng. 116 (1994) 405) is the band

    Fs |f2 - f1| / (r21^p - 1)

on both sides of f1, in which the exact value should lie. Fs = 1.25 where the order is reasonable: finite, not
oscillating, and from 0.5 to half an order above the formal one. Else Fs = 3, with p clipped into 0.5 .. formal order
(Oberkampf and Roy, Verification and Validation in Scientific Computing, 2010, section 8.7). An order above the formal
one is never used: it would only make the band narrower.

f is one component, along x or y, of one observed point's position, velocity or acceleration at one crank angle: the
index is for scalars, and a norm has a kink where the vector vanishes. A component whose exact value never changes is
left out. Two solutions at one angle differ by the difference of their signed errors, so these are all that is needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conrod.engines import engine_named
from conrod.engines.capabilities import variations_of
from conrod.exact.motion import Array
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.validation.refinement import Family, rounding_level

SAFE, UNSAFE = 1.25, 3.0
LEAST_ORDER, ABOVE_FORMAL = 0.5, 0.5
LARGEST_ORDER = 30.0  # beyond: not finite
VARIES = 1e-9  # of its norm: less is a component that never changes
ANGLES = 360

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Share:
    """Cells whose band holds the true error, of one quantity.

    Attributes:
        contained, missed: cells (component of a point at an angle) whose band did, did not.
        at_rounding: cells whose true error is rounding: neither, because there is nothing to hold.
        unreasonable: contained or missed cells with safety factor 3, the oscillating ones among them.
        oscillating: cells in which the differences change sign from grid to grid.
        ratio: median of band / |true error|; None where all is at rounding.
    """

    contained: int
    missed: int
    at_rounding: int
    unreasonable: int
    oscillating: int
    ratio: float | None

    @property
    def judged(self) -> int:
        """Cells that are not at rounding."""
        return self.contained + self.missed

    @property
    def share(self) -> float | None:
        """Contained cells over those judged; None where there is none."""
        return self.contained / self.judged if self.judged else None


@dataclass(frozen=True)
class GridConvergence:
    """Verdict of a self-convergence study on a family.

    Attributes:
        shares: by quantity, over all triples of neighbouring grids that completed; empty where there is none.
        failed: steps per revolution and outcome of the grids that did not complete; their triples are missing.
    """

    engine: str
    label: str
    path: str
    formal_order: float
    shares: Mapping[str, Share]
    failed: tuple[tuple[int, str], ...]


class Bands(NamedTuple):
    """Verdicts on cells; each (K,)."""

    band: Array  # normalised as the errors are
    error: Array  # of the fine grid, absolute
    at_rounding: Flags
    unreasonable: Flags
    oscillating: Flags

    def share(self) -> Share:
        """Counts and the median ratio."""
        judged = ~self.at_rounding
        held = self.band >= self.error
        # An error that happens to be exactly zero is held, and has no ratio.
        of = judged & (self.error > 0.0)
        return Share(
            contained=int((held & judged).sum()),
            missed=int((~held & judged).sum()),
            at_rounding=int(self.at_rounding.sum()),
            unreasonable=int((self.unreasonable & judged).sum()),
            oscillating=int((self.oscillating & judged).sum()),
            ratio=float(np.median(self.band[of] / self.error[of])) if of.any() else None,
        )


def grid_convergence_of(family: Family, measurements: Mapping[str, Measurement]) -> GridConvergence:
    """Grid convergence index of every triple of neighbouring grids, beside the true error.

    Raises:
        KeyError: a case of the family has not been measured.
    """
    formal = variations_of(engine_named(family.engine)).formal_order(family.cells[0].settings)
    kept = varying_components(family.scene)
    runs = [(case.settings.steps_per_revolution, measurements[case.key]) for case in family.cells]
    triples = [t for t in (runs[i : i + 3] for i in range(len(runs) - 2)) if all(m.signed is not None for _, m in t)]
    found = {q: [_bands_of(triple, q, kept, formal) for triple in triples] for q in QUANTITIES if triples}
    return GridConvergence(
        engine=family.engine,
        label=family.label,
        path=family.path,
        formal_order=formal,
        shares={q: Bands(*map(np.concatenate, zip(*parts, strict=True))).share() for q, parts in found.items()},
        failed=tuple((steps, measured.outcome) for steps, measured in runs if measured.signed is None),
    )


def varying_components(scene: Scene) -> dict[str, tuple[bool, bool]]:
    """Of each observed point, whether its exact position changes along x and along y."""
    kept = {}
    for name, point in scene.motion(scene.kinematics.angles(ANGLES), scene.speed).points.items():
        ways = np.ptp(point.position, axis=0) / scene.lengths[name]
        kept[name] = (bool(ways[0] > VARIES), bool(ways[1] > VARIES))
    return kept


def _bands_of(
    triple: Sequence[tuple[int, Measurement]], quantity: str, kept: Mapping[str, tuple[bool, bool]], formal: float
) -> Bands:
    """Bands of one quantity over all points, angles and components of three grids, coarse to fine."""
    coarse, middle, fine = (
        np.concatenate([run.signed_of(name, quantity)[:, list(axes)].ravel() for name, axes in kept.items()])
        for _, run in triple
    )
    steps = [run[0] for run in triple]
    return bands(fine, middle, coarse, steps[2] / steps[1], steps[1] / steps[0], formal, rounding_level(steps[2]))


def bands(fine: Array, middle: Array, coarse: Array, r21: float, r32: float, formal: float, rounding: float) -> Bands:
    """Error bands around the fine grid's values, beside its true errors.

    Args:
        fine, middle, coarse: signed errors (K,) of f1, f2 and f3, or f1, f2, f3 minus the exact value.
        r21, r32: ratios of the steps, above 1.
        formal: order of the scheme.
        rounding: level below which errors are rounding.
    """
    d21, d32 = middle - fine, coarse - middle
    order = observed_order_of_three(d21, d32, r21, r32)
    oscillating = d21 * d32 < 0.0
    reasonable = ~oscillating & (order >= LEAST_ORDER) & (order <= formal + ABOVE_FORMAL)
    used = np.clip(np.nan_to_num(order, nan=LEAST_ORDER), LEAST_ORDER, formal)
    band = np.where(reasonable, SAFE, UNSAFE) * np.abs(d21) / (r21**used - 1.0)
    error = np.abs(fine)
    # Grids that agree to rounding about a wrong value are no tie: that is the very thing to notice. So it is the error
    # that decides, and not the difference.
    return Bands(band, error, error < rounding, ~reasonable, oscillating)


def observed_order_of_three(d21: Array, d32: Array, r21: float, r32: float) -> Array:
    """Order p (K,) of differences f2 - f1 and f3 - f2; negative where they grow, nan where both are zero.

    Celik et al. take the absolute value of a logarithm, by which differences that grow would have a positive order;
    here they have the negative one that they have.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        target = np.log(np.abs(d32)) - np.log(np.abs(d21))
    sign = np.where(d21 * d32 < 0.0, -1.0, 1.0)
    low, high = np.full_like(target, -LARGEST_ORDER), np.full_like(target, 1.01 * LARGEST_ORDER)
    for _ in range(60):
        middle = 0.5 * (low + high)
        # An order of exactly zero gives 0/0, which is not below: the interval then closes on zero from above.
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = (r32**middle - sign) / (r21**middle - sign)
            below = np.log(ratio) + middle * np.log(r21) < target
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.where(np.isnan(target), np.nan, 0.5 * (low + high))
