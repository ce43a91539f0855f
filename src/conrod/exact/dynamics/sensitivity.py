"""Exact sensitivities of drive torque and reactions to masses, and changes that no quantity can see.

Drive torque and reactions are the multipliers of M q'' - Q = J^T lambda. J has no mass in it, so the derivative by a
mass, a place of a centre of gravity or an inertia solves the same equations with that of M q'' - Q on the left.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics.inverse import InverseDynamics, JointForces, State
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Body, Mechanism

MASS, CENTRE_X, CENTRE_Y, INERTIA = "mass", "centre_of_gravity.x", "centre_of_gravity.y", "inertia"
PROPERTIES = (MASS, CENTRE_X, CENTRE_Y, INERTIA)
TORQUE = "drive torque"
Changes = dict[tuple[str, str], float]  # by body and property [kg], [m] or [kg m^2]
# Changes that are to be seen: 1 % of a mass, 1 % of a length, 5 % of an inertia.
MASS_STEP, LENGTH_STEP, INERTIA_STEP = 0.01, 0.01, 0.05
# Of a quantity's peak, what a change that is to be seen must make: far above rounding, far below any engine.
SEEN = 1e-10


@dataclass(frozen=True)
class Sensitivity:
    """Of all quantities to one property of one body.

    Attributes:
        derivatives: by the name of the quantity, "drive torque" or "joint.component", (T,), by the property.
        effects: by the same names, the largest change that `change` makes, against the quantity's peak (where it has
            none, against the largest peak of a quantity of its unit).
    """

    body: str
    quality: str
    change: float  # of the property, that is to be seen [kg], [m] or [kg m^2]
    derivatives: dict[str, Array]
    effects: dict[str, float]

    @property
    def unseen(self) -> bool:
        """True where no quantity depends on the property."""
        return max(self.effects.values()) < SEEN


def sensitivities(kinematics: Kinematics, state: State) -> Iterator[Sensitivity]:
    """Of drive torque and reactions in a motion, to each property of each body, one after the other."""
    mechanism, inverse = kinematics.mechanism, InverseDynamics(kinematics)
    poses, rates, accelerations = inverse.motion(state)
    factors, peaks = kinematics.factors(poses), _peaks(inverse.forces(state))
    for body in mechanism.bodies:
        by_name = _derivatives(mechanism, body, poses, rates, accelerations)
        for name, right in by_name.items():
            derivatives = quantities(inverse.forces_of(factors.solve_transposed(list(right.T))))
            change = _change(kinematics, body, name)
            effects = {key: float(np.abs(value).max()) * change / peaks[key] for key, value in derivatives.items()}
            yield Sensitivity(body.name, name, change, derivatives, effects)


def quantities(forces: JointForces) -> dict[str, Array]:
    """Drive torque and the components of reactions by name, each (T,)."""
    reactions = {f"{joint}.{name}": value for joint, some in forces.components.items() for name, value in some.items()}
    return {TORQUE: forces.drive_torque} | reactions


def blind_changes(found: Iterable[Sensitivity], among: Sequence[str] | None = None) -> list[Changes]:
    """Changes of properties together that no quantity sees to first order; those of one property alone are among them.

    The largest share of each is as that of `Sensitivity`.

    Args:
        among: names of the quantities that are looked at, all where it is left out.
    """
    columns, properties = [], []
    for some in found:
        scaled = []
        for name in some.derivatives if among is None else among:
            largest = float(np.abs(some.derivatives[name]).max()) * some.change
            weight = some.effects[name] / largest if largest > 0.0 else 0.0
            scaled.append(some.derivatives[name] * some.change * weight)
        columns.append(np.concatenate(scaled))
        properties.append((some.body, some.quality, some.change))
    # Of the triangular factor, which has the same singular values and directions, and far fewer rows.
    _, sizes, directions = np.linalg.svd(np.linalg.qr(np.column_stack(columns), mode="r"), full_matrices=False)
    blind = _sparse(directions[sizes <= SEEN * sizes[0]])
    return [
        {
            (body, quality): float(v) * change
            for (body, quality, change), v in zip(properties, row, strict=True)
            if abs(v) > 1e-6
        }
        for row in blind
    ]


def _sparse(rows: Array) -> Array:
    """The same space by rows of few entries: reduced to echelon form, the largest entries first."""
    rows = rows.copy()
    for k in range(len(rows)):
        i, j = (int(at) for at in np.unravel_index(np.abs(rows[k:]).argmax(), rows[k:].shape))
        rows[[k, k + i]] = rows[[k + i, k]]
        rows[k] /= rows[k, j]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, j] * rows[k]
    return rows


def _derivatives(
    mechanism: Mechanism, body: Body, poses: Array, rates: Array, accelerations: Array
) -> dict[str, Array]:
    """Of M q'' - Q, each (T, 3 n), as `conrod.exact.dynamics.inverse.inertia_forces` has it."""
    i = 3 * mechanism.body_index[body.name]
    (cx, cy), phi = body.centre_of_gravity, poses[:, i + 2]
    push = next((force.force for force in mechanism.forces if force.body == body.name), (0.0, 0.0))
    spin, turn = rates[:, i + 2], accelerations[:, i + 2]
    rx, ry = np.cos(phi) * cx - np.sin(phi) * cy, np.sin(phi) * cx + np.cos(phi) * cy
    ax = accelerations[:, i] - turn * ry - spin**2 * rx - mechanism.gravity[0]
    ay = accelerations[:, i + 1] + turn * rx - spin**2 * ry - mechanism.gravity[1]
    result = {name: np.zeros_like(poses) for name in PROPERTIES}
    result[MASS][:, i : i + 3] = np.column_stack([ax, ay, rx * ay - ry * ax])
    for name, (dx, dy) in {CENTRE_X: (np.cos(phi), np.sin(phi)), CENTRE_Y: (-np.sin(phi), np.cos(phi))}.items():
        # The constant force acts at the centre of gravity, and goes with it.
        fx, fy = body.mass * ax - push[0], body.mass * ay - push[1]
        gx, gy = body.mass * (-turn * dy - spin**2 * dx), body.mass * (turn * dx - spin**2 * dy)
        result[name][:, i : i + 3] = np.column_stack([gx, gy, dx * fy - dy * fx + rx * gy - ry * gx])
    result[INERTIA][:, i + 2] = turn
    return result


def _change(kinematics: Kinematics, body: Body, name: str) -> float:
    match name:
        case "mass":
            return MASS_STEP * body.mass
        case "inertia":
            return INERTIA_STEP * body.inertia
        case _:
            return LENGTH_STEP * _length(kinematics, body)


def _length(kinematics: Kinematics, body: Body) -> float:
    """Largest distance [m] of a joint on the body from its origin; the size of the mechanism where there is none."""
    ends = []
    for joint in kinematics.mechanism.joints:
        for name, point in ((joint.a, "point_a"), (joint.b, "point_b")):
            if name == body.name:
                ends.append(math.hypot(*getattr(joint, point, (0.0, 0.0))))
    return max(ends, default=0.0) or kinematics.size


def _peaks(forces: JointForces) -> dict[str, float]:
    """Sizes that effects are measured against, by quantity."""
    peaks = {name: float(np.abs(value).max()) for name, value in quantities(forces).items()}
    turning = {name: name == TORQUE or name.endswith(".moment") for name in peaks}
    largest = {
        kind: max((peak for name, peak in peaks.items() if turning[name] == kind), default=0.0)
        for kind in (True, False)
    }
    return {
        name: peak if peak > SEEN * largest[turning[name]] else largest[turning[name]] or 1.0
        for name, peak in peaks.items()
    }
