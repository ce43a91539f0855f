"""A mechanism of one degree of freedom reduced to one coordinate: inertia, potential and loads by arc length.

Kinetic energy is I(s) s'^2 / 2, with the reduced inertia I, so I s'' + I' s'^2 / 2 = -V' + Q, with V the potential
energy and Q the force along s of loads without a potential (Eksergian's equation; Paul, Kinematics and Dynamics of
Planar Machinery).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from conrod.errors import InvalidInput
from conrod.exact.dynamics import coordinate_jet
from conrod.exact.dynamics.configuration_series import ConfigurationSeries
from conrod.exact.dynamics.curve_piece import DEGREE, CurvePiece
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import CONSERVATIVE, Coordinate, Turn
from conrod.mechanism.mechanism import GROUND, Mechanism

ORDERS = np.arange(DEGREE + 1, dtype=float)
MIN_INERTIA_RATIO = 1e-6  # least over largest inertia on a piece: below it the series loses too many digits


class ReducedState(NamedTuple):
    """Reduced inertia, potential and loads at one arc length, for L loads without a potential."""

    inertia: float  # I [kg m^2]
    inertia_derivative: float  # I'
    potential: float  # V [J] of weight, constant forces and springs
    conservative_force: float  # -V'
    load_coordinates: Array  # (L,) [m or rad]
    load_derivatives: Array  # (L,), by the arc length


class ReducedDynamics:
    """The mechanism reduced to the arc length of its configuration curve.

    Args:
        configurations: those of the mechanism, or of one that differs in masses and loads alone; None to track them.
    """

    def __init__(self, mechanism: Mechanism, configurations: ConfigurationSeries | None = None) -> None:
        self.mechanism = mechanism
        self.configurations = ConfigurationSeries(mechanism) if configurations is None else configurations
        # By identity of pieces, which are kept for it: the reduced mechanism, and the curve with its derivatives.
        self._known: dict[int, tuple[CurvePiece, Array]] = {}
        self._curves: dict[int, tuple[CurvePiece, tuple[Array, Array, Array]]] = {}
        # The pieces ahead, and the one of them that was asked for last.
        self._last: tuple[list[CurvePiece], CurvePiece | None] = [], None
        # Loads whose coordinates come from the series; springs on rotations among them, and loads without a potential.
        loads = [x for x in mechanism.loads if not x.conservative or isinstance(x.along, Turn)]
        self._along = [load.along for load in loads]
        self._turn_springs = [(k, load.law) for k, load in enumerate(loads) if isinstance(load.law, CONSERVATIVE)]
        self._driven = [k for k, load in enumerate(loads) if not load.conservative]

    def evaluate(self, arc_length: float) -> ReducedState:
        """Return the reduced mechanism at an arc length."""
        piece, basis, turns = self._locate(arc_length)
        if id(piece) not in self._known:
            self._known[id(piece)] = piece, self._series(piece)
        columns = basis @ self._known[id(piece)][1]
        inertia, inertia_derivative, potential, conservative_force = columns[:4].tolist()
        if not self._along:
            return ReducedState(inertia, inertia_derivative, potential, conservative_force, columns[4:], columns[4:])
        values, rates = columns[4:].reshape(2, -1)
        if turns:
            values = values + turns * np.array([self._gain_per_loop(coordinate) for coordinate in self._along])
        for k, law in self._turn_springs:
            potential += float(law.energy(values[k]))
            conservative_force += float(law.force(values[k], rates[k], np.zeros(1))) * float(rates[k])
        return ReducedState(
            inertia, inertia_derivative, potential, conservative_force, values[self._driven], rates[self._driven]
        )

    def _gain_per_loop(self, coordinate: Coordinate) -> float:
        """Change of a load's coordinate over one loop of the curve: whole turns of a rotation, else 0."""
        loop = self.configurations.loop
        if loop is None or not isinstance(coordinate, Turn):
            return 0.0
        gains = {body.name: float(loop.gain[3 * k + 2]) for k, body in enumerate(self.mechanism.bodies)}
        gains[GROUND] = 0.0
        return gains[coordinate.b] - gains[coordinate.a]

    def poses_with_derivatives(self, arc_length: float) -> tuple[Array, Array, Array]:
        """Poses and their first and second derivatives by the arc length, each (3 n,)."""
        piece, basis, turns = self._locate(arc_length)
        if id(piece) not in self._curves:
            points, tangents, curvatures = map(piece.series, (piece.points, piece.tangents, piece.curvatures))
            self._curves[id(piece)] = piece, (points, tangents, curvatures)
        point, tangent, curvature = (basis @ series for series in self._curves[id(piece)][1])
        loop, scale = self.configurations.loop, self.configurations.curve.scale
        return (point if loop is None else point + turns * loop.gain) * scale, tangent * scale, curvature * scale

    def crossings(self, lowest: float, highest: float) -> list[float]:
        """Arc lengths between two known ones where branches cross, ascending."""
        pieces = chain(self.configurations.behind, self.configurations.ahead)
        found = [piece.crossing for piece in pieces if piece.crossing is not None]
        loop = self.configurations.loop
        if loop is not None:
            turns = np.arange(np.floor(lowest / loop.length), np.floor(highest / loop.length) + 1.0)
            found = [crossing + turn * loop.length for turn in turns for crossing in found]
        return sorted(crossing for crossing in found if lowest < crossing < highest)

    def _locate(self, arc_length: float) -> tuple[CurvePiece, Array, float]:
        """Find the piece at an arc length, its Chebyshev polynomials (K,) there, and the number of loops passed."""
        known, turns = self.configurations, 0.0
        known.extend_to(arc_length)
        if known.loop is not None:
            turns = float(math.floor(arc_length / known.loop.length))
            arc_length = max(0.0, arc_length - turns * known.loop.length)  # rounding may leave it just before the start
        pieces, piece = self._last
        if pieces is not known.ahead or piece is None or not piece.start <= arc_length < piece.stop:
            piece = self._piece_at(arc_length)
            self._last = known.ahead, piece if arc_length >= 0.0 else None
        local = 2.0 * (arc_length - piece.start) / (piece.stop - piece.start) - 1.0
        return piece, np.cos(ORDERS * np.arccos(min(1.0, max(-1.0, local)))), turns

    def _piece_at(self, arc_length: float) -> CurvePiece:
        """Return the known piece at an arc length within the first loop."""
        known = self.configurations
        if arc_length >= 0.0:
            pieces, k = known.ahead, bisect_right(known.ahead, arc_length, key=lambda piece: piece.start) - 1
        else:
            pieces, k = known.behind, bisect_right(known.behind, -arc_length, key=lambda piece: -piece.stop) - 1
        return pieces[max(0, min(k, len(pieces) - 1))]

    def _series(self, piece: CurvePiece) -> Array:
        """Chebyshev series (DEGREE + 1, columns) of the columns of `_reduce_piece`."""
        with np.errstate(divide="ignore", invalid="ignore"):  # what comes of it is refused below
            columns = _reduce_piece(self.mechanism, self.configurations.curve.scale, piece)
        inertia = np.ascontiguousarray(columns[:, 0])
        least = _series_minimum(piece.series(inertia)) / inertia.max()
        if not least > MIN_INERTIA_RATIO:
            raise InvalidInput(
                f"{self.mechanism.name}: where hardly anything that has mass moves, its inertia falls to "
                f"{max(least, 0.0):.1g} of what it is nearby: give the crank an inertia"
            )
        if not np.isfinite(columns).all():
            raise InvalidInput(f"{self.mechanism.name}: a force is not finite: the two points of a load meet")
        return piece.series(columns)


def _series_minimum(series: Array) -> float:
    """Smallest value of a Chebyshev series: on a grid, refined by the vertex of a parabola."""
    grid = np.linspace(-1.0, 1.0, 129)
    values = chebyshev.chebval(grid, series)
    k = min(max(int(np.argmin(values)), 1), len(grid) - 2)
    before, least, after = values[k - 1 : k + 2]
    bend, inertia_derivative = before - 2.0 * least + after, 0.5 * (after - before)
    vertex = least - 0.5 * inertia_derivative**2 / bend if bend > abs(inertia_derivative) else values.min()
    return float(min(vertex, values.min()))


def _reduce_piece(mechanism: Mechanism, scale: Array, piece: CurvePiece) -> Array:
    """Reduce the mechanism at the nodes of a piece to functions of arc length; (K, 4 + 2 L).

    Columns: inertia I [kg m^2], as arc lengths are angles, and its derivative; potential V of weight, constant forces
    and springs [J] and -V'; coordinates of the L other loads, and their derivatives. Loads on rotations are among
    these, because they change with whole turns of the crank.
    """
    bodies = pose_jets(mechanism, [piece.points * scale, piece.tangents * scale, 0.5 * piece.curvatures * scale])
    inertia, inertia_derivative, potential, conservative_force = (np.zeros(len(piece.points)) for _ in range(4))
    for body in mechanism.bodies:
        pose = bodies[body.name]
        x, y = (jet.coefficients for jet in pose.point(body.centre_of_gravity))
        turn = pose.phi.coefficients
        inertia += body.mass * (x[1] ** 2 + y[1] ** 2) + body.inertia * turn[1] ** 2
        # Twice the second coefficient is the second derivative.
        inertia_derivative += 4.0 * (body.mass * (x[1] * x[2] + y[1] * y[2]) + body.inertia * turn[1] * turn[2])
        push = mechanism.constant_force_on(body.name)
        fx, fy = body.mass * mechanism.gravity[0] + push[0], body.mass * mechanism.gravity[1] + push[1]
        potential -= fx * x[0] + fy * y[0]
        conservative_force += fx * x[1] + fy * y[1]
    values, rates = [], []
    for load in mechanism.loads:
        along = [np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients]
        if isinstance(load.law, CONSERVATIVE) and not isinstance(load.along, Turn):
            potential += load.law.energy(along[0])
            conservative_force += load.law.force(along[0], along[1], np.zeros_like(along[0])) * along[1]
        else:
            values.append(along[0])
            rates.append(along[1])
    return np.column_stack([inertia, inertia_derivative, potential, conservative_force, *values, *rates])
