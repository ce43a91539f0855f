"""Least-squares fit of a machine's exact paths to the paths of a model's points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.kinematics import ExactReference, GenericReference
from conrod.exact.motion import Array
from conrod.mjcf.request import LENGTH_UNITS, Scan
from conrod.models.check.frame import GivenFrame, PlaneView
from conrod.models.check.references import (
    ALL_LENGTHS,
    length_names,
    length_of,
    paths_of,
    returns_after_turn,
    with_branch_of,
    with_lengths,
)
from conrod.scenes import Scene

DIFFERENCE_STEP = 1e-6  # of a coordinate's size, for central differences: they are right to 1e-10
# A step that gains less than this share of the squares is the last; so is one that is rounding.
MIN_GAIN, ROUNDING = 2e-3, 1e-15
SAME_DISTANCE = 1e-9  # of the points' lengths: distances that differ by less are none


@dataclass(frozen=True)
class PathSearch:
    """A model's paths in one view, with the machine that is to explain them.

    Attributes:
        given: parts of the frame that are not fitted.
        branch: on which the machine is assembled; None for its own.
    """

    scene: Scene
    scan: Scan
    view: PlaneView
    given: GivenFrame
    branch: GenericReference | None = None

    @property
    def sense(self) -> int:
        """+1 if the crank angle grows with the hinge's coordinate."""
        return self.view.sense * self.scene.mechanism().driver.sense

    @cached_property
    def paths(self) -> Array:
        """Paths of the points (P, T) around the crank's axis, as complex numbers, in the model's unit."""
        return np.array([self.view.as_complex(positions - self.scan.anchor) for positions in self.scan.positions])

    @cached_property
    def links(self) -> Array:
        """exp(i rotation) of the link that each point is on (P, T), in the view."""
        return np.asarray(np.exp(1j * self.view.sense * self.scan.turns))

    @cached_property
    def norms(self) -> Array:
        """Normalising length L of each point (P, 1) [m]."""
        return np.array([[self.scene.lengths[name]] for name in self.scan.points])

    @cached_property
    def lengths(self) -> tuple[str, ...]:
        """Names of the machine's length parameters, without `ALL_LENGTHS`."""
        return tuple(name for name in length_names(self.scene) if name != ALL_LENGTHS)

    def exact(self, reference: ExactReference, angle: Array) -> Array:
        """Exact paths of the points (P, T), as complex numbers [m], on the searched branch, at crank angles (T,)."""
        return paths_of(with_branch_of(reference, self.branch), self.scan.points)(angle)


@dataclass(frozen=True)
class FrameFit:
    """A machine fitted to a model's paths, with the frame of the scene's document in the view.

    Attributes:
        displacements: movement of each point on its link (P,), complex [m], that puts it where it should be.
    """

    search: PathSearch
    machine: ExactReference
    rotation: float
    zero: float
    unit: float
    displacements: Array

    @property
    def exact(self) -> Array:
        """Exact paths of the points (P, T) where the model's points are, as complex numbers [m]."""
        return self.search.exact(self.machine, self.search.sense * (self.search.scan.coordinate - self.zero))

    @cached_property
    def distances(self) -> Array:
        """Remaining distance of each point's path from the exact one (P, T), complex, over the point's length."""
        return self._distances_from(self.exact)

    def _distances_from(self, exact: Array) -> Array:
        """The distances from known exact paths (P, T)."""
        search = self.search
        turned = self.unit * np.exp(-1j * self.rotation) * search.paths
        found = turned + self.displacements[:, None] * search.links
        return np.asarray((found - exact) / search.norms)

    @property
    def largest(self) -> float:
        """Largest distance of a point from its exact position, over the point's length."""
        return float(np.abs(self.distances).max())

    @property
    def rms(self) -> float:
        """Root mean square of the distances."""
        return float(np.sqrt(np.mean(np.abs(self.distances) ** 2)))

    def refine(self, lengths: Sequence[str] = (), points: Sequence[str] = ()) -> FrameFit:
        """Fit the free parts of the frame, some lengths and the places of some points by least squares.

        Raises:
            InvalidInput: the start has no distances, or the fit leads to no machine.
        """
        search, scene = self.search, self.search.scene
        frame = [name for name in ("zero", "rotation") if getattr(search.given, name) is None]
        rows = [search.scan.points.index(point) for point in points]
        # The largest length of the machine is what small lengths are judged by.
        size = max((abs(length_of(scene, name)) for name in search.lengths), default=1.0)
        values = [getattr(self, name) for name in frame] + [length_of(scene, name) for name in lengths]
        sizes = [1.0] * len(frame) + [1.0 if name == ALL_LENGTHS else size for name in lengths]
        places, scale = self.displacements[rows], np.array(sizes + [size] * (2 * len(rows)))
        origin = np.concatenate([values, places.real, places.imag])
        # By lengths, and by machine and crank zero: most steps of a Jacobian change neither.
        machines, paths = dict[bytes, ExactReference](), dict[tuple[int, float], Array]()

        def fit_at(steps: Array) -> FrameFit:
            """The fit at given steps of the unknowns from the start, each in units of its size."""
            turned, own, placed = np.split(origin + scale * steps, np.cumsum([len(frame), len(lengths)]))
            moved, half = self.displacements.copy(), len(rows)
            moved[rows] = placed[:half] + 1j * placed[half:]
            there: Any = dict(zip(frame, turned.tolist(), strict=True))
            if (key := own.tobytes()) not in machines:
                machines[key] = with_lengths(scene, lengths, own, in_fit=True) if lengths else self.machine
            return replace(self, machine=machines[key], displacements=moved, **there)

        def distances_at(steps: Array) -> Array:
            """Distances (2 P T,), real and imaginary parts."""
            there = fit_at(steps)
            if (key := (id(there.machine), there.zero)) not in paths:
                paths[key] = there.exact
            flat = there._distances_from(paths[key]).ravel()
            return np.concatenate([flat.real, flat.imag])

        def residuals(steps: Array) -> Array:
            """Distances; NaN where the step leads to no machine, so that the solver shortens it."""
            try:
                return distances_at(steps)
            except InvalidInput:  # a step that leads there is shortened
                return np.full(count, np.nan)

        def jacobian(steps: Array) -> Array:
            """Jacobian of the distances by central differences."""
            ways = DIFFERENCE_STEP * np.eye(len(steps))
            return np.column_stack(
                [(distances_at(steps + by) - distances_at(steps - by)) / (2.0 * DIFFERENCE_STEP) for by in ways]
            )

        steps = np.zeros(len(origin))
        count = len(distances_at(steps))
        if len(steps):
            # Imported here: a check that is recalled from the ledger fits nothing.
            from scipy.optimize import least_squares

            steps = least_squares(residuals, steps, jac=jacobian, ftol=MIN_GAIN, xtol=ROUNDING, gtol=ROUNDING).x
        return fit_at(steps)


def fit_frame(search: PathSearch) -> FrameFit:
    """Fit the document's frame to a model's paths; given parts of the frame are kept."""
    coarse = _fit_coarsely(search)
    unit = search.given.unit or min(LENGTH_UNITS.values(), key=lambda unit: abs(np.log(unit / coarse.unit)))
    return replace(coarse, unit=unit).refine()


def _fit_coarsely(search: PathSearch) -> FrameFit:
    """Try every sample as the crank's zero; rotation and unit then follow from a linear problem."""
    given, sense, coordinate, norms = search.given, search.sense, search.scan.coordinate, search.norms
    span, count = search.scene.kinematics.mechanism.driver.span, len(coordinate)
    if span is not None:
        return _fit_pass_coarsely(search, span)
    if given.zero is None and not returns_after_turn(search.scene):
        # Each turn is another: the samples may be of the first one, or begin in the one before.
        spacing = float(coordinate[1] - coordinate[0])
        around: Array = np.asarray(sense * spacing * np.arange(1 - count, count), dtype=float)
        turns = search.exact(search.scene, around) / norms
        tried = [(float(zero), turns[:, count - 1 - k : 2 * count - 1 - k]) for k, zero in enumerate(coordinate)]
    elif given.zero is None:
        # Between samples of a turn that start at one of them the angles are always the same ones.
        turn = search.exact(search.scene, coordinate - coordinate[0]) / norms
        tried = [(float(zero), turn[:, sense * (np.arange(count) - k) % count]) for k, zero in enumerate(coordinate)]
    else:
        tried = [(given.zero, search.exact(search.scene, sense * (coordinate - given.zero)) / norms)]

    return min((_fit_rotation_and_unit(search, zero, exact) for zero, exact in tried), key=lambda one: one[0])[1]


def _fit_pass_coarsely(search: PathSearch, span: tuple[float, float]) -> FrameFit:
    """Fit the machine's one pass to all parts of the model's travel; return the best fit."""
    begin, end = span
    given, sense, scan, coordinate = search.given, search.sense, search.scan, search.scan.coordinate
    count = round((end - begin) / float(coordinate[1] - coordinate[0]))
    zeros = coordinate[: len(coordinate) - count] - (begin if sense > 0 else -end)
    if given.zero is not None:
        away = np.abs(np.remainder(zeros - given.zero + np.pi, 2.0 * np.pi) - np.pi)
        zeros = np.where(away == away.min(), zeros, np.nan)
    angles: Array = np.asarray(np.linspace(begin, end, count + 1)[::sense], dtype=float)
    exact = search.exact(search.scene, angles)
    tried = []
    for k in np.flatnonzero(np.isfinite(zeros)).tolist():
        rows, zero = slice(k, k + count + 1), float(zeros[k])
        if given.zero is not None:
            zero = given.zero + 2.0 * np.pi * round((zero - given.zero) / (2.0 * np.pi))
        part = replace(scan, coordinate=coordinate[rows], positions=scan.positions[:, rows], turns=scan.turns[:, rows])
        tried.append(_fit_rotation_and_unit(replace(search, scan=part), zero, exact / search.norms))
    # Of a point on a circle every part of the way is alike: the one that needs no rotation is meant.
    least = min(rms for rms, _ in tried)
    alike = [fit for rms, fit in tried if rms <= 2.0 * least + SAME_DISTANCE]
    return min(alike, key=lambda fit: abs(np.remainder(fit.rotation + np.pi, 2.0 * np.pi) - np.pi))


def _fit_rotation_and_unit(search: PathSearch, zero: float, exact: Array) -> tuple[float, FrameFit]:
    """Fit rotation and unit of length to exact paths (P, T); return the rms distance and the fit."""
    given, weighted = search.given, search.paths / search.norms
    factor = complex(np.sum(exact * np.conj(weighted))) / float(np.sum(np.abs(weighted) ** 2))
    rotation = -float(np.angle(factor)) if given.rotation is None else given.rotation
    unit = max(float((factor * np.exp(1j * rotation)).real), 1e-12)
    left = unit * np.exp(-1j * rotation) * weighted - exact
    rms = float(np.sqrt(np.mean(np.abs(left) ** 2)))
    return rms, FrameFit(search, search.scene, rotation, zero, unit, np.zeros(len(left), dtype=complex))
