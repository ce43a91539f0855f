"""Identification of a model from its paths alone: frame, assembly branch and lengths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, combinations
from math import comb
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact import ExactReference, GenericReference
from conrod.own.models.fitting import Fit, Search, fit_frame
from conrod.own.models.frame import Frame, GivenFrame, views
from conrod.own.models.references import (
    ALL_LENGTHS,
    length_names,
    length_of,
    on_branch,
    other_branches,
    returns,
    shaft_of,
)
from conrod.own.models.request import Scan
from conrod.scenes import Scene

MOST_TOGETHER = 3
# Sets of one size are tried up to so many: each is a fit, and a mechanism file has dozens of lengths.
MOST_SETS = 150


@dataclass(frozen=True)
class Length:
    """One length as it is expected and as it is found [m]; of all lengths together the factor."""

    name: str
    expected: float
    found: float

    @property
    def excess(self) -> float | None:
        """Share by which it is too long; None for one that is expected to be zero."""
        return None if self.expected == 0.0 else self.found / self.expected - 1.0


@dataclass(frozen=True)
class Misplaced:
    """An observed point that is not where it should be on its link, and how far from there [m]."""

    point: str
    away: float


@dataclass(frozen=True)
class Explanation:
    """Lengths and places with which the exact paths lie over those of the model.

    Attributes:
        left: largest distance that they leave, over the point's length.
    """

    lengths: tuple[Length, ...]
    misplaced: tuple[Misplaced, ...]
    left: float


# Lengths, and points, that are not as expected.
Change = tuple[tuple[str, ...], tuple[str, ...]]


def solutions(start: Fit, floor: float) -> list[tuple[Explanation, Fit]]:
    """The smallest sets of changes that leave nothing, all of one size.

    Args:
        start: the frame that the expected lengths fit best.
        floor: a distance, over the point's length, that is nothing.
    """
    for changes in _changes(start.search):
        found = [one for change in changes if (one := _solved(start, change)) is not None]
        if enough := [one for one in found if one[0].left <= floor]:
            return sorted(enough, key=lambda one: len(one[0].misplaced))
    return []


def _changes(search: Search) -> Iterator[list[Change]]:
    """Sets of changes, more and more together; all lengths at last."""
    single: list[Change] = [((name,), ()) for name in length_names(search.scene)]
    single += [((), (point,)) for point in search.scan.points]
    for count in range(1, MOST_TOGETHER + 1):
        if count > 1 and comb(len(single), count) > MOST_SETS:
            break
        together = (tuple(zip(*some, strict=True)) for some in combinations(single, count))
        yield [(tuple(chain(*lengths)), tuple(chain(*points))) for lengths, points in together]
    yield [(search.lengths, ())]


def _solved(start: Fit, change: Change) -> tuple[Explanation, Fit] | None:
    """A change with the free parts of the frame, fitted; None where that leads to no machine."""
    (names, points), search, expected = change, start.search, start.search.scene
    try:
        there = start.refined(names, points)
    except InvalidInput:
        return None
    scene: Any = there.machine
    away = dict(zip(search.scan.points, np.abs(there.displacements).tolist(), strict=True))
    others = [n for n in search.lengths if n not in names and length_of(expected, n) != 0.0]
    factor = length_of(scene, others[0]) / length_of(expected, others[0]) if others else 1.0
    found = {name: factor if name == ALL_LENGTHS else length_of(scene, name) for name in names}
    lengths = tuple(Length(name, length_of(expected, name), value) for name, value in found.items())
    misplaced = tuple(Misplaced(point, away[point]) for point in points)
    return Explanation(lengths, misplaced, there.largest), there


# Nothing is left to explain below this share of a point's travel: what the solution of a model's closures and its
# compilation leave is 1e-12 and less.
EXPLAINED = 1e-9
# A model written with six digits cannot do better.
DEFAULT_TOLERANCE = 1e-6
# A shape's error is multiplied by this where the path is oblique to it.
OBLIQUE = 3.0
# A point that leaves the plane by more than this share of the machine's travel is not in it.
IN_PLANE = 1e-6
# Of several views that fit alike, by this factor and beside this distance, the first is meant.
ALIKE, NOTHING = 2.0, 1e-9
# The other branch is meant where it leaves so little of what the own one does.
CLEARLY_BETTER = 0.1
# Within this distance it is the machine with lengths a little off, and no other view or branch of it is looked for.
NEAR = 1e-3
# Grids of round angles: the coarser one where the data are worse, or some round value would always be near.
COARSE_GRID, GRID = np.radians([15.0, 1.0])
# A rounded value of the frame is the data's own where it leaves no more than this.
AS_GOOD = 1.05


@dataclass(frozen=True)
class Identity:
    """A model by its paths.

    Attributes:
        frame: the document's frame in the model.
        other_branch: assembled otherwise than the machine; the frame is then that of the other branch.
        off_by: largest distance of each point from where it should be, over its length.
        explanations: sparsest sets of lengths that leave nothing; several where they cannot be distinguished.
        left: largest distance that no length explains.
        floor: distance that is rounding, or the error of the collision shape.
    """

    frame: Frame
    other_branch: bool
    off_by: dict[str, float]
    explanations: tuple[Explanation, ...]
    left: float
    floor: float

    @property
    def largest(self) -> float:
        """Largest distance of a point from where it should be, over its length."""
        return max(self.off_by.values())

    def is_machine(self, tolerance: float) -> bool:
        """True if the model is the machine within a tolerance, over the point's length."""
        return not self.other_branch and self.largest <= max(tolerance, self.floor)


def identify(scene: Scene, scan: Scan, given: GivenFrame) -> tuple[Identity, ExactReference]:
    """Identify a model by a scan of it.

    Returns:
        Its identity, and the machine that moves as it does: with the lengths that were found, on its branch.

    Raises:
        InvalidInput: its plane of motion or its frame cannot be determined.
    """
    _check_plane(scan)
    at = _chosen(scene, scan, given)
    search, found = at.search, list[tuple[Explanation, Fit]]()
    floor = max(EXPLAINED, at.unit * OBLIQUE * scan.shape_error / float(search.norms.min()))
    if at.largest > floor and (found := solutions(at, floor)):
        at = found[0][1]
    at = _rounded(at, floor)
    expected = replace(at, machine=scene, displacements=0.0 * at.displacements)
    # The same machine of those lengths, as it is assembled in the model.
    machine = on_branch(at.machine, search.branch)
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


def _rounded(at: Fit, floor: float) -> Fit:
    """Rotation and crank zero as round numbers, where those leave no more than the fitted ones."""
    grid = float(COARSE_GRID if at.largest > 1e-4 else GRID)
    for name in ("rotation", "zero"):
        given = getattr(at.search.given, name)
        # Where turns differ, or there is one pass, a turn more or less is another place.
        wrapped = _wrapped if name == "rotation" or returns(at.search.scene) else float
        value: Any = wrapped(getattr(at, name)) if given is None else getattr(at, name)
        round_value: Any = wrapped(grid * float(np.rint(value / grid)))
        rounded = replace(at, **{name: round_value})
        is_round = given is None and rounded.rms <= max(AS_GOOD * at.rms, 1e-2 * floor)
        at = rounded if is_round else replace(at, **{name: value})
    return at


def _wrapped(angle: float) -> float:
    """In (-180, 180] degrees."""
    turn = float(np.remainder(angle, 2.0 * np.pi))
    return turn - 2.0 * np.pi if turn > np.pi + 1e-12 else turn


def _check_plane(scan: Scan) -> None:
    """Refuse a model whose points do not move in one plane across the crank's axis."""
    span, unit = float(np.ptp(scan.positions, axis=1).max()), "(of the model's unit of length)"
    if span == 0.0 or not np.isfinite(span):
        named = ", ".join(scan.points)
        raise InvalidInput(f"the crank turns and nothing moves, of {named}: the plane cannot be determined")
    if scan.wander > IN_PLANE * max(span, 1.0):
        raise InvalidInput(
            f"the crank's axis itself moves, by {scan.wander:.3g} {unit} in a turn: there is no plane of motion; the "
            "crank is to turn about a fixed axis"
        )
    for name, positions in zip(scan.points, scan.positions, strict=True):
        away = float(np.ptp(positions @ scan.axis))
        if away > IN_PLANE * span:
            raise InvalidInput(
                f"{name} leaves the plane across the crank's axis by {away:.3g} {unit}: the plane of motion cannot be "
                "determined"
            )


def _chosen(scene: Scene, scan: Scan, given: GivenFrame) -> Fit:
    """View and assembly branch of the model: the machine's own branch unless another one is clearly nearer."""
    seen_from = views(scan.axis, scene.mechanism().driver.sense, given.plane)

    def best(branch: GenericReference | None) -> Fit:
        tried = [fit_frame(Search(scene, scan, view, given, branch)) for view in seen_from]
        least = min(fit.rms for fit in tried)
        return next(fit for fit in tried if fit.rms <= ALIKE * least + NOTHING)

    own = best(None)
    if own.largest <= NEAR:
        return own
    other = min(map(best, other_branches(scene)), key=lambda one: one.rms, default=own)
    return other if other.rms < CLEARLY_BETTER * own.rms else own
