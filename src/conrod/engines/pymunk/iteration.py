"""How many iterations pymunk's solver takes, by the theory of its own iteration. Imports no engine.

Chipmunk goes through the joints in their order and gives each the impulse that brings it to the rate asked for, all
others left alone: Gauss-Seidel on J M^-1 J' p = b. Of the velocities, what is left of the impulses' error e is
y = M^-1 J' e, and a joint projects it: y -> (1 - M^-1 J_i' (J_i M^-1 J_i')^-1 J_i) y. The product T of all
projections is one iteration; N of them leave T^N y.

A step begins with the impulses of the last one. Where positions are mended whole at every step, what it leaves, the
next step has to undo twice, in the rates and in the gaps: with p the impulses that a settled iteration gives,

    e_n = T^N (3 e_(n-1) - 3 e_(n-2) + e_(n-3) - (p_n - p_(n-1))).

That decays where T^N is below 1/7, and is largest at the start, which knows no impulses: p_0 = 0, and p_1 are 3/2 h
times the exact motion's forces, as the first velocity belongs to 3/2 h. Rates are off by y_n - y_(n-1), and
accelerations, their difference over h, by 3/2 T^N M^-1 J' f: of order 0, where the step's own error is 5/12 h^2 x''''.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np

from conrod.engines.centres import by_centres, equations, inverse_masses, one_iteration
from conrod.engines.numerics import MEETING
from conrod.exact.dynamics.coordinates import load_forces
from conrod.exact.dynamics.inverse import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Prismatic

SHARE = 0.01  # of the step's own error, that the iteration may leave
FINEST = 5000  # steps a turn; with more of them rounding, which grows with their square, is the larger error
SAMPLES = 36  # positions of the turn that a run may begin at
LEAST, MOST = 10, 100_000  # pymunk's default; what a step can be waited for
KEPT = 128


@lru_cache(KEPT)
def iterations_needed(kinematics: Kinematics, speed: float) -> int:
    """So many that they leave nothing beside the step's own error, wherever a run begins and whatever its step.

    Change points are left out: the closer to one, the more it takes, without end.
    """
    mechanism, angle = kinematics.mechanism, kinematics.angles(SAMPLES)
    clear = ~kinematics.near_change(angle, MEETING)
    angle = angle[clear] if clear.any() else angle
    derivatives = kinematics.derivatives(angle, 4)
    poses, rates = derivatives[0], derivatives[1] * speed
    forces = inertia_forces(mechanism, poses, rates, derivatives[2] * speed**2)
    forces -= load_forces(mechanism, poses, rates, angle / speed)
    inverse = inverse_masses(mechanism, straight(mechanism))
    free = np.flatnonzero(inverse)
    of_centres = by_centres(mechanism, poses)[:, :, free]
    begun = 1.5 * inverse[free] * (np.swapaxes(of_centres, 1, 2) @ forces[:, :, None])[:, :, 0]

    def size(of: list[Array], order: int) -> float:
        points = kinematics.point_derivatives(of)
        return max(
            float(np.linalg.norm(values[order], axis=1).max()) / kinematics.lengths[name]
            for name, values in points.items()
        )

    def left(changes: Array) -> float:
        return size([poses, (of_centres @ changes[:, :, None])[:, :, 0]], 1)

    step = 2.0 * np.pi / FINEST
    allowed = SHARE * 5.0 / 12.0 * step**2 * size(derivatives, 4) * speed**2
    jacobian = kinematics.jacobian(poses) @ of_centres
    return _iterations(one_iteration(jacobian, inverse[free], _constraints(kinematics)), begun, left, allowed)


def _iterations(once: Array, begun: Array, left: Callable[[Array], float], allowed: float) -> int:
    """The least number of iterations (S, n, n) that leave so much of what they begin with (S, n)."""
    powers, before, count = [once], begun[:, :, None], 1
    while left((powers[-1] @ before)[:, :, 0]) > allowed and 2 ** (len(powers) - 1) < MOST:
        powers.append(powers[-1] @ powers[-1])
    for k in reversed(range(len(powers) - 1)):
        after = powers[k] @ before
        if left(after[:, :, 0]) > allowed:
            before, count = after, count + 2**k
    return min(max(LEAST, count), MOST)


def straight(mechanism: Mechanism) -> set[str]:
    """Bodies that cannot turn: those on a slide of the ground."""
    return {body.name for body in mechanism.bodies if isinstance(mechanism.guide(body.name), Prismatic)}


def _constraints(kinematics: Kinematics) -> Iterator[slice]:
    """Equations that pymunk solves together, in its order: pins and slides, then gears."""
    last: list[slice] = []
    for joint, rows in equations(kinematics):
        if isinstance(joint, Mesh):
            last.append(rows)
        elif isinstance(joint, Prismatic):
            yield slice(rows.start, rows.start + 1)
            if GROUND not in (joint.a, joint.b):  # else the body cannot turn
                yield slice(rows.start + 1, rows.stop)
        else:
            yield rows
    yield from last
