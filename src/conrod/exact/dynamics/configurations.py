"""All configurations that a mechanism passes from its start poses on, by arc length, worked out as needed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.curve_walk import BESIDE, LONGEST_STEP, CurvePoint, CurveWalk, closes, too_close
from conrod.exact.dynamics.pieces import DEGREE, TAIL, Samples, sampled
from conrod.exact.joint_curve import JointCurve, one_thread, turned_alike
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

SPREAD = 0.4  # of arc length, in its unit, at most in one piece
LEAST_PLACES = 2
FURTHER = 1.5  # a piece may be longer than the last one by this factor
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
        self._forth = _Pieces(walk, self.start)
        self._back = _Pieces(walk, walk.first(-self.start.tangent))

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
            if self._back.closed:
                last = self.behind[-1]
                self.loop = Loop(-last.start, self.start.point[0] - last.points[0])
                self.ahead, self.behind = [_shifted(s, self.loop) for s in self.behind[::-1]], []


class _Pieces:
    """Pieces one after the other, each as long as its series converges."""

    def __init__(self, walk: CurveWalk, start: CurvePoint) -> None:
        self._walk, self._curve, self._start = walk, walk.curve, start
        self._places = [start]  # known, not yet in a piece but for the first
        self._along, self._length = 0.0, SPREAD * self._curve.unit
        self._steps = walk.steps(start)
        self._longest = LONGEST_STEP
        self._returned = False
        self.closed = False

    @one_thread()
    def following(self) -> Samples:
        """The next piece; raises InvalidInput where the curve cannot be followed further."""
        while (found := self._longest_of(ends := self._gather())) is None:
            self._finer()
        piece, used = found
        self._places = self._places[used - 1 :]
        if used == ends and self._joint:
            self._places[0] = self._walk.leaving(self._places[0])
        self._along, self._length = piece.stop, piece.stop - piece.start
        self.closed = self._returned and len(self._places) == 1
        return piece

    def _longest_of(self, ends: int) -> tuple[Samples, int] | None:
        """A piece that converges from the first place on, and how many places it takes; None if there is none."""
        reach = self._places[0].along + FURTHER * self._length
        count = min(ends, max(LEAST_PLACES, sum(place.along <= reach for place in self._places)))
        while True:
            piece = sampled(self._curve, self._places[:count], self._along)
            tail = np.inf if piece is None else _tail(piece)
            if piece is not None and tail <= TAIL:
                return piece, count
            if count <= LEAST_PLACES:
                return None
            # Coefficients fall with the power of the degree in the length of the piece.
            share = 2.0 / 3.0 if piece is None else 0.95 * max(0.5, (TAIL / tail) ** (1.0 / DEGREE))
            count = max(LEAST_PLACES, min(count - 1, int(share * count)))

    def _finer(self) -> None:
        """Go back to the end of the last piece, and on in steps that are shorter."""
        first, second = self._places[:2]
        self._longest = 0.3 * (second.along - first.along) / self._curve.unit
        if self._longest < FEWEST:
            raise InvalidInput(too_close(self._curve.mechanism.name))
        self._places, self._returned = [first], False
        self._steps = self._walk.steps(first, self._longest)
        self._length = 4.0 * self._longest * self._curve.unit

    def _gather(self) -> int:
        """See to it that enough places are known; how many of them a piece may take."""
        spread = min(SPREAD * self._curve.unit, 2.0 * FURTHER * self._length)
        self._joint = False
        while True:
            for k, place in enumerate(self._places[1:], 2):
                if self._curve.arcs(place.point + BESIDE * place.tangent) != self._places[0].arcs:
                    self._joint = True
                    return k
            if self._returned or self._places[-1].along - self._places[0].along >= spread:
                return len(self._places)
            self._add(next(self._steps))

    def _add(self, place: CurvePoint) -> None:
        if closes(self._curve, self._start, self._places[-1], place):
            gain = place.point - self._start.point
            whole = gain - turned_alike(self._curve.mechanism, gain)
            # How far along it lies is only needed roughly.
            place = replace(self._start, along=place.along, point=self._start.point + whole)
            self._returned = True
            if len(self._places) > 1 and np.linalg.norm(place.point - self._places[-1].point) < FEWEST:
                self._places.pop()
        self._places.append(place)


def _tail(piece: Samples) -> float:
    """The last coefficients of the curvature, but for rounding, against its own size."""
    series = piece.series(piece.curvatures)
    size = max(1.0, float(np.abs(piece.curvatures).max()), piece.noise / TAIL)
    return float(np.abs(series[piece.degree - 1 : piece.degree + 1]).max()) / size


def _reversed(piece: Samples) -> Samples:
    """A piece walked backwards, in the sense in which arc length grows."""
    crossing = None if piece.crossing is None else -piece.crossing
    return replace(
        piece, start=-piece.stop, stop=-piece.start, points=piece.points[::-1], tangents=-piece.tangents[::-1],
        curvatures=piece.curvatures[::-1], crossing=crossing,
    )  # fmt: skip


def _shifted(piece: Samples, loop: Loop) -> Samples:
    crossing = None if piece.crossing is None else piece.crossing + loop.length
    start, stop = piece.start + loop.length, piece.stop + loop.length
    return replace(piece, start=start, stop=stop, points=piece.points + loop.gain, crossing=crossing)
