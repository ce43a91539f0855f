"""Least squares of exact paths against those that a model's points describe."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.frame import UNITS, GivenFrame
from conrod.own.models.references import Paths

DIFFERENCE = 1e-6  # of a coordinate's size, for central differences: they are right to 1e-10
# A step that gains less than this share of the squares is the last; so is one that is rounding.
GAIN, ROUNDING = 2e-3, 1e-15


@dataclass(frozen=True)
class ObservedPaths:
    """A model's points in a view: complex paths (P, T) around the crank's axis, in the model's unit.

    Attributes:
        coordinate: of the crank (T,) [rad], evenly spread over a turn.
        lengths: normalising length of each point (P,) [m].
        links: exp(i turn) of the link that each point is on (P, T), in the view.
    """

    coordinate: Array
    paths: Array
    lengths: Array
    links: Array


@dataclass(frozen=True)
class FrameFit:
    """The document's frame laid into a view.

    Attributes:
        displacements: movement of each point on its link (P,), complex [m], that puts it where it should be.
        distances: remaining distance of each point's path (P, T), complex, over the point's length.
    """

    sense: int
    rotation: float
    zero: float
    unit: float
    displacements: Array
    distances: Array

    def at(self, values: Mapping[str, float]) -> FrameFit:
        """The same with another rotation or zero; `distances` is not computed anew."""
        return replace(self, rotation=values.get("rotation", self.rotation), zero=values.get("zero", self.zero))

    @property
    def largest(self) -> float:
        """Largest distance of a point from where it should be, over its length."""
        return float(np.abs(self.distances).max())

    @property
    def rms(self) -> float:
        """Root mean square of the distances."""
        return float(np.sqrt(np.mean(np.abs(self.distances) ** 2)))


def distances(observed: ObservedPaths, paths: Paths, there: FrameFit) -> Array:
    """Distances (P, T), complex, of a model's points from exact paths in a frame, over their lengths."""
    exact = paths(there.sense * (observed.coordinate - there.zero))
    found = there.unit * np.exp(-1j * there.rotation) * observed.paths + there.displacements[:, None] * observed.links
    return np.asarray((found - exact) / observed.lengths[:, None])


def with_distances(there: FrameFit, observed: ObservedPaths, paths: Paths) -> FrameFit:
    """A frame with the distances that it leaves to these paths."""
    return replace(there, distances=distances(observed, paths, there))


def fit_frame(observed: ObservedPaths, paths: Paths, sense: int, given: GivenFrame) -> FrameFit:
    """The frame in which exact paths fit the observed ones best; what is given of it is kept."""
    coarse = _coarse(observed, paths, sense, given)
    coarse = replace(coarse, unit=given.unit or nearest_unit(coarse.unit))
    free = free_of(given)

    def left(x: Array) -> Array:
        return distances(observed, paths, coarse.at(dict(zip(free, x.tolist(), strict=True))))

    found = least_distances(left, np.array([getattr(coarse, name) for name in free]), np.ones(len(free)))
    return with_distances(coarse.at(dict(zip(free, found.tolist(), strict=True))), observed, paths)


def free_of(given: GivenFrame) -> list[str]:
    """Parts of a frame that are fitted."""
    return [name for name in ("zero", "rotation") if getattr(given, name) is None]


def nearest_unit(size: float) -> float:
    """The unit of length nearest to a size [m]."""
    return min(UNITS.values(), key=lambda unit: abs(np.log(unit / size)))


def _coarse(observed: ObservedPaths, paths: Paths, sense: int, given: GivenFrame) -> FrameFit:
    """The best of as many crank zeros as there are samples; rotation and unit then follow from a linear problem."""
    weighted, count = observed.paths / observed.lengths[:, None], len(observed.coordinate)
    if given.zero is None:
        # Between samples of a turn that start at one of them the angles are always the same ones.
        turn = paths(observed.coordinate - observed.coordinate[0]) / observed.lengths[:, None]
        tried = [
            (float(zero), turn[:, sense * (np.arange(count) - k) % count]) for k, zero in enumerate(observed.coordinate)
        ]
    else:
        tried = [(given.zero, paths(sense * (observed.coordinate - given.zero)) / observed.lengths[:, None])]

    def placed(zero: float, exact: Array) -> FrameFit:
        factor = complex(np.sum(exact * np.conj(weighted))) / float(np.sum(np.abs(weighted) ** 2))
        rotation = -float(np.angle(factor)) if given.rotation is None else given.rotation
        unit = given.unit or max(float((factor * np.exp(1j * rotation)).real), 1e-12)
        left = unit * np.exp(-1j * rotation) * weighted - exact
        return FrameFit(sense, rotation, zero, unit, np.zeros(len(left), dtype=complex), left)

    return min((placed(zero, exact) for zero, exact in tried), key=lambda one: one.rms)


def least_distances(left: Callable[[Array], Array], start: Array, sizes: Array) -> Array:
    """The least squares of complex distances by a few unknowns.

    Args:
        left: distances; raises InvalidInput where there are none, and the step there is shortened.
        sizes: of the unknowns, for steps and differences.

    Raises:
        InvalidInput: there are no distances at the start.
    """
    count = len(_stacked(left(start)))

    def residuals(steps: Array) -> Array:
        try:
            return _stacked(left(start + sizes * steps))
        except InvalidInput:
            return np.full(count, np.nan)

    def jacobian(steps: Array) -> Array:
        return slopes(left, start + sizes * steps, sizes)

    if not len(start):
        return start
    found = least_squares(residuals, np.zeros(len(start)), jac=jacobian, ftol=GAIN, xtol=ROUNDING, gtol=ROUNDING)
    return np.asarray(start + sizes * found.x)


def slopes(left: Callable[[Array], Array], here: Array, sizes: Array) -> Array:
    """Derivatives of the distances by the unknowns, each in its size; (2 P T, n)."""
    steps = DIFFERENCE * np.diag(sizes)
    return np.column_stack([_stacked(left(here + by) - left(here - by)) / (2.0 * DIFFERENCE) for by in steps])


def _stacked(distances: Array) -> Array:
    flat = distances.ravel()
    return np.concatenate([flat.real, flat.imag])


def indistinct(jacobian: Array, names: Sequence[str], least: float) -> tuple[tuple[str, ...], ...]:
    """Groups of unknowns that can be changed together without a trace; by the null space of the scaled slopes."""
    scale = np.linalg.norm(jacobian, axis=0)
    dead = [(name,) for name, size in zip(names, scale, strict=True) if size <= least * max(scale.max(), 1e-300)]
    _, singular, directions = np.linalg.svd(jacobian / np.where(scale > 0.0, scale, 1.0), full_matrices=False)
    groups = []
    for value, direction in zip(singular, directions, strict=True):
        if value <= least * singular[0]:
            large = np.abs(direction) > 0.05 * np.abs(direction).max()
            groups.append(tuple(name for name, counts in zip(names, large, strict=True) if counts))
    return tuple(dict.fromkeys([*dead, *(g for g in groups if len(g) > 1)]))
