"""Why a machine that should move cannot: one axis that is tilted, or one anchor that is off, by which it would move.

Linkages that move though their closures hold all their freedoms (planar, spherical, Bennett, Sarrus) do so by parallel
or meeting axes. A slight change of one axis takes that away. It is looked for by closing the loops at several places of
the drives at once, with the axis or the anchor of one joint free as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint, SpatialTree, moved
from conrod.exact.space.closing import jacobian, residuals
from conrod.exact.space.laws import Law
from conrod.exact.space.mobility import check_drives, loose
from conrod.exact.space.motion import DrivenTree
from conrod.exact.space.poses import poses

# Places of the drives, over growing shares of their laws' durations; steps of Gauss and Newton, and their longest.
PLACES, SHARES = 8, (0.01, 0.02, 0.04, 0.08, 0.13, 0.2)
STEPS, LONGEST = 20, 0.3  # [rad, extents]
# A change explains where it leaves this share of what is open without it, and no more than so many times what the best
# one leaves: numbers of six digits leave something, and another change does nearly as well over a short way.
EXPLAINS, AS_WELL = 0.05, 30.0
ROUNDING, STANDS = 1e-13, 1e-14  # of the extent
DAMPING = 0.02
DIFFERENCE = 1e-6  # [rad, or extents], for derivatives by a change
MOST_TURN, MOST_SHIFT = 0.06, 0.02  # [rad, extents], of a slip; what is more is another machine
TOLD = 3  # changes that are named


@dataclass(frozen=True)
class Mend:
    """A change of one joint with which the machine moves.

    Attributes:
        kind: axis or anchor.
        size: angle of the tilt [rad], or how far the anchor is off [m].
    """

    joint: str
    kind: str
    size: float

    @property
    def words(self) -> str:
        """'the axis of rocker is 0.05 deg off'."""
        if self.kind == "axis":
            return f"the axis of {self.joint} is {np.degrees(self.size):.3g} deg off"
        return f"{self.joint} is anchored {1e3 * self.size:.3g} mm off"


def mends(tree: SpatialTree, laws: Mapping[str, Law], held: tuple[str, ...], start: Array) -> list[Mend]:
    """Find the single axes and anchors whose change lets the drives move the machine.

    Args:
        start: closed coordinates (nq, 1), as far as they can be closed.
    """
    machine = DrivenTree(tree, laws, held)
    times = min(law.duration for law in laws.values()) * np.outer(SHARES, np.linspace(0.0, 1.0, PLACES))
    open_by, found = _followed(machine, start, times, None)[0], list[tuple[float, Mend]]()
    for joint in tree.looped:
        for kind in {"hinge": ("axis", "anchor"), "slide": ("axis",)}.get(joint.kind, ()):
            left, change = _followed(machine, start, times, (joint, kind))
            size = float(np.linalg.norm(change))
            if left < EXPLAINS * open_by and size < (MOST_TURN if kind == "axis" else MOST_SHIFT * tree.extent):
                found.append((left, Mend(joint.name, kind, size)))
    least = max(min((left for left, _ in found), default=0.0), ROUNDING * tree.extent)
    return [mend for left, mend in found if left <= AS_WELL * least]


def spare_closures(machine: DrivenTree, start: Array) -> Iterator[str]:
    """Name the closures without each of which the drives move the machine, no more and no fewer than it has freedoms.

    Args:
        start: closed coordinates (nq, 1).
    """
    tree = machine.tree
    for closure in tree.closures if len(tree.closures) > 1 else ():
        rest = tuple(one for one in tree.closures if one is not closure)
        without = DrivenTree(replace(tree, closures=rest), machine.laws, machine.held)
        try:
            check_drives(without, start)
        except InvalidInput:
            continue
        # A link that only this closure holds would be loose.
        if loose(without, start).shape[1] <= loose(machine, start).shape[1]:
            yield closure.name


def mend_words(found: Sequence[Mend]) -> str:
    """Say which change would let a machine move: one, any of several, or that none is known."""
    said = [one.words for one in found[:TOLD]]
    if not found:
        return "no single axis or anchor explains it"
    if len(found) == 1:
        return f"{said[0]}, which alone explains it"
    more = f", or another of {len(found) - TOLD} more" if len(found) > TOLD else ""
    return f"either {' or '.join(said)}{more}: each alone would explain it"


def _followed(
    machine: DrivenTree, start: Array, times: Array, changed: tuple[SpatialJoint, str] | None
) -> tuple[float, Array]:
    """Close the loops at several times at once, over longer and longer ways (W, T), each from the one before it.

    Args:
        changed: joint whose axis is turned [rad], or whose anchor is moved [m], across its axis; None for none.

    Returns:
        What stays open [m], and the change (2,) that was made.
    """
    coordinates, change, before = np.repeat(start, times.shape[1], axis=1), np.zeros(2), np.zeros(times.shape[1])
    left = np.inf
    for way in times:
        if before[-1]:  # on from the last two of the way before
            slope = (coordinates[:, -1:] - coordinates[:, -2:-1]) / (before[-1] - before[-2])
            inside = np.array([np.interp(way, before, row) for row in coordinates])
            coordinates = inside + slope * np.maximum(way - before[-1], 0.0)
        left, change, coordinates = _closed(machine, coordinates, way, changed, change)
        before = way
    return left, change


def _closed(
    machine: DrivenTree, coordinates: Array, times: Array, changed: tuple[SpatialJoint, str] | None, change: Array
) -> tuple[float, Array, Array]:
    """Close the loops at times (T,) by Gauss and Newton: what stays open [m], the change, and coordinates (nq, T)."""
    tree, count = machine.tree, len(times)
    here, best = machine.placed(coordinates, times), (np.inf, change, coordinates)
    size = tree.extent if changed is not None and changed[1] == "anchor" else 1.0
    for number in range(STEPS):
        seen = tree if changed is None else _with_change(tree, *changed, change)
        found = poses(seen, here)
        left = residuals(found, 0)[0]
        gap = float(np.abs(left).max())
        if not np.isfinite(gap):
            break
        if gap < best[0]:
            best = gap, change, here
        matrix = block_diag(*(jacobian(found, count)[:, :, machine.free] * machine.weights))
        open_rows = left.T.ravel()
        if changed is not None:
            # Over a short way a part of the change matters little: its first steps are damped (Levenberg 1944).
            matrix = np.concatenate([matrix, _by_change(tree, *changed, change, here, size)], axis=1)
            damped = np.zeros((2, matrix.shape[1]))
            damped[:, -2:] = DAMPING * 0.5**number * tree.extent * np.eye(2)
            matrix, open_rows = np.concatenate([matrix, damped]), np.concatenate([open_rows, np.zeros(2)])
        step = -np.linalg.lstsq(matrix, open_rows, rcond=1e-9)[0]
        step *= min(1.0, LONGEST * tree.extent / max(float(np.abs(step).max()), 1e-300))
        own = step[: count * len(machine.free)].reshape(count, -1).T
        way = np.zeros((tree.freedom, count))
        way[machine.free] = machine.weights[:, None] * own
        here = moved(tree, here, way)
        change = change + size * step[own.size :] if changed is not None else change
        if np.abs(step).max() < STANDS * tree.extent:
            break
    return best


def _by_change(tree: SpatialTree, joint: SpatialJoint, kind: str, change: Array, here: Array, size: float) -> Array:
    """Derivatives (T rows, 2) of the residuals by a change of a joint, in rad or extents, by central differences."""
    columns = []
    for by in DIFFERENCE * size * np.eye(2):
        ends = [residuals(poses(_with_change(tree, joint, kind, change + s * by), here), 0)[0] for s in (1.0, -1.0)]
        columns.append(((ends[0] - ends[1]) / (2.0 * DIFFERENCE)).T.ravel())
    return np.array(columns).T


def _with_change(tree: SpatialTree, joint: SpatialJoint, kind: str, change: Array) -> SpatialTree:
    """The tree with a joint's axis turned by, or its anchor moved by, two numbers across its axis."""
    across = np.linalg.svd(joint.axis[None])[2][1:]
    if kind == "axis":
        axis = joint.axis + change @ across
        other = replace(joint, axis=axis / np.linalg.norm(axis))
    else:
        other = replace(joint, anchor=joint.anchor + change @ across)
    body = tree.bodies[joint.body]
    joints = tuple(other if one.name == joint.name else one for one in body.joints)
    bodies = list(tree.bodies)
    bodies[joint.body] = replace(body, joints=joints)
    return replace(tree, bodies=tuple(bodies))
