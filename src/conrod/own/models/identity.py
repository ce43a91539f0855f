"""Is a model the machine that it is to be: its frame, its assembly branch and its lengths, from its paths alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.own.models.fitting import Laid, Sighting, relaid
from conrod.own.models.frame import Frame, GivenFrame, View
from conrod.own.models.lengths import Explanation, Search, explanations, without_trace
from conrod.own.models.references import Paths, paths_of, paths_of_kinematics, shaft_of
from conrod.own.models.request import Scan
from conrod.own.models.viewing import check_plane, chosen_view, sighting
from conrod.scenes import Scene

# Nothing is left to explain below this share of a point's travel: what the solution of a model's closures and its
# compilation leave is 1e-12 and less.
EXPLAINED = 1e-9
# A model written with six digits cannot do better.
DEFAULT_TOLERANCE = 1e-6
# What a shape's error is multiplied by where the path is oblique to it.
OBLIQUE = 3.0
ROUND = np.radians([15.0, 1.0])
# A rounded value of the frame is the data's own where it leaves no more than this.
AS_GOOD = 1.05


@dataclass(frozen=True)
class Identity:
    """What a model's paths say.

    Attributes:
        frame: where the document's frame is in the model.
        given: which parts of it were given.
        other_branch: assembled otherwise than the machine; the frame is then that of the other branch.
        angle: crank angles (T,) [rad], increasing.
        off: distance of the points from where they should be, the largest of them, over the point's length (T,).
        off_by: of each point the largest, over its length.
        rate_off: the same of their derivatives by the crank angle; None where a contact places them.
        explanations: sparsest sets of lengths that leave nothing; several where they cannot be told apart.
        closest: the lengths that leave least; None where the wanted ones leave nothing.
        indistinct: groups of lengths that these points cannot tell apart.
        left: largest distance that no length explains.
        floor: what is rounding, or the error of the collision shape.
        scene: the machine with the lengths that were found, or as wanted where none were.
        reference: the other branch's motion, where the model is on it.
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
    scene: Scene
    reference: Kinematics | None

    @property
    def largest(self) -> float:
        """Largest distance of a point from where it should be, over its length."""
        return max(self.off_by.values())

    def is_machine(self, tolerance: float) -> bool:
        """Whether the model is the machine within a tolerance, over the point's length."""
        return not self.other_branch and self.largest <= max(tolerance, self.floor)


def identify(scene: Scene, scan: Scan, given: GivenFrame) -> Identity:
    """What a scan of a model says of it.

    Raises:
        InvalidInput: its plane of motion or its frame cannot be told.
    """
    check_plane(scan)
    points = tuple(scan.positions)
    chosen = chosen_view(scene, scan, points, given)
    seen = sighting(scene, scan, points, chosen.view)
    floor = _floor(scan, seen, chosen.laid.unit)
    search = Search(scene, points, seen, given, floor)
    found: tuple[Explanation, ...] = ()
    closest: Explanation | None = None
    at, best = chosen.laid, scene
    if chosen.kinematics is None and at.largest > floor:
        found, closest = explanations(search, at)
        if found and closest is not None:
            at, best = closest.laid, closest.scene
    paths = paths_of(best, points) if chosen.kinematics is None else paths_of_kinematics(chosen.kinematics, points)
    at = _rounded(at, seen, paths, given, floor)
    groups = without_trace(search, at, best) if chosen.kinematics is None else ()
    wanted = relaid(replace(at, places=0.0 * at.places), seen, paths_of(scene, points)) if found else at
    frame = _frame(chosen.view, at, scan, shaft_of(best.mechanism()))
    order = np.argsort(frame.angle(scan.coordinate))
    return Identity(
        frame=frame,
        given=given,
        other_branch=chosen.kinematics is not None,
        angle=frame.angle(scan.coordinate)[order],
        off=np.abs(wanted.miss).max(axis=0)[order],
        off_by={name: float(np.abs(row).max()) for name, row in zip(points, wanted.miss, strict=True)},
        rate_off=_rate_off(scan, frame, at, seen, best if chosen.kinematics is None else chosen.kinematics),
        explanations=found,
        closest=closest,
        indistinct=groups,
        left=at.largest,
        floor=floor,
        scene=best,
        reference=chosen.kinematics,
    )


def _floor(scan: Scan, seen: Sighting, unit: float) -> float:
    shape = 0.0 if scan.touching is None else OBLIQUE * scan.touching.shape_error
    return max(EXPLAINED, unit * shape / float(seen.lengths.min()))


def _rounded(at: Laid, seen: Sighting, paths: Paths, given: GivenFrame, floor: float) -> Laid:
    """Rotation and crank zero as round numbers, where those leave no more than the fitted ones."""
    # A coarser grid where the data are worse, or some round value would always be near.
    grid = float(ROUND[0] if at.largest > 1e-4 else ROUND[1])
    for name in ("rotation", "zero"):
        if getattr(given, name) is not None:
            at = at.at({name: getattr(given, name)})
            continue
        value = _wrapped(getattr(at, name))
        tried = relaid(at.at({name: _wrapped(grid * float(np.rint(value / grid)))}), seen, paths)
        at = tried if tried.rms <= max(AS_GOOD * at.rms, 1e-2 * floor) else at.at({name: value})
    return relaid(at, seen, paths)


def _wrapped(angle: float) -> float:
    """In (-180, 180] degrees."""
    turn = float(np.remainder(angle, 2.0 * np.pi))
    return turn - 2.0 * np.pi if turn > np.pi + 1e-12 else turn


def _frame(view: View, at: Laid, scan: Scan, shaft: tuple[float, float]) -> Frame:
    anchor = (float(scan.anchor[0]), float(scan.anchor[1]), float(scan.anchor[2]))
    return Frame(view, at.sense, at.rotation, at.zero, at.unit, anchor, shaft)


def _rate_off(scan: Scan, frame: Frame, at: Laid, seen: Sighting, ruler: Scene | Kinematics) -> float | None:
    """Largest error of a point's derivative by the crank angle, over its length, against what was found."""
    if scan.slopes is None:
        return None
    exact, off = ruler.motion(frame.angle(scan.coordinate), 1.0), []
    for k, (name, slope) in enumerate(scan.slopes.items()):
        # A point that is misplaced on its link is carried around by it.
        carried = 1j * frame.view.sense * scan.spins[name] * at.places[k] * seen.links[k]
        found = frame.turned(slope) + np.column_stack([carried.real, carried.imag])
        off.append(np.linalg.norm(frame.sense * found - exact.point(name).velocity, axis=1).max() / seen.lengths[k])
    return float(max(off))
