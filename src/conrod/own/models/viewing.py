"""From which side a model is to be looked at, and on which assembly branch it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.kinematics import Kinematics
from conrod.own.models.fitting import Laid, Sighting, laid
from conrod.own.models.frame import GivenFrame, View, views
from conrod.own.models.references import Paths, other_branches, paths_of, paths_of_kinematics
from conrod.own.models.request import Scan
from conrod.scenes import Scene

# A point that leaves the plane by more than this share of the machine's travel is not in it.
IN_PLANE = 1e-6
# Of several views that fit alike the first is meant.
ALIKE = 2.0
# The other branch is meant where it leaves so little of what the own one does.
CLEARLY_BETTER = 0.1
# Beside this no difference of two fits counts.
NOTHING = 1e-9
# What is as near as this is the machine with lengths a little off, and no other view or branch of it is looked for.
NEAR = 1e-3


@dataclass(frozen=True)
class Candidate:
    """A view of a model with the frame that fits best; `kinematics` is of another assembly branch, where it is."""

    view: View
    laid: Laid
    kinematics: Kinematics | None


def check_plane(scan: Scan) -> None:
    """Refuse a model whose points do not move in one plane across the crank's axis."""
    span = max(float(np.ptp(p, axis=0).max()) for p in scan.positions.values())
    if span == 0.0 or not np.isfinite(span):
        named = ", ".join(scan.positions)
        raise InvalidInput(f"the crank turns and nothing moves, of {named}: the plane cannot be told")
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
                "plane of motion cannot be told"
            )


def chosen_view(scene: Scene, scan: Scan, points: tuple[str, ...], given: GivenFrame) -> Candidate:
    """How to look at the model, and which branch it is on: the machine's own unless another one is clearly nearer."""
    some = views(scan.axis, scene.mechanism().driver.sense, given.plane)

    def best(kinematics: Kinematics | None) -> Candidate:
        paths = paths_of(scene, points) if kinematics is None else paths_of_kinematics(kinematics, points)
        tried = [Candidate(v, _laid(scene, scan, points, v, paths, given), kinematics) for v in some]
        least = min(c.laid.rms for c in tried)
        return next(c for c in tried if c.laid.rms <= ALIKE * least + NOTHING)

    own = best(None)
    if own.laid.largest <= NEAR:
        return own
    others = [best(kinematics) for kinematics in other_branches(scene)]
    other = min(others, key=lambda c: c.laid.rms, default=own)
    return other if other.laid.rms < CLEARLY_BETTER * own.laid.rms else own


def _laid(scene: Scene, scan: Scan, points: tuple[str, ...], view: View, paths: Paths, given: GivenFrame) -> Laid:
    sense = view.sense * scene.mechanism().driver.sense
    return laid(sighting(scene, scan, points, view), paths, sense, given)


def sighting(scene: Scene, scan: Scan, points: tuple[str, ...], view: View) -> Sighting:
    """What is seen of a scan in a view."""
    paths = np.array([view.flat(scan.positions[name] - scan.anchor) for name in points])
    links = np.exp(1j * view.sense * np.array([scan.turns[name] for name in points]))
    return Sighting(scan.coordinate, paths, np.array([scene.lengths[name] for name in points]), links)
