"""Many steps of a walk along a branch at once, where nothing is in their way.

What takes time in a step is not its arithmetic, so that many together cost little more than one. Poses at the next
angles are guessed from the last places and made exact together; those are taken that a walk step by step would have
taken: each lies where the tangent of the one before leads to, without a corner, and no loop's determinant comes near
zero on the way. The first that does not ends the stride, and is left to the walk.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.branch_continuation import NEARING, WALK_BEND, WALK_MISS, Place, SmoothCourse
from conrod.exact.motion import Array

KNOWN = 3  # places that a guess is made from
LONGEST = 16  # steps of a stride


def stride(course: SmoothCourse, passed: Sequence[Place], goals: Array) -> list[Place]:
    """Places at the first of some goal angles, as many as follow each other without a doubt; maybe none.

    Args:
        passed: places that the walk has been at, the last one where it is.
        goals: angles (T,) [rad] in the order of the walk.
    """
    goals = goals[: _first(course.changes.near(goals))]
    if not len(goals):
        return []
    equations, here = course.equations, passed[-1]
    try:
        poses = equations.newton(_ahead(passed[-KNOWN:], goals), goals)
    except InvalidInput:
        return []
    poses = np.concatenate([here.poses, poses])
    factors = equations.elimination(poses)
    slopes, blocks = equations.slope(poses, factors=factors), factors.block_determinants()
    widths = np.diff(goals, prepend=here.angle)[:, None]
    none = np.zeros_like(slopes)
    steep = equations.distance(slopes, none)
    doubtful = (
        (equations.distance(poses[1:], poses[:-1] + widths * slopes[:-1]) > WALK_MISS)
        | (equations.distance(slopes[1:], slopes[:-1]) > WALK_BEND * np.maximum(steep[1:], steep[:-1]))
        | ~(blocks[1:] * np.sign(blocks[:-1]) >= NEARING * np.abs(blocks[:-1])).all(axis=1)
    )
    determinants = factors.determinant()
    return [
        Place(float(goals[k - 1]), poses[k : k + 1], slopes[k : k + 1], float(determinants[k]))
        for k in range(1, _first(doubtful) + 1)
    ]


def _first(marked: NDArray[np.bool_]) -> int:
    """Index of the first one that is marked; their number if none is."""
    return int(np.argmax([*marked, True]))


def _ahead(passed: Sequence[Place], goals: Array) -> Array:
    """Poses (T, 3 n) at angles ahead, by the polynomial through the places passed and their slopes."""
    angles = np.array([place.angle for place in passed])
    width = max(float(np.ptp(angles)), abs(float(goals[0] - angles[-1])))
    at, powers = (angles[:, None] - angles[-1]) / width, np.arange(2 * len(angles))
    rates = np.where(powers > 0, powers * at ** np.maximum(powers - 1, 0), 0.0)
    given = np.concatenate([*(place.poses for place in passed), *(width * place.slope for place in passed)])
    coefficients = np.linalg.solve(np.concatenate([at**powers, rates]), given)
    return np.asarray(((goals[:, None] - angles[-1]) / width) ** powers @ coefficients)
