"""Identification of a model from its paths alone: frame, assembly branch and lengths."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.reference import ExactReference, GenericReference
from conrod.own.models.fitting import FrameFit, ObservedPaths, fit_frame, with_distances
from conrod.own.models.frame import Frame, GivenFrame, View, views
from conrod.own.models.lengths import Explanation, Search, Solution, solutions, without_trace
from conrod.own.models.references import Paths, other_branches, paths_of, shaft_of
from conrod.own.models.request import Scan
from conrod.scenes import Scene

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
        given: which parts of it were given.
        other_branch: assembled otherwise than the machine; the frame is then that of the other branch.
        angle: crank angles (T,) [rad], increasing.
        off: largest distance of a point from where it should be, over the point's length (T,).
        off_by: of each point the largest, over its length.
        rate_off: the same of their derivatives by the crank angle; None where a contact places them.
        explanations: sparsest sets of lengths that leave nothing; several where they cannot be distinguished.
        closest: the lengths that leave least; None where the expected ones leave nothing.
        indistinct: groups of lengths that these points cannot distinguish.
        left: largest distance that no length explains.
        floor: distance that is rounding, or the error of the collision shape.
    """

    frame: Frame
    given: GivenFrame
    other_branch: bool
    angle: Array
    off: Array
    off_by: dict[str, float]
    rate_off: float | None
    explanations: tuple[Explanation, ...]
    closest: Explanation | None
    indistinct: tuple[tuple[str, ...], ...]
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
    check_plane(scan)
    points = tuple(scan.positions)
    chosen = _chosen_view(scene, scan, points, given)
    observed = observed_paths(scene, scan, points, chosen.view)
    floor = _floor(scan, observed, chosen.fit.unit)
    search = Search(scene, points, observed, given, floor)
    found, closest = tuple[Solution, ...](), None
    at, moving = chosen.fit, chosen.branch or scene
    if moving is scene and at.largest > floor:
        found, closest = solutions(search, at)
        if found:
            at, moving = found[0].fit, found[0].scene
    at = _rounded(at, observed, paths_of(moving, points), given, floor)
    expected = at
    if found:
        in_place = replace(at, displacements=0.0 * at.displacements)
        expected = with_distances(in_place, observed, paths_of(scene, points))
    anchor = (float(scan.anchor[0]), float(scan.anchor[1]), float(scan.anchor[2]))
    frame = Frame(chosen.view, at.sense, at.rotation, at.zero, at.unit, anchor, shaft_of(moving))
    order = np.argsort(frame.angle(scan.coordinate))
    identity = Identity(
        frame=frame,
        given=given,
        other_branch=chosen.branch is not None,
        angle=frame.angle(scan.coordinate)[order],
        off=np.abs(expected.distances).max(axis=0)[order],
        off_by={name: float(np.abs(row).max()) for name, row in zip(points, expected.distances, strict=True)},
        rate_off=_rate_off(scan, frame, at, observed, moving),
        explanations=tuple(one.explanation for one in found),
        closest=closest.explanation if closest else None,
        indistinct=without_trace(search, at, moving) if isinstance(moving, Scene) else (),
        left=at.largest,
        floor=floor,
    )
    return identity, moving


def _floor(scan: Scan, observed: ObservedPaths, unit: float) -> float:
    touching = scan.facts.touching
    shape = 0.0 if touching is None else OBLIQUE * touching.shape_error
    return max(EXPLAINED, unit * shape / float(observed.lengths.min()))


def _rounded(at: FrameFit, observed: ObservedPaths, paths: Paths, given: GivenFrame, floor: float) -> FrameFit:
    """Rotation and crank zero as round numbers, where those leave no more than the fitted ones."""
    grid = float(COARSE_GRID if at.largest > 1e-4 else GRID)
    for name in ("rotation", "zero"):
        if getattr(given, name) is not None:
            at = at.at({name: getattr(given, name)})
            continue
        value = _wrapped(getattr(at, name))
        tried = with_distances(at.at({name: _wrapped(grid * float(np.rint(value / grid)))}), observed, paths)
        at = tried if tried.rms <= max(AS_GOOD * at.rms, 1e-2 * floor) else at.at({name: value})
    return with_distances(at, observed, paths)


def _wrapped(angle: float) -> float:
    """In (-180, 180] degrees."""
    turn = float(np.remainder(angle, 2.0 * np.pi))
    return turn - 2.0 * np.pi if turn > np.pi + 1e-12 else turn


def _rate_off(scan: Scan, frame: Frame, at: FrameFit, observed: ObservedPaths, moving: ExactReference) -> float | None:
    """Largest error of a point's derivative by the crank angle, over its length, against what was found."""
    if scan.slopes is None:
        return None
    exact, off = moving.motion(frame.angle(scan.coordinate), 1.0), []
    for k, (name, slope) in enumerate(scan.slopes.items()):
        # A point that is misplaced on its link is carried around by it.
        carried = 1j * frame.view.sense * scan.spins[name] * at.displacements[k] * observed.links[k]
        found = frame.turned(slope) + np.column_stack([carried.real, carried.imag])
        apart = np.linalg.norm(frame.sense * found - exact.point(name).velocity, axis=1)
        off.append(apart.max() / observed.lengths[k])
    return float(max(off))


# -- view and assembly branch ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Candidate:
    """A view of a model with the frame that fits best; `branch` where it is another assembly branch."""

    view: View
    fit: FrameFit
    branch: GenericReference | None


def check_plane(scan: Scan) -> None:
    """Refuse a model whose points do not move in one plane across the crank's axis."""
    span = max(float(np.ptp(p, axis=0).max()) for p in scan.positions.values())
    if span == 0.0 or not np.isfinite(span):
        named = ", ".join(scan.positions)
        raise InvalidInput(f"the crank turns and nothing moves, of {named}: the plane cannot be determined")
    if scan.wander > IN_PLANE * max(span, 1.0):
        raise InvalidInput(
            f"the crank's axis itself moves, by {scan.wander:.3g} (of the model's unit of length) in a turn: there is "
            "no plane of motion; the crank is to turn about a fixed axis"
        )
    for name, positions in scan.positions.items():
        away = float(np.ptp(positions @ scan.axis))
        if away > IN_PLANE * span:
            raise InvalidInput(
                f"{name} leaves the plane across the crank's axis by {away:.3g} (of the model's unit of length): the "
                "plane of motion cannot be determined"
            )


def _chosen_view(scene: Scene, scan: Scan, points: tuple[str, ...], given: GivenFrame) -> _Candidate:
    """View and assembly branch of the model: the machine's own branch unless another one is clearly nearer."""
    turns = scene.mechanism().driver.sense
    observed = {view: observed_paths(scene, scan, points, view) for view in views(scan.axis, turns, given.plane)}

    def best(branch: GenericReference | None) -> _Candidate:
        paths = paths_of(branch or scene, points)
        tried = [
            _Candidate(view, fit_frame(one, paths, view.sense * turns, given), branch) for view, one in observed.items()
        ]
        least = min(one.fit.rms for one in tried)
        return next(one for one in tried if one.fit.rms <= ALIKE * least + NOTHING)

    own = best(None)
    if own.fit.largest <= NEAR:
        return own
    other = min(map(best, other_branches(scene)), key=lambda one: one.fit.rms, default=own)
    return other if other.fit.rms < CLEARLY_BETTER * own.fit.rms else own


def observed_paths(scene: Scene, scan: Scan, points: tuple[str, ...], view: View) -> ObservedPaths:
    """A scan's points in a view."""
    paths = np.array([view.flat(scan.positions[name] - scan.anchor) for name in points])
    links = np.exp(1j * view.sense * np.array([scan.turns[name] for name in points]))
    return ObservedPaths(scan.coordinate, paths, np.array([scene.lengths[name] for name in points]), links)
