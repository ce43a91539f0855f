"""Free and torque-driven motion of a mechanism, exactly: an ordinary differential equation in one coordinate.

The coordinate is the arc length of the curve of configurations (`conrod.dynamics.configurations`), in which nothing is
singular at a crank's dead centres. Integrated by the Runge-Kutta method of order 8 of Dormand and Prince in SciPy. The
energy that loads take or give is integrated beside the motion, so that the balance audits both.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from conrod.dynamics.configurations import Configurations
from conrod.dynamics.pieces import DEGREE, Samples
from conrod.dynamics.reduced import Reduced, reduced
from conrod.errors import InvalidInput
from conrod.mechanism import Mechanism
from conrod.motion import Array

RELATIVE, ABSOLUTE = 3e-14, 1e-15  # of the integrator
ORDERS = np.arange(DEGREE + 1)


@dataclass(frozen=True)
class FreeMotion:
    """An exact motion at given times.

    Attributes:
        times: (T,) [s].
        poses, rates, accelerations: of all bodies, (T, 3 n).
        energy: kinetic and potential (T,) [J].
        work: of the loads that are no potential (T,) [J].
    """

    times: Array
    poses: Array
    rates: Array
    accelerations: Array
    energy: Array
    work: Array
    scale: float

    @property
    def drift(self) -> float:
        """Largest error of the balance of energy, against the largest kinetic energy."""
        balance = self.energy - self.work
        return float(np.abs(balance - balance[0]).max()) / self.scale


@dataclass(frozen=True)
class _Row:
    """A piece's series, all in one matrix (DEGREE + 1, columns)."""

    samples: Samples
    matrix: Array


class ForwardDynamics:
    """One mechanism under loads.

    Raises:
        InvalidInput: branches of its motion cross at the start poses.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.loads = mechanism, mechanism.loads
        self.configurations = Configurations(mechanism)
        self._driven = [load.law for load in self.loads if not load.conservative]
        self._ahead: list[_Row] = []
        self._behind: list[_Row] = []
        self._starts: list[float] = []

    def motion(self, times: Array, crank_rate: float) -> FreeMotion:
        """The motion from the start poses.

        Args:
            times: (T,) [s], growing from 0.
            crank_rate: rate of the crank angle at time 0 [rad/s].

        Raises:
            InvalidInput: the crank stands at a dead centre at the start and cannot turn, or a force is not finite.
        """
        crank = 3 * self.mechanism.body_index[self.mechanism.crank] + 2
        along = float(self.configurations.start.tangent[0, crank]) * self.mechanism.driver.sense
        if crank_rate != 0.0 and abs(along) < 1e-9:
            raise InvalidInput(f"{self.mechanism.name}: at the start the crank stands at a dead centre and cannot turn")
        rate = crank_rate / along if crank_rate else 0.0
        start = np.array([0.0, rate, 0.0])
        found = solve_ivp(
            self._rates, (0.0, float(times[-1])), start, method="DOP853", t_eval=times, rtol=RELATIVE, atol=ABSOLUTE
        )
        if not found.success:
            raise InvalidInput(f"{self.mechanism.name}: its motion cannot be integrated: {found.message}")
        return self._told(times, *found.y)

    # -- the differential equation -----------------------------------------------------------------------------------

    def _rates(self, time: float, state: Array) -> list[float]:
        along, rate, _ = state
        inertia, slope, _, descent, values, rates = self._at(float(along))
        power = self._power(values, rates, float(rate), time)
        acceleration = (descent + power - 0.5 * slope * rate * rate) / inertia
        return [float(rate), float(acceleration), float(power * rate)]

    def _power(self, values: Array, rates: Array, rate: float, time: float) -> float:
        """The loads' force along the arc length."""
        total = 0.0
        for law, value, slope in zip(self._driven, values, rates, strict=True):
            total += float(law.force(value, slope * rate, np.float64(time))) * float(slope)
        if not np.isfinite(total):
            raise InvalidInput(f"{self.mechanism.name}: a force is not finite at t = {time:g} s")
        return total

    def _at(self, along: float) -> tuple[float, float, float, float, Array, Array]:
        row, local, _ = self._row(along)
        told = np.cos(ORDERS * np.arccos(min(1.0, max(-1.0, local)))) @ row.matrix
        count = len(self._driven)
        return told[0], told[1], told[2], told[3], told[4 : 4 + count], told[4 + count :]

    def _row(self, along: float) -> tuple[_Row, float, float]:
        """The piece of an arc length, where on it from -1 to 1, and how many times the loop was gone round."""
        loop, turns = self.configurations.loop, 0.0
        if loop is None:
            self.configurations.reach(along)
            loop = self.configurations.loop
        if loop is not None:
            turns = np.floor(along / loop.length)
            along = along - turns * loop.length
        self._fill()
        if along >= 0.0:
            row = self._ahead[max(0, min(bisect_right(self._starts, along) - 1, len(self._ahead) - 1))]
        else:
            row = next(r for r in self._behind if r.samples.start <= along)
        piece = row.samples
        return row, 2.0 * (along - piece.start) / (piece.stop - piece.start) - 1.0, float(turns)

    def _fill(self) -> None:
        """Series of pieces that have come since."""
        for known, pieces in ((self._ahead, self.configurations.ahead), (self._behind, self.configurations.behind)):
            if len(known) > len(pieces):
                known.clear()
            for piece in pieces[len(known) :]:
                known.append(self._series(piece))
        if len(self._starts) != len(self._ahead):
            self._starts = [row.samples.start for row in self._ahead]

    def _series(self, piece: Samples) -> _Row:
        at: Reduced = reduced(self.configurations, piece, self.loads)
        if at.inertia.min() <= 0.0:
            raise InvalidInput(f"{self.mechanism.name}: where nothing that has mass moves, forces tell no motion")
        columns = np.column_stack([at.inertia, at.slope, at.potential, at.descent, at.value, at.rate])
        return _Row(piece, piece.series(columns))

    # -- what is told of it ------------------------------------------------------------------------------------------

    def _told(self, times: Array, along: Array, rate: Array, work: Array) -> FreeMotion:
        scale = self.configurations.curve.scale
        poses, rates, accelerations = (np.empty((len(times), len(scale))) for _ in range(3))
        kinetic, potential = np.empty(len(times)), np.empty(len(times))
        for k, (s, v, t) in enumerate(zip(along, rate, times, strict=True)):
            inertia, _, potential[k], _, _, _ = self._at(float(s))
            kinetic[k] = 0.5 * inertia * v * v
            acceleration = self._rates(float(t), np.array([s, v, 0.0]))[1]
            point, tangent, curvature = self._point(float(s))
            poses[k], rates[k] = point * scale, tangent * v * scale
            accelerations[k] = (tangent * acceleration + curvature * v * v) * scale
        return FreeMotion(times, poses, rates, accelerations, kinetic + potential, work, float(kinetic.max()) or 1.0)

    def _point(self, along: float) -> tuple[Array, Array, Array]:
        row, local, turns = self._row(along)
        told = np.cos(ORDERS * np.arccos(min(1.0, max(-1.0, local))))
        piece = row.samples
        point, tangent, curvature = (told @ piece.series(v) for v in (piece.points, piece.tangents, piece.curvatures))
        loop = self.configurations.loop
        return (point if loop is None else point + turns * loop.gain), tangent, curvature
