"""Identify a model from its paths alone: frame, assembly branch and lengths."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain, combinations
from math import comb
from types import MappingProxyType
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.kinematics import ExactReference, GenericReference
from conrod.mjcf.request import Scan
from conrod.models.check.fitting import FrameFit, PathSearch, fit_frame
from conrod.models.check.frame import Frame, GivenFrame, PlaneView, candidate_views
from conrod.models.check.references import (
    ALL_LENGTHS,
    length_names,
    length_of,
    other_branches,
    returns_after_turn,
    shaft_of,
    with_branch_of,
)
from conrod.scenes import Scene

MAX_CHANGES = 3
# Sets of one size are tried up to so many: each is a fit, and a mechanism file has dozens of lengths.
MAX_CHANGE_SETS = 150


@dataclass(frozen=True)
class FoundLength:
    """One length as expected and as found in the model [m]; for `ALL_LENGTHS` the common factor."""

    name: str
    expected: float
    found: float

    @property
    def excess(self) -> float | None:
        """Relative excess over the expected length; None if that is zero."""
        return None if self.expected == 0.0 else self.found / self.expected - 1.0


@dataclass(frozen=True)
class MisplacedPoint:
    """An observed point that is not where it should be on its link, and its distance from there [m]."""

    point: str
    away: float


@dataclass(frozen=True)
class Explanation:
    """Changed lengths and misplaced points that make the exact paths match the model's.

    Attributes:
        left: largest distance that they leave, over the point's length.
    """

    lengths: tuple[FoundLength, ...]
    misplaced: tuple[MisplacedPoint, ...]
    left: float


# Lengths, and points, that are not as expected.
ChangeSet = tuple[tuple[str, ...], tuple[str, ...]]


def smallest_explanations(
    start: FrameFit, floor: float, *, first_only: bool = False
) -> list[tuple[Explanation, FrameFit]]:
    """Find the smallest sets of changes that leave no distance; all that are of one size.

    Args:
        start: the frame that the expected lengths fit best.
        floor: a distance, over the point's length, that is nothing.
        first_only: whether the first one is enough, which is the same as of all.
    """
    for changes in _change_sets(start.search):
        enough = list[tuple[Explanation, FrameFit]]()
        for change in changes:
            if (one := _fit_change(start, change)) is not None and one[0].left <= floor:
                enough.append(one)
                if first_only and not one[0].misplaced:
                    return enough[-1:]
        if enough:
            return sorted(enough, key=lambda one: len(one[0].misplaced))
    return []


def _change_sets(search: PathSearch) -> Iterator[list[ChangeSet]]:
    """Yield sets of changed lengths and misplaced points to try, by growing size; last, all lengths."""
    single: list[ChangeSet] = [((name,), ()) for name in length_names(search.scene)]
    single += [((), (point,)) for point in search.scan.points]
    for count in range(1, MAX_CHANGES + 1):
        if count > 1 and comb(len(single), count) > MAX_CHANGE_SETS:
            break
        together = (tuple(zip(*some, strict=True)) for some in combinations(single, count))
        yield [(tuple(chain(*lengths)), tuple(chain(*points))) for lengths, points in together]
    yield [(search.lengths, ())]


def _fit_change(start: FrameFit, change: ChangeSet) -> tuple[Explanation, FrameFit] | None:
    """Fit a set of changes together with the free parts of the frame; None if that leads to no machine."""
    (names, points), search, expected = change, start.search, start.search.scene
    try:
        there = start.refine(names, points)
    except InvalidInput:
        return None
    scene: Any = there.machine
    away = dict(zip(search.scan.points, np.abs(there.displacements).tolist(), strict=True))
    others = [n for n in search.lengths if n not in names and length_of(expected, n) != 0.0]
    factor = length_of(scene, others[0]) / length_of(expected, others[0]) if others else 1.0
    found = {name: factor if name == ALL_LENGTHS else length_of(scene, name) for name in names}
    lengths = tuple(FoundLength(name, length_of(expected, name), value) for name, value in found.items())
    misplaced = tuple(MisplacedPoint(point, away[point]) for point in points)
    return Explanation(lengths, misplaced, there.largest), there


# Nothing is left to explain below this share of a point's travel: what the solution of a model's closures and its
# compilation leave is 1e-12 and less.
EXPLAINED_DISTANCE = 1e-9
# A model written with six digits cannot do better.
DEFAULT_TOLERANCE = 1e-6
# A shape's error is multiplied by this where the path is oblique to it.
OBLIQUITY_FACTOR = 3.0
# A point that leaves the plane by more than this share of the machine's travel is not in it.
PLANE_TOLERANCE = 1e-6
# Of several views that fit alike, by this factor and beside this distance, the first is meant.
ALIKE_FACTOR, NO_DISTANCE = 2.0, 1e-9
# The other branch is meant where it leaves so little of what the own one does.
OTHER_BRANCH_FACTOR = 0.1
# Within this distance it is the machine with lengths a little off, and no other view or branch of it is looked for.
OWN_BRANCH_DISTANCE = 1e-3
# Grids of round angles: the coarser one where the data are worse, or some round value would always be near.
COARSE_GRID, GRID = np.radians([15.0, 1.0])
# A rounded value of the frame is the data's own where it leaves no more than this.
MAX_ROUNDING_LOSS = 1.05


@dataclass(frozen=True)
class Identity:
    """The identity of a model by its paths: frame, branch, and lengths that differ.

    Attributes:
        frame: the document's frame in the model.
        other_branch: whether the model is on another assembly branch; `frame` then fits this branch.
        off_by: largest distance of each point from its exact position, over its length.
        explanations: smallest sets of changes that leave no distance; several if they cannot be distinguished.
        left: largest distance that no change explains.
        floor: distance below which rounding, or the error of the collision shape, explains all.
    """

    frame: Frame
    other_branch: bool
    off_by: dict[str, float]
    explanations: tuple[Explanation, ...]
    left: float
    floor: float

    @property
    def largest(self) -> float:
        """Largest distance of a point from its exact position, over the point's length."""
        return max(self.off_by.values(), default=math.inf)

    def is_machine(self, tolerance: float, weights: Mapping[str, float] = MappingProxyType({})) -> bool:
        """True if the model is the machine within a tolerance, relative to each point's length.

        Args:
            weights: of each point's distance, for a tolerance given in units; 1 where none is given.
        """
        largest = max(size * weights.get(point, 1.0) for point, size in self.off_by.items())
        return not self.other_branch and largest <= max(tolerance, self.floor)


def unknown_identity(unit: float) -> Identity:
    """Identity of a model that has no paths, with lengths in a unit [m]: no point is placed, nothing explains it."""
    frame = Frame(PlaneView("xy", (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 1), 1, 0.0, 0.0, unit, (0.0, 0.0, 0.0), (0.0, 0.0))
    return Identity(frame, False, {}, (), 0.0, 0.0)


# Whatever the frame, some point is off by at least the root mean square of the best fit, which is found to far less.
CLEARLY_OFF_FACTOR = 2.0


def is_machine(scene: Scene, scan: Scan, given: GivenFrame, tolerance: float) -> bool:
    """True if the identity of a scan (`identify`) is the machine within a tolerance, with less work where it is not.

    Raises:
        InvalidInput: as `identify`.
    """
    _check_plane(scan)
    at = _fit_best_branch(scene, scan, given)
    if at.search.branch is not None or at.rms > CLEARLY_OFF_FACTOR * max(tolerance, _floor(at)):
        return False
    return _identity_at(at, scene, scan, first_only=True)[0].is_machine(tolerance)


def identify(scene: Scene, scan: Scan, given: GivenFrame) -> tuple[Identity, ExactReference]:
    """Identify a model from a scan of its paths.

    Returns:
        Its identity, and the machine that moves as it does: with the lengths that were found, on its branch.

    Raises:
        InvalidInput: its plane of motion or its frame cannot be determined.
    """
    _check_plane(scan)
    return _identity_at(_fit_best_branch(scene, scan, given), scene, scan)


def _floor(at: FrameFit) -> float:
    """Distance, over the point's length, below which rounding or the error of the collision shape explains all."""
    return max(
        EXPLAINED_DISTANCE, at.unit * OBLIQUITY_FACTOR * at.search.scan.shape_error / float(at.search.norms.min())
    )


def _identity_at(
    at: FrameFit, scene: Scene, scan: Scan, *, first_only: bool = False
) -> tuple[Identity, ExactReference]:
    """Return identity and machine as `identify` does, from the best fit; `first_only`: of explanations the first."""
    search, found, floor = at.search, list[tuple[Explanation, FrameFit]](), _floor(at)
    if at.largest > floor and (found := smallest_explanations(at, floor, first_only=first_only)):
        at = found[0][1]
        if isinstance(at.machine, Scene):  # and not as exact as a fit needs it
            at = replace(at, machine=at.machine.with_parameters())
    at = _round_frame(at, floor)
    expected = replace(at, machine=scene, displacements=0.0 * at.displacements)
    # The same machine of those lengths, as it is assembled in the model.
    machine = with_branch_of(at.machine, search.branch)
    x, y, z = scan.anchor.tolist()
    frame = Frame(search.view, search.sense, at.rotation, at.zero, at.unit, (x, y, z), shaft_of(machine))
    identity = Identity(
        frame=frame,
        other_branch=search.branch is not None,
        off_by=dict(zip(scan.points, np.abs(expected.distances).max(axis=1).tolist(), strict=True)),
        explanations=tuple(one for one, _ in found),
        left=at.largest,
        floor=floor,
    )
    return identity, machine


def _round_frame(at: FrameFit, floor: float) -> FrameFit:
    """Round rotation and crank zero to whole degrees where that fits as well."""
    grid = float(COARSE_GRID if at.largest > 1e-4 else GRID)
    for name in ("rotation", "zero"):
        given = getattr(at.search.given, name)
        # Where turns differ, or there is one pass, a turn more or less is another place.
        wrapped = _wrap_angle if name == "rotation" or returns_after_turn(at.search.scene) else float
        value: Any = wrapped(getattr(at, name)) if given is None else getattr(at, name)
        round_value: Any = wrapped(grid * float(np.rint(value / grid)))
        rounded = replace(at, **{name: round_value})
        is_round = given is None and rounded.rms <= max(MAX_ROUNDING_LOSS * at.rms, 1e-2 * floor)
        at = rounded if is_round else replace(at, **{name: value})
    return at


def _wrap_angle(angle: float) -> float:
    """Wrap an angle to (-180, 180] deg [rad]."""
    turn = float(np.remainder(angle, 2.0 * np.pi))
    return turn - 2.0 * np.pi if turn > np.pi + 1e-12 else turn


def _check_plane(scan: Scan) -> None:
    """Refuse a model whose points do not move in one plane across the crank's axis."""
    span, unit = float(np.ptp(scan.positions, axis=1).max()), "(of the model's unit of length)"
    if span == 0.0 or not np.isfinite(span):
        named = ", ".join(scan.points)
        raise InvalidInput(f"the crank turns and nothing moves, of {named}: the plane cannot be determined")
    if scan.wander > PLANE_TOLERANCE * max(span, 1.0):
        raise InvalidInput(
            f"the crank's axis itself moves, by {scan.wander:.3g} {unit} in a turn: there is no plane of motion; the "
            "crank is to turn about a fixed axis"
        )
    for name, positions in zip(scan.points, scan.positions, strict=True):
        away = float(np.ptp(positions @ scan.axis))
        if away > PLANE_TOLERANCE * span:
            raise InvalidInput(
                f"{name} leaves the plane across the crank's axis by {away:.3g} {unit}: the plane of motion cannot be "
                "determined"
            )


def _fit_best_branch(scene: Scene, scan: Scan, given: GivenFrame) -> FrameFit:
    """Fit view and assembly branch: the machine's own branch unless another is clearly nearer."""
    seen_from = candidate_views(scan.axis, scene.mechanism().driver.sense, given.plane)

    def best(branch: GenericReference | None) -> FrameFit:
        tried, refused = list[FrameFit](), list[InvalidInput]()
        for view in seen_from:
            try:
                tried.append(fit_frame(PathSearch(scene, scan, view, given, branch)))
            except InvalidInput as error:  # of one pass, seen from the wrong side a given zero lies out of reach
                refused.append(error)
        if not tried:
            raise refused[0]
        least = min(fit.rms for fit in tried)
        return next(fit for fit in tried if fit.rms <= ALIKE_FACTOR * least + NO_DISTANCE)

    own = best(None)
    if own.largest <= OWN_BRANCH_DISTANCE:
        return own
    other = min(map(best, other_branches(scene)), key=lambda one: one.rms, default=own)
    return other if other.rms < OTHER_BRANCH_FACTOR * own.rms else own
