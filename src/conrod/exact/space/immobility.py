"""Diagnosis of a machine that should move and cannot: the one tilted axis or misplaced anchor that blocks it.

Linkages that move although their closures take all their freedoms (planar, spherical, Bennett, Sarrus) need parallel or
meeting axes, and a slight error of one axis blocks them. The error is found by closing the loops at several drive
positions at once, with the axis or the anchor of one joint free as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint, SpatialTree, displace
from conrod.exact.space.drive_laws import DriveLaw
from conrod.exact.space.forward_kinematics import Poses, forward_kinematics
from conrod.exact.space.loop_closure import jacobian, residuals
from conrod.exact.space.mobility import check_drives, free_directions
from conrod.exact.space.motion import DrivenTree

# Positions of the drives at which loops are closed at once, over growing shares of the laws' durations.
DRIVE_PLACES, DURATION_SHARES = 8, (0.01, 0.02, 0.04, 0.08, 0.13, 0.2)
MAX_GAUSS_NEWTON_STEPS, MAX_STEP = 20, 0.3  # [rad, extents]
# A correction explains the immobility if it leaves at most `EXPLAINED_SHARE` of the violation without it, and at most
# `MAX_RATIO_TO_BEST` times that of the best correction: numbers of six digits leave some violation, and over a short
# motion another correction does nearly as well.
EXPLAINED_SHARE, MAX_RATIO_TO_BEST = 0.05, 30.0
ROUNDING, STEP_TOLERANCE = 1e-13, 1e-14  # of the extent
DAMPING = 0.02
DIFFERENCE_STEP = 1e-6  # [rad, or extents], of central differences
# A correction, and those on both sides of it in each of its two numbers, in steps.
SIDES = np.array([(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
MAX_TILT, MAX_SHIFT = 0.06, 0.02  # [rad, extents] of a slip; more would be another machine
MAX_NAMED_CORRECTIONS = 3  # corrections in a message


@dataclass(frozen=True)
class JointCorrection:
    """A correction of one joint with which the machine moves.

    Attributes:
        kind: axis or anchor.
        size: angle of the tilt [rad], or error of the anchor [m].
    """

    joint: str
    kind: str
    size: float

    @property
    def words(self) -> str:
        """Phrase for an error message: 'the axis of rocker is 0.05 deg off'."""
        if self.kind == "axis":
            return f"the axis of {self.joint} is {np.degrees(self.size):.3g} deg off"
        return f"{self.joint} is anchored {1e3 * self.size:.3g} mm off"


def explain_immobility(
    tree: SpatialTree, laws: Mapping[str, DriveLaw], held: tuple[str, ...], start: Array
) -> list[JointCorrection]:
    """Find the single axes and anchors whose correction lets the drives move the machine.

    Args:
        start: closed coordinates (nq, 1), as far as they can be closed.
    """
    machine = DrivenTree(tree, laws, held)
    times = min(law.duration for law in laws.values()) * np.outer(DURATION_SHARES, np.linspace(0.0, 1.0, DRIVE_PLACES))
    open_by, found = _close_along_motion(machine, start, times, None)[0], list[tuple[float, JointCorrection]]()
    for joint in tree.loop_joints:
        for kind in {"hinge": ("axis", "anchor"), "slide": ("axis",)}.get(joint.kind, ()):
            left, change = _close_along_motion(machine, start, times, (joint, kind))
            size = float(np.linalg.norm(change))
            if left < EXPLAINED_SHARE * open_by and size < (MAX_TILT if kind == "axis" else MAX_SHIFT * tree.extent):
                found.append((left, JointCorrection(joint.name, kind, size)))
    least = max(min((left for left, _ in found), default=0.0), ROUNDING * tree.extent)
    return [mend for left, mend in found if left <= MAX_RATIO_TO_BEST * least]


def removable_closures(machine: DrivenTree, start: Array) -> Iterator[str]:
    """Yield names of closures without which the drives would move the machine, and no link would be loose.

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
        # Without more freedoms than before: a link that only this closure holds would be loose.
        if free_directions(without, start).shape[1] <= free_directions(machine, start).shape[1]:
            yield closure.name


def removable_words(machine: DrivenTree, start: Array) -> str:
    """Say without which closures a machine that cannot move would: '; without brake it moves', or nothing."""
    spare = list(removable_closures(machine, start))
    return f"; without {' or '.join(spare)} it moves" if spare else ""


def describe_corrections(found: Sequence[JointCorrection]) -> str:
    """Say which correction would let a machine move: one, any of several, or that none is known."""
    said = [one.words for one in found[:MAX_NAMED_CORRECTIONS]]
    if not found:
        return "no single axis or anchor explains it"
    if len(found) == 1:
        return f"{said[0]}, which alone explains it"
    more = f", or another of {len(found) - MAX_NAMED_CORRECTIONS} more" if len(found) > MAX_NAMED_CORRECTIONS else ""
    return f"either {' or '.join(said)}{more}: each alone would explain it"


def _close_along_motion(
    machine: DrivenTree, start: Array, times: Array, changed: tuple[SpatialJoint, str] | None
) -> tuple[float, Array]:
    """Close the loops at several times at once over growing parts of the motion (W, T), each starting from the last.

    Args:
        changed: joint whose axis is rotated [rad], or whose anchor is moved [m], across its axis; None for none.

    Returns:
        The remaining constraint violation [m], and the correction (2,) that was made.
    """
    coordinates, change, before = np.repeat(start, times.shape[1], axis=1), np.zeros(2), np.zeros(times.shape[1])
    left = np.inf
    for at in times:
        if before[-1]:  # extrapolate from the last two times before
            slope = (coordinates[:, -1:] - coordinates[:, -2:-1]) / (before[-1] - before[-2])
            inside = np.array([np.interp(at, before, row) for row in coordinates])
            coordinates = inside + slope * np.maximum(at - before[-1], 0.0)
        left, change, coordinates = _close_at(machine, coordinates, at, changed, change)
        before = at
    return left, change


def _close_at(
    machine: DrivenTree, coordinates: Array, times: Array, changed: tuple[SpatialJoint, str] | None, change: Array
) -> tuple[float, Array, Array]:
    """Close the loops at times (T,) by Gauss-Newton steps.

    Returns:
        The remaining constraint violation [m], the correction (2,), and coordinates (nq, T).
    """
    tree, count = machine.tree, len(times)
    here, best = machine.with_driven_joints(coordinates, times), (np.inf, change, coordinates)
    size = tree.extent if changed is not None and changed[1] == "anchor" else 1.0
    for number in range(MAX_GAUSS_NEWTON_STEPS):
        if changed is None:
            found = forward_kinematics(tree, here)
        else:  # at all corrections in one go
            corrections = change + DIFFERENCE_STEP * size * SIDES
            found = forward_kinematics(_with_corrections(tree, *changed, corrections, count), np.tile(here, len(SIDES)))
        every = residuals(found, 0)[0]
        left = every[:, :count]
        gap = float(np.abs(left).max())
        if not np.isfinite(gap):
            break
        if gap < best[0]:
            best = gap, change, here
        matrix, open_rows = _derivatives(machine, found, every, count), left.T.ravel()
        if changed is not None:
            # Over a short motion a part of the correction matters little: first steps are damped (Levenberg 1944).
            damped = np.zeros((2, matrix.shape[1]))
            damped[:, -2:] = DAMPING * 0.5**number * tree.extent * np.eye(2)
            matrix, open_rows = np.concatenate([matrix, damped]), np.concatenate([open_rows, np.zeros(2)])
        step = -np.linalg.lstsq(matrix, open_rows, rcond=1e-9)[0]
        step *= min(1.0, MAX_STEP * tree.extent / max(float(np.abs(step).max()), 1e-300))
        own = step[: count * len(machine.free)].reshape(count, -1).T
        displacement = np.zeros((tree.freedom, count))
        displacement[machine.free] = machine.weights[:, None] * own
        here = displace(tree, here, displacement)
        change = change + size * step[own.size :] if changed is not None else change
        if np.abs(step).max() < STEP_TOLERANCE * tree.extent:
            break
    return best


def _derivatives(machine: DrivenTree, found: Poses, residual: Array, count: int) -> Array:
    """Derivatives (T rows, T free + 2) of the residuals at T times by the free rates, and by a joint's correction.

    Args:
        found: poses at T samples, or at T samples of each of the corrections `SIDES`.
        residual: residuals (rows, samples) there.
        count: T.
    """
    rows, free, samples = len(residual), len(machine.free), residual.shape[1]
    sides = residual.reshape(rows, -1, count)
    made = np.zeros((rows * count, free * count + (2 if samples > count else 0)))
    for k, block in enumerate(jacobian(found, samples)[:count, :, machine.free] * machine.weights):
        made[k * rows : (k + 1) * rows, k * free : (k + 1) * free] = block
    for column, ahead in enumerate(range(1, sides.shape[1], 2), free * count):
        made[:, column] = ((sides[:, ahead] - sides[:, ahead + 1]) / (2.0 * DIFFERENCE_STEP)).T.ravel()
    return made


def _with_corrections(tree: SpatialTree, joint: SpatialJoint, kind: str, changes: Array, count: int) -> SpatialTree:
    """The tree with a joint's axis rotated, or its anchor moved, by two numbers across its axis.

    Args:
        changes: (n, 2), each for a number of samples in turn.
    """
    moves = changes @ np.linalg.svd(joint.axis[None])[2][1:]
    if kind == "axis":
        axes = joint.axis + moves
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        return tree.with_joint(replace(joint, axis=np.repeat(axes.T, count, axis=1)))
    return tree.with_joint(replace(joint, anchor=np.repeat((joint.anchor + moves).T, count, axis=1)))
