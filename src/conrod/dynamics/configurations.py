"""All configurations that a mechanism passes from its start poses on, as a function of arc length, worked out as needed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from conrod.dynamics.constraint import JointCurve, turned_alike
from conrod.dynamics.path import CurveWalk, Place, closes
from conrod.dynamics.pieces import TAIL, Samples, sampled
from conrod.errors import InvalidInput
from conrod.mechanism import Mechanism
from conrod.motion import Array

SPREAD = 0.4  # of arc length, in its unit, at most in one piece
LEAST_PLACES = 2
FEWEST = 1e-6  # of arc length, in its unit: a shorter piece does not converge for another reason


@dataclass(frozen=True)
class Loop:
    """A curve that comes back to its start: its whole length, and what the bodies' turns gain (3 n,) over it."""

    length: float
    gain: Array


class Configurations:
    """Pieces of the curve of a mechanism's configurations; arc length 0 is at the start poses.

    It grows in the sense in which the driven body turns with the crank angle.

    Raises:
        InvalidInput: branches of the motion cross at the start poses.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.curve = JointCurve(mechanism)
        walk = CurveWalk(self.curve)
        sense = np.zeros((1, 3 * len(mechanism.bodies)))
        sense[0, 3 * mechanism.body_index[mechanism.crank] + 2] = float(mechanism.driver.sense)
        self.start = walk.first(sense)
        self.loop: Loop | None = None
        self.ahead: list[Samples] = []
        self.behind: list[Samples] = []  # the first ends at arc length 0
        self._forth = _Pieces(self.curve, self.start, walk.steps(self.start), 0.0)
        back = walk.first(-self.start.tangent)
        self._back = _Pieces(self.curve, back, walk.steps(back), 0.0)

    def reach(self, along: float) -> None:
        """Work the curve out as far as an arc length, or all of it where it closes before.

        Raises:
            InvalidInput: the curve ends before.
        """
        while self.loop is None and along >= (self.ahead[-1].stop if self.ahead else 0.0):
            self.ahead.append(self._forth.following())
            if self._forth.closed:
                stop = self.ahead[-1]
                self.loop = Loop(stop.stop, stop.points[-1] - self.start.point[0])
        while self.loop is None and along < (self.behind[-1].start if self.behind else 0.0):
            self.behind.append(_reversed(self._back.following()))
            if self._back.closed:  # pragma: no cover  (a loop is met going either way)
                self._close_from_behind()

    def _close_from_behind(self) -> None:
        length = -self.behind[-1].start
        gain = self.start.point[0] - self.behind[-1].points[0]
        self.loop = Loop(length, gain)
        moved = [
            replace(s, start=s.start + length, stop=s.stop + length, points=s.points + gain) for s in self.behind[::-1]
        ]
        self.ahead, self.behind = moved, []


class _Pieces:
    """Pieces one after the other, each as long as its series converges."""

    def __init__(self, curve: JointCurve, start: Place, steps: Iterator[Place], along: float) -> None:
        self._curve, self._start, self._steps = curve, start, steps
        self._places = [start]  # known, not yet in a piece but for the first
        self._along = along
        self._longest = SPREAD * curve.unit
        self.closed = False
        self._returned: int | None = None

    def following(self) -> Samples:
        """The next piece.

        Raises:
            InvalidInput: the curve cannot be followed further, or not told by a series.
        """
        self._gather()
        count = len(self._places)
        while count >= LEAST_PLACES:
            piece = sampled(self._curve, self._places[:count], self._along)
            if piece is not None and _converged(piece):
                self._places = self._places[count - 1 :]
                self._along = piece.stop
                self.closed = self._returned is not None and len(self._places) == 1
                return piece
            count = max(count - 1, (2 * count) // 3) if count > LEAST_PLACES else 0
        raise InvalidInput(f"{self._curve.mechanism.name}: its motion is not smooth enough to be told by series")

    def _gather(self) -> None:
        while self._returned is None and self._places[-1].along - self._places[0].along < self._longest:
            place = next(self._steps)
            if closes(self._curve, self._start, self._places[-1], place):
                gain = place.point - self._start.point
                whole = gain - turned_alike(self._curve.mechanism, gain)
                place = replace(self._start, along=place.along, point=self._start.point + whole)
                self._returned = 1
                if place.along - self._places[-1].along < FEWEST * self._curve.unit:
                    self._places.pop()
            self._places.append(place)


def _converged(piece: Samples) -> bool:
    """Whether the last coefficients of the curvature are small against its own size."""
    series = piece.series(piece.curvatures)
    return float(np.abs(series[-2:]).max()) <= TAIL * max(1.0, float(np.abs(piece.curvatures).max()))


def _reversed(piece: Samples) -> Samples:
    """A piece walked backwards, in the sense in which arc length grows."""
    return Samples(-piece.stop, -piece.start, piece.points[::-1], -piece.tangents[::-1], piece.curvatures[::-1])
