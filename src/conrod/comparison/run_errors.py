"""Recorders of errors for a run that comes in pieces; results do not depend on how it was cut, bit for bit.

Recorders keep no samples but those that they report, and those that wait for the rest of a block.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from conrod.comparison.compare import ComparedPiece, Size
from conrod.comparison.trajectory import COMPARED_QUANTITIES
from conrod.exact.motion import Array


class Recorder(Protocol):
    """A receiver of the pieces of a run in their order, until the run ends or breaks."""

    def add(self, piece: ComparedPiece) -> None:
        """Take the next piece of the run."""


class SeriesSplitter:
    """Splitter of series that arrive in pieces of any length into parts of given lengths."""

    def __init__(self, lengths: Iterable[int]) -> None:
        self._lengths = deque(lengths)
        self._held: list[tuple[Array, ...]] = []
        self._count = 0

    def add(self, *series: Array) -> Iterator[tuple[Array, ...]]:
        """Take the next piece of each series, and yield the parts that are complete."""
        self._held.append(series)
        self._count += len(series[0])
        while self._lengths and self._count >= self._lengths[0]:
            length = self._lengths.popleft()
            whole = self.pending()
            yield tuple(one[:length] for one in whole)
            self._held, self._count = [tuple(one[length:] for one in whole)], self._count - length

    def pending(self) -> tuple[Array, ...]:
        """Samples that wait for the rest of their part."""
        return self._held[0] if len(self._held) == 1 else tuple(map(np.concatenate, zip(*self._held, strict=True)))


BLOCK_NUMBERS = 4096  # largest number of samples whose squares are summed at once


def pairwise_block_sizes(count: int) -> list[int]:
    """Sizes of the blocks whose sums `pairwise_sum` adds, as numpy splits `count` numbers."""
    first = count // 2 - count // 2 % 8
    return [count] if count <= BLOCK_NUMBERS else pairwise_block_sizes(first) + pairwise_block_sizes(count - first)


def pairwise_sum(count: int, sums: Iterator[float]) -> float:
    """Sum of `count` numbers from the sums of their blocks, in numpy's pairwise order, equal to the last bit."""
    first = count // 2 - count // 2 % 8
    return next(sums, 0.0) if count <= BLOCK_NUMBERS else pairwise_sum(first, sums) + pairwise_sum(count - first, sums)


class RunningSize:
    """Largest, rms and last value of a series that arrives in pieces."""

    def __init__(self) -> None:
        self._parts: SeriesSplitter | None = None
        self._whole = self._count = 0
        self._squares: list[float] = []
        self._largest = self._final = 0.0

    def add(self, values: Array, samples_remaining: int) -> None:
        """Take the next values (T,), not negative, with the number of samples after them."""
        if len(values) == 0:
            return
        if self._parts is None:
            self._whole = len(values) + samples_remaining
            self._parts = SeriesSplitter(pairwise_block_sizes(self._whole))
        # Unlike `max`, `np.maximum` keeps nan.
        self._largest, self._final = float(np.maximum(self._largest, values.max())), float(values[-1])
        self._count += len(values)
        self._squares += [float(np.sum(part**2)) for (part,) in self._parts.add(values)]

    @property
    def size(self) -> Size:
        """Largest, rms and last value so far; raises ValueError before the first sample."""
        if self._parts is None:
            raise ValueError("no sample, no error")
        known = iter(self._squares)
        squares = pairwise_sum(self._whole, known) if len(self._squares) > 1 else next(known, 0.0)
        rest = sum(known) + float(np.sum(self._parts.pending()[0] ** 2))  # of a run that did not come to its end
        return Size(self._largest, float(np.sqrt((squares + rest) / self._count)), self._final)


class PointSizes:
    """Recorder of the observed points' errors: largest, rms and last."""

    def __init__(self) -> None:
        self._sizes: defaultdict[str, defaultdict[str, RunningSize]] = defaultdict(lambda: defaultdict(RunningSize))

    def add(self, piece: ComparedPiece) -> None:
        for name, errors in piece.points.items():
            for quantity in COMPARED_QUANTITIES:
                self._sizes[name][quantity].add(getattr(errors, quantity).error, piece.samples_remaining)

    @property
    def errors(self) -> dict[str, dict[str, dict[str, float]]]:
        """Errors by point, quantity and measure."""
        return {name: {q: vars(running.size) for q, running in found.items()} for name, found in self._sizes.items()}

    def worst(self, quantity: str) -> float | None:
        """Largest error of a quantity over all points; None without points."""
        found = [sizes[quantity]["max"] for sizes in self.errors.values()]
        return float(np.max(found)) if found else None


class RunErrors(PointSizes):
    """Recorder of all errors of a run, by their names in a result."""

    def __init__(self) -> None:
        super().__init__()
        self._largest: defaultdict[str, dict[str, float]] = defaultdict(dict)
        self._phase: float  # phase error of the last sample [rad]

    def add(self, piece: ComparedPiece) -> None:
        super().add(piece)
        phase = {str(k): one for k, one in enumerate(piece.phase)}
        for kind, series in (("closure", piece.closure), ("drive", piece.drive), ("phase", phase)):
            known = self._largest[kind]
            for name, values in series.items():
                known[name] = float(np.max(values, initial=known.get(name, 0.0)))
        self._phase = float(piece.phase[0][-1])

    def as_dict(self) -> dict[str, Any]:
        """Errors of points, closures, phase and drive, by the names of a result's fields."""
        largest: Mapping[str, Mapping[str, float]] = self._largest
        phase = {"max": max(largest["phase"].values()), "final": self._phase}
        return {"errors": self.errors, "closure": largest["closure"], "phase": phase, "drive": largest["drive"]}


class LinkSizes:
    """Recorder of the errors of links' rotations: largest, rms and last."""

    def __init__(self) -> None:
        self._sizes: defaultdict[str, defaultdict[str, RunningSize]] = defaultdict(lambda: defaultdict(RunningSize))

    def add(self, piece: ComparedPiece) -> None:
        for name, errors in piece.links.items():
            for quantity, error in errors.items():
                self._sizes[name][quantity].add(error, piece.samples_remaining)

    @property
    def errors(self) -> dict[str, dict[str, dict[str, float]]]:
        """Errors by link, quantity of `ROTATIONS` and measure."""
        return {name: {q: vars(running.size) for q, running in found.items()} for name, found in self._sizes.items()}


CURVE_SAMPLES, ERROR_SPANS = 361, 180  # of a curve that is drawn


def equal_spans(count: int) -> SeriesSplitter:
    """Splitter of a run into equal spans; a figure shows the largest error in each."""
    edges = np.linspace(0, count, min(ERROR_SPANS, count) + 1).astype(int)
    return SeriesSplitter([int(b - a) for a, b in pairwise(edges)])


class DrawnCurve:
    """Recorder of an error curve for a figure: the largest error in each of some equal spans."""

    def __init__(self) -> None:
        self._spans: SeriesSplitter | None = None
        self._errors: list[tuple[float, float]] = []

    def add(self, angle: Array, error: Array, samples_remaining: int) -> None:
        """Take the next errors (T,) at crank angles [rad], with the number of samples after them."""
        if self._spans is None:
            self._spans = equal_spans(len(angle) + samples_remaining)
        self._errors += [(angles.mean(), off.max()) for angles, off in self._spans.add(angle, error)]

    @property
    def angles_and_errors(self) -> tuple[Array, Array]:
        """Mean crank angle [rad] and largest error in each of the equal spans, (M,) each."""
        middles, largest = np.array(self._errors).T
        return middles, largest
