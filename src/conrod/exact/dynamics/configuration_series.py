"""All configurations that a mechanism reaches from its start poses, as a series in arc length, computed as needed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.arc_length_continuation import (
    ARC_LOOK_AHEAD,
    MAX_STEP,
    ArcLengthContinuation,
    CurvePoint,
    passes_start,
    too_close_message,
)
from conrod.exact.configuration_curve import ConfigurationCurve, single_blas_thread, without_whole_turns
from conrod.exact.dynamics.curve_piece import DEGREE, TAIL_TOLERANCE, CurvePiece, fit_piece
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

MAX_PIECE_LENGTH = 0.4  # arc length, in the curve's unit
MIN_POINTS = 2  # tracked points that a piece is fitted through
MAX_LENGTH_GROWTH = 1.5  # length of a piece over that of the piece before
MIN_PIECE_LENGTH = 1e-6  # arc length, in the curve's unit: a series that does not converge below it never will


@dataclass(frozen=True)
class Loop:
    """A configuration curve that returns to its start: its length, and the bodies' rotations (3 n,) over it."""

    length: float
    gain: Array


class ConfigurationSeries:
    """The configuration curve of a mechanism as pieces of Chebyshev series; arc length 0 is at the start poses.

    Arc length grows in the sense in which the crank angle turns the driven body.

    Attributes:
        ahead: pieces from arc length 0 on, in order; behind: pieces before it, the nearest first.
        loop: length and gain of a closed curve, once its end is known.

    Raises:
        InvalidInput: branches of the motion cross at the start poses.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.curve = ConfigurationCurve(mechanism)
        continuation = ArcLengthContinuation(self.curve)
        sense = np.zeros((1, 3 * len(mechanism.bodies)))
        sense[0, 3 * mechanism.body_index[mechanism.crank] + 2] = float(mechanism.driver.sense)
        self.start = continuation.start_point(sense)
        self.loop: Loop | None = None
        self.ahead: list[CurvePiece] = []
        self.behind: list[CurvePiece] = []  # the first ends at arc length 0
        self._forth = _PieceBuilder(continuation, self.start)
        self._back = _PieceBuilder(continuation, continuation.start_point(-self.start.tangent))

    def extend_to(self, arc_length: float) -> None:
        """Compute the curve up to an arc length, or all of it if it closes earlier.

        Raises:
            InvalidInput: the curve ends earlier.
        """
        while self.loop is None and arc_length >= (self.ahead[-1].stop if self.ahead else 0.0):
            self.ahead.append(self._forth.next_piece())
            if self._forth.closed:
                stop = self.ahead[-1]
                self.loop = Loop(stop.stop, stop.points[-1] - self.start.point[0])
        while self.loop is None and arc_length < (self.behind[-1].start if self.behind else 0.0):
            self.behind.append(_reverse(self._back.next_piece()))
            if self._back.closed:
                last = self.behind[-1]
                self.loop = Loop(-last.start, self.start.point[0] - last.points[0])
                self.ahead, self.behind = [_shift_by_loop(s, self.loop) for s in self.behind[::-1]], []


class _PieceBuilder:
    """Consecutive pieces of a curve in one sense, each as long as its series converges."""

    def __init__(self, continuation: ArcLengthContinuation, start: CurvePoint) -> None:
        self._continuation, self._curve, self._start = continuation, continuation.curve, start
        self._places = [start]  # known, not yet in a piece but for the first
        self._along, self._length = 0.0, MAX_PIECE_LENGTH * self._curve.unit
        self._steps = continuation.points_after(start)
        self._longest = MAX_STEP
        self._returned = False
        self.closed = False

    @single_blas_thread()
    def next_piece(self) -> CurvePiece:
        """Return the next piece; raises InvalidInput where the curve cannot be tracked further."""
        while (found := self._longest_piece(ends := self._gather_points())) is None:
            self._shorten_steps()
        piece, used = found
        self._places = self._places[used - 1 :]
        if used == ends and self._joint:
            self._places[0] = self._continuation.onto_next_arcs(self._places[0])
        self._along, self._length = piece.stop, piece.stop - piece.start
        self.closed = self._returned and len(self._places) == 1
        return piece

    def _longest_piece(self, max_points: int) -> tuple[CurvePiece, int] | None:
        """Longest converging piece from the first point, with the number of points used; None if none converges."""
        reach = self._places[0].arc_length + MAX_LENGTH_GROWTH * self._length
        count = min(max_points, max(MIN_POINTS, sum(place.arc_length <= reach for place in self._places)))
        while True:
            piece = fit_piece(self._curve, self._places[:count], self._along)
            tail = np.inf if piece is None else _relative_tail(piece)
            if piece is not None and tail <= TAIL_TOLERANCE:
                return piece, count
            if count <= MIN_POINTS:
                return None
            # Coefficients fall with the power of the degree in the length of the piece.
            share = 2.0 / 3.0 if piece is None else 0.95 * max(0.5, (TAIL_TOLERANCE / tail) ** (1.0 / DEGREE))
            count = max(MIN_POINTS, min(count - 1, int(share * count)))

    def _shorten_steps(self) -> None:
        """Discard the points after the last piece and track on from there in shorter steps."""
        first, second = self._places[:2]
        self._longest = 0.3 * (second.arc_length - first.arc_length) / self._curve.unit
        if self._longest < MIN_PIECE_LENGTH:
            raise InvalidInput(too_close_message(self._curve.mechanism.name))
        self._places, self._returned = [first], False
        self._steps = self._continuation.points_after(first, self._longest)
        self._length = 4.0 * self._longest * self._curve.unit

    def _gather_points(self) -> int:
        """Track points until a piece can be fitted; return how many of them it may use."""
        spread = min(MAX_PIECE_LENGTH * self._curve.unit, 2.0 * MAX_LENGTH_GROWTH * self._length)
        self._joint = False
        while True:
            for k, place in enumerate(self._places[1:], 2):
                if self._curve.arcs(place.point + ARC_LOOK_AHEAD * place.tangent) != self._places[0].arcs:
                    self._joint = True
                    return k
            if self._returned or self._places[-1].arc_length - self._places[0].arc_length >= spread:
                return len(self._places)
            self._add_point(next(self._steps))

    def _add_point(self, place: CurvePoint) -> None:
        """Append a tracked point, replaced by the start where the curve closes."""
        if passes_start(self._curve, self._start, self._places[-1], place):
            gain = place.point - self._start.point
            whole = gain - without_whole_turns(self._curve.mechanism, gain)
            # How far along it lies is only needed roughly.
            place = replace(self._start, arc_length=place.arc_length, point=self._start.point + whole)
            self._returned = True
            if len(self._places) > 1 and np.linalg.norm(place.point - self._places[-1].point) < MIN_PIECE_LENGTH:
                self._places.pop()
        self._places.append(place)


def _relative_tail(piece: CurvePiece) -> float:
    """Size of the last coefficients of a piece's curvature over the curvature, rounding allowed for."""
    series = piece.series(piece.curvatures)
    size = max(1.0, float(np.abs(piece.curvatures).max()), piece.noise / TAIL_TOLERANCE)
    return float(np.abs(series[piece.degree - 1 : piece.degree + 1]).max()) / size


def _reverse(piece: CurvePiece) -> CurvePiece:
    """Return a piece that was tracked backwards in the sense of growing arc length."""
    crossing = None if piece.crossing is None else -piece.crossing
    return replace(
        piece, start=-piece.stop, stop=-piece.start, points=piece.points[::-1], tangents=-piece.tangents[::-1],
        curvatures=piece.curvatures[::-1], crossing=crossing,
    )  # fmt: skip


def _shift_by_loop(piece: CurvePiece, loop: Loop) -> CurvePiece:
    """Return a piece one loop further on."""
    crossing = None if piece.crossing is None else piece.crossing + loop.length
    start, stop = piece.start + loop.length, piece.stop + loop.length
    return replace(piece, start=start, stop=stop, points=piece.points + loop.gain, crossing=crossing)
