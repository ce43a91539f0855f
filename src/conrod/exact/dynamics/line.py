"""A mechanism of one degree of freedom as one mass on a line: its inertia, weight and loads by the arc length.

Kinetic energy is half of I(s) s'^2, so I s'' + I' s'^2 / 2 = -V'(s) + the loads' forces along s.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.polynomial import chebyshev

from conrod.errors import InvalidInput
from conrod.exact.dynamics import coordinate_jet
from conrod.exact.dynamics.configurations import Configurations
from conrod.exact.dynamics.pieces import DEGREE, Samples
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import CONSERVATIVE, Coordinate, Load, Turn
from conrod.mechanism.mechanism import GROUND, Mechanism

ORDERS = np.arange(DEGREE + 1)
# Of the inertia against its largest on a piece: below it, its series has lost too many digits.
LEAST_INERTIA = 1e-6


@dataclass(frozen=True)
class At:
    """The reduced mechanism at one arc length, see `_reduced`; values and rates of loads without a potential, (L,)."""

    inertia: float
    slope: float
    potential: float
    descent: float
    values: Array
    rates: Array


class Line:
    """The reduced mechanism along its curve of configurations."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.configurations = Configurations(mechanism)
        self._known: dict[int, tuple[Samples, Array]] = {}  # by identity of pieces, which are kept for it
        # Loads whose coordinates come from the series, in their order; of them potentials, and what are none.
        loads = [x for x in mechanism.loads if not x.conservative or isinstance(x.along, Turn)]
        self._along = [load.along for load in loads]
        self._wound = [(k, load.law) for k, load in enumerate(loads) if isinstance(load.law, CONSERVATIVE)]
        self._driven = [k for k, load in enumerate(loads) if not load.conservative]

    def at(self, along: float) -> At:
        """The reduced mechanism at an arc length."""
        piece, basis, turns = self._basis(along)
        if id(piece) not in self._known:
            self._known[id(piece)] = piece, self._series(piece)
        columns = basis @ self._known[id(piece)][1]
        values, rates = columns[4:].reshape(2, -1)
        inertia, slope, potential, descent = (float(some) for some in columns[:4])
        if turns:
            values = values + turns * np.array([self._gain(coordinate) for coordinate in self._along])
        for k, law in self._wound:
            potential += float(law.energy(values[k]))
            descent += float(law.force(values[k], rates[k], np.zeros(1))) * float(rates[k])
        return At(inertia, slope, potential, descent, values[self._driven], rates[self._driven])

    def _gain(self, along: Coordinate) -> float:
        """Gain of a coordinate over each loop: a turn, whole turns."""
        loop = self.configurations.loop
        if loop is None or not isinstance(along, Turn):
            return 0.0
        gains = {body.name: float(loop.gain[3 * k + 2]) for k, body in enumerate(self.mechanism.bodies)}
        gains[GROUND] = 0.0
        return gains[along.b] - gains[along.a]

    def point(self, along: float) -> tuple[Array, Array, Array]:
        """Poses and their first and second derivatives by the arc length, each (3 n,)."""
        piece, basis, turns = self._basis(along)
        point, tangent, curvature = (basis @ piece.series(v) for v in (piece.points, piece.tangents, piece.curvatures))
        loop, scale = self.configurations.loop, self.configurations.curve.scale
        return (point if loop is None else point + turns * loop.gain) * scale, tangent * scale, curvature * scale

    def crossings(self, lowest: float, highest: float) -> list[float]:
        """Arc lengths between two known ones where branches cross, growing."""
        pieces = chain(self.configurations.behind, self.configurations.ahead)
        found = [piece.crossing for piece in pieces if piece.crossing is not None]
        loop = self.configurations.loop
        if loop is not None:
            turns = np.arange(np.floor(lowest / loop.length), np.floor(highest / loop.length) + 1.0)
            found = [crossing + turn * loop.length for turn in turns for crossing in found]
        return sorted(crossing for crossing in found if lowest < crossing < highest)

    def _basis(self, along: float) -> tuple[Samples, Array, float]:
        """The piece of an arc length, Chebyshev polynomials (K,) there, and how many times the loop was gone round."""
        known, turns = self.configurations, 0.0
        known.reach(along)
        if known.loop is not None:
            turns = float(np.floor(along / known.loop.length))
            along = max(0.0, along - turns * known.loop.length)  # rounding may leave it just before the start
        if along >= 0.0:
            pieces, k = known.ahead, bisect_right(known.ahead, along, key=lambda piece: piece.start) - 1
        else:
            pieces, k = known.behind, bisect_right(known.behind, -along, key=lambda piece: -piece.stop) - 1
        piece = pieces[max(0, min(k, len(pieces) - 1))]
        local = 2.0 * (along - piece.start) / (piece.stop - piece.start) - 1.0
        return piece, np.cos(ORDERS * np.arccos(min(1.0, max(-1.0, local)))), turns

    def _series(self, piece: Samples) -> Array:
        """Chebyshev series of what `_reduced` gives, in one matrix (DEGREE + 1, columns)."""
        with np.errstate(divide="ignore", invalid="ignore"):  # what comes of it is refused below
            columns = _reduced(self.configurations, piece, self.mechanism.loads)
        inertia = np.ascontiguousarray(columns[:, 0])
        least = _least(piece.series(inertia)) / inertia.max()
        if not least > LEAST_INERTIA:
            raise InvalidInput(
                f"{self.mechanism.name}: where hardly anything that has mass moves, its inertia falls to "
                f"{max(least, 0.0):.1g} of what it is nearby: give the crank an inertia"
            )
        if not np.isfinite(columns).all():
            raise InvalidInput(f"{self.mechanism.name}: a force is not finite: the two points of a load meet")
        return piece.series(columns)


def _least(series: Array) -> float:
    """The least value of a Chebyshev series: on a grid, and at the vertex of the parabola there."""
    grid = np.linspace(-1.0, 1.0, 129)
    values = chebyshev.chebval(grid, series)
    k = min(max(int(np.argmin(values)), 1), len(grid) - 2)
    before, least, after = values[k - 1 : k + 2]
    bend, slope = before - 2.0 * least + after, 0.5 * (after - before)
    vertex = least - 0.5 * slope**2 / bend if bend > abs(slope) else values.min()
    return float(min(vertex, values.min()))


def _reduced(configurations: Configurations, piece: Samples, loads: Sequence[Load]) -> Array:
    """The reduced mechanism at the nodes of a piece, by the arc length; (K, 4 + 2 L).

    Columns: inertia I [kg m^2], for arc lengths are angles, and its derivative; potential of weight, constant forces
    and springs [J] and minus its derivative; coordinates of the L other loads, and their derivatives. Loads on turns,
    which whole turns of the crank make more of, are among these.
    """
    mechanism, scale = configurations.mechanism, configurations.curve.scale
    bodies = pose_jets(mechanism, [piece.points * scale, piece.tangents * scale, 0.5 * piece.curvatures * scale])
    inertia, slope, potential, descent = (np.zeros(len(piece.points)) for _ in range(4))
    for body in mechanism.bodies:
        pose = bodies[body.name]
        x, y = (jet.coefficients for jet in pose.point(body.centre_of_gravity))
        turn = pose.phi.coefficients
        inertia += body.mass * (x[1] ** 2 + y[1] ** 2) + body.inertia * turn[1] ** 2
        # Twice the second coefficient is the second derivative.
        slope += 4.0 * (body.mass * (x[1] * x[2] + y[1] * y[2]) + body.inertia * turn[1] * turn[2])
        push = mechanism.push_on(body.name)
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
    return np.column_stack([inertia, slope, potential, descent, *values, *rates])
