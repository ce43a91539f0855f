"""Kennedy's construction: the instant centres of a linkage from its pins, slides and common normals alone.

No velocity enters, so that it is a second way to the centres, as the circle diagram of document 001, section 3.7.
Where three links have two known centres, the third lies on the line through them; where two such lines cross, it is
found. Points and lines are those of the projective plane, so that a slide's centre at infinity is a point like others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from conrod.exact.joint_equations import active_arcs, pose_jets
from conrod.exact.linkage.centres import Pair, joint_centre, primary_joints
from conrod.exact.linkage.state import LinkageState, link_numbers
from conrod.exact.motion import Array
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import CamContact

# The sine under which two lines count as one: beyond, their crossing would be rounding.
PARALLEL = 1e-6


@dataclass(frozen=True)
class Construction:
    """Result of the construction.

    Attributes:
        centres: of each pair of links that it reaches, (x, y, 1) [m], or (x, y, 0) of length 1 at infinity; (3,).
        steps: the pairs in the order in which they were found, each with the two links whose lines crossed there; the
            pairs that a joint gives come first, with none.
    """

    centres: Mapping[Pair, Array]
    steps: tuple[tuple[Pair, tuple[str, ...]], ...]
    missing: tuple[Pair, ...]  # pairs that no two lines give; an auxiliary line or the velocities have to


def construct(state: LinkageState) -> Construction:
    """Kennedy's construction in the pose of a state; its velocities are not read."""
    work = _Work(state)
    names = list(link_numbers(state.mechanism))
    pairs = [frozenset(pair) for pair in combinations(names, 2)]
    found = True
    while found:
        found = False
        for pair in pairs:
            if pair not in work.points and work.cross(pair, names):
                found = True
    centres = {pair: work.in_metres(point) for pair, point in work.points.items()}
    return Construction(centres, tuple(work.steps), tuple(pair for pair in pairs if pair not in work.points))


class _Work:
    """Centres found so far, of length 1, with places in units of the mechanism's size."""

    def __init__(self, state: LinkageState) -> None:
        self._state, self._size = state, state.size
        self.points: dict[Pair, Array] = {}
        self._lines: dict[Pair, Array] = {}
        self.steps: list[tuple[Pair, tuple[str, ...]]] = []
        for pair, (_, joint) in sorted(primary_joints(state.mechanism).items(), key=lambda item: sorted(item[0])):
            centre = joint_centre(state, joint)
            assert centre is not None
            self.points[pair] = self._point(centre)
            self.steps.append((pair, ()))
        for contact in state.mechanism.cam_contacts:
            roller = state.links[contact.b].place(contact.roller_centre)
            inside, wheel = (self._point(np.array([*place, 1.0])) for place in (self._on_normal(contact), roller))
            self._lines[frozenset((contact.a, contact.b))] = _unit(np.cross(inside, wheel))

    def _on_normal(self, joint: CamContact) -> Array:
        """A point on the common normal of cam and roller: the arc's centre, or as far from the roller as the shaft."""
        cam, profile = self._state.links[joint.a], joint.profile
        if isinstance(profile, LawProfile):
            x, y = cam.own(self._state.links[joint.b].place(joint.roller_centre))
            angle = profile.law_angle(np.array([x]), np.array([y]))
            inwards = profile.prime_radius * profile.pitch(angle).normals[0]
            return cam.place((float(x - inwards[0]), float(y - inwards[1])))
        bodies = pose_jets(self._state.mechanism, [self._state.derivatives[0]])
        cx, cy, _ = profile.arc_geometry(active_arcs(joint, bodies))
        return cam.place((float(np.squeeze(cx)), float(np.squeeze(cy))))

    def _point(self, centre: Array) -> Array:
        x, y, w = centre
        return _unit(np.array([x / self._size, y / self._size, w]) if w != 0.0 else centre)

    def cross(self, pair: Pair, names: list[str]) -> bool:
        """Look for the two lines that cross best at a pair's centre."""
        lines = {"": self._lines[pair]} if pair in self._lines else {}
        first, second = sorted(pair)
        for third in names:
            ends = [self.points.get(frozenset((third, one))) for one in (first, second)]
            if third in pair or ends[0] is None or ends[1] is None:
                continue
            line = np.cross(ends[0], ends[1])
            if np.linalg.norm(line) > PARALLEL:
                lines[third] = _unit(line)
        best, through = PARALLEL, None
        for one, other in combinations(lines, 2):
            sine = float(np.linalg.norm(np.cross(lines[one], lines[other])))
            if sine > best:
                best, through = sine, (one, other)
        if through is None:
            return False
        self.points[pair] = _unit(np.cross(lines[through[0]], lines[through[1]]))
        self.steps.append((pair, tuple(name for name in through if name)))
        return True

    def in_metres(self, point: Array) -> Array:
        """A centre as `InstantCentre.homogeneous` has it, to rounding."""
        if abs(point[2]) < 1e-13:
            return np.array([*point[:2] / np.linalg.norm(point[:2]), 0.0])
        return np.array([*self._size * point[:2] / point[2], 1.0])


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
