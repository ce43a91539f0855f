"""A mechanism of one degree of freedom as one mass on a line: its inertia, weight and loads by the arc length.

Kinetic energy is half of I(s) s'^2, so I s'' + I' s'^2 / 2 = -V'(s) + the loads' forces along s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics.configurations import Configurations
from conrod.exact.dynamics.coordinates import coordinate_jet
from conrod.exact.dynamics.pieces import Samples
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import CONSERVATIVE, Load, Turn


@dataclass(frozen=True)
class Reduced:
    """At the nodes of a piece, by the arc length; each (K,), loads (K, loads).

    Attributes:
        inertia: I [kg m^2], for arc lengths are angles; slope: its derivative.
        potential: of weight, constant forces and springs [J]; descent: minus its derivative. Loads on turns, which
            whole turns of the crank make more of, have no part in it.
        value, rate: of the coordinates of all other loads, and their derivatives by the arc length.
    """

    inertia: Array
    slope: Array
    potential: Array
    descent: Array
    value: Array
    rate: Array


def reduced(configurations: Configurations, piece: Samples, loads: Sequence[Load]) -> Reduced:
    """The reduced mechanism at the nodes of a piece."""
    mechanism, scale = configurations.mechanism, configurations.curve.scale
    bodies = pose_jets(mechanism, [piece.points * scale, piece.tangents * scale, 0.5 * piece.curvatures * scale])
    inertia, slope, potential, descent = (np.zeros(len(piece.points)) for _ in range(4))
    constant = {force.body: force.force for force in mechanism.forces}
    for body in mechanism.bodies:
        pose = bodies[body.name]
        x, y = (jet.coefficients for jet in pose.point(body.centre_of_gravity))
        turn = pose.phi.coefficients
        inertia += body.mass * (x[1] ** 2 + y[1] ** 2) + body.inertia * turn[1] ** 2
        # Twice the second coefficient is the second derivative.
        slope += 4.0 * (body.mass * (x[1] * x[2] + y[1] * y[2]) + body.inertia * turn[1] * turn[2])
        push = constant.get(body.name, (0.0, 0.0))
        fx, fy = body.mass * mechanism.gravity[0] + push[0], body.mass * mechanism.gravity[1] + push[1]
        potential -= fx * x[0] + fy * y[0]
        descent += fx * x[1] + fy * y[1]
    values, rates = [], []
    for load in loads:
        along = [np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients]
        if isinstance(load.law, CONSERVATIVE) and not isinstance(load.along, Turn):
            potential += load.law.energy(along[0])
            descent += load.law.force(along[0], along[1], np.zeros_like(along[0])) * along[1]
        else:
            values.append(along[0])
            rates.append(along[1])
    shape = (len(piece.points), 0)
    return Reduced(
        inertia, slope, potential, descent,
        np.column_stack(values) if values else np.zeros(shape),
        np.column_stack(rates) if rates else np.zeros(shape),
    )  # fmt: skip
