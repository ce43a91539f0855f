"""Recorders of a run that comes in stretches: what they find does not depend on how it was cut, bit for bit.

None keeps samples but those that it reports, and a small part of a run that waits for its rest.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from conrod.exact.motion import Array
from conrod.runs.comparison import QUANTITIES, Size, Stretch


class Recorder(Protocol):
    """Receiver of the stretches of a run, in their order, as long as it is in one piece."""

    def add(self, stretch: Stretch) -> None: ...


class Parts:
    """Series that come in pieces, cut anew into parts of given lengths."""

    def __init__(self, lengths: Iterable[int]) -> None:
        self._lengths = deque(lengths)
        self._held: list[tuple[Array, ...]] = []
        self._count = 0

    def add(self, *series: Array) -> Iterator[tuple[Array, ...]]:
        """Take in what follows of each series, and yield the parts that are whole."""
        self._held.append(series)
        self._count += len(series[0])
        while self._lengths and self._count >= self._lengths[0]:
            length = self._lengths.popleft()
            whole = self.held()
            yield tuple(one[:length] for one in whole)
            self._held, self._count = [tuple(one[length:] for one in whole)], self._count - length

    def held(self) -> tuple[Array, ...]:
        """Samples that wait for the rest of their part."""
        return self._held[0] if len(self._held) == 1 else tuple(map(np.concatenate, zip(*self._held, strict=True)))


TOGETHER = 4096  # numbers that are added up at once


def halves(count: int) -> list[int]:
    """Lengths of the parts of so many numbers whose sums `paired` puts together."""
    first = count // 2 - count // 2 % 8
    return [count] if count <= TOGETHER else halves(first) + halves(count - first)


def paired(count: int, sums: Iterator[float]) -> float:
    """The sum of so many numbers from those of their parts, in numpy's order (pairwise), and so with its last bit."""
    first = count // 2 - count // 2 % 8
    return next(sums, 0.0) if count <= TOGETHER else paired(first, sums) + paired(count - first, sums)


class RunningSize:
    """Max, rms and final value of one series."""

    def __init__(self) -> None:
        self._parts: Parts | None = None
        self._whole = self._count = 0
        self._squares: list[float] = []
        self._largest = self._final = 0.0

    def add(self, values: Array, left: int) -> None:
        """Take in what follows (T,), not negative, of which so many come after it."""
        if len(values) == 0:
            return
        if self._parts is None:
            self._whole = len(values) + left
            self._parts = Parts(halves(self._whole))
        # `max` would pass over what is no number.
        self._largest, self._final = float(np.maximum(self._largest, values.max())), float(values[-1])
        self._count += len(values)
        self._squares += [float(np.sum(part**2)) for (part,) in self._parts.add(values)]

    @property
    def size(self) -> Size:
        """That of all so far; raises ValueError if there is nothing."""
        if self._parts is None:
            raise ValueError("no sample, no error")
        known = iter(self._squares)
        squares = paired(self._whole, known) if len(self._squares) > 1 else next(known, 0.0)
        rest = sum(known) + float(np.sum(self._parts.held()[0] ** 2))  # of a run that did not come to its end
        return Size(self._largest, float(np.sqrt((squares + rest) / self._count)), self._final)


class PointSizes:
    """Errors of the observed points: max, rms, final."""

    def __init__(self) -> None:
        self._sizes: defaultdict[str, defaultdict[str, RunningSize]] = defaultdict(lambda: defaultdict(RunningSize))

    def add(self, stretch: Stretch) -> None:
        for name, errors in stretch.points.items():
            for quantity in QUANTITIES:
                self._sizes[name][quantity].add(getattr(errors, quantity).error, stretch.left)

    @property
    def errors(self) -> dict[str, dict[str, dict[str, float]]]:
        """By point, quantity and measure."""
        return {name: {q: vars(running.size) for q, running in found.items()} for name, found in self._sizes.items()}

    def worst(self, quantity: str) -> float | None:
        """Largest error of a quantity over all points; None where there was nothing to compare."""
        found = [sizes[quantity]["max"] for sizes in self.errors.values()]
        return float(np.max(found)) if found else None


class RunErrors(PointSizes):
    """All errors of a run, by their names in a measurement."""

    def __init__(self) -> None:
        super().__init__()
        self._largest: defaultdict[str, dict[str, float]] = defaultdict(dict)
        self._phase: float  # of the last sample

    def add(self, stretch: Stretch) -> None:
        super().add(stretch)
        phase = {str(k): one for k, one in enumerate(stretch.phase)}
        for kind, series in (("closure", stretch.closure), ("drive", stretch.drive), ("phase", phase)):
            known = self._largest[kind]
            for name, values in series.items():
                known[name] = float(np.max(values, initial=known.get(name, 0.0)))
        self._phase = float(stretch.phase[0][-1])

    def found(self) -> dict[str, Any]:
        """Errors, closure, phase and drive."""
        largest: Mapping[str, Mapping[str, float]] = self._largest
        phase = {"max": max(largest["phase"].values()), "final": self._phase}
        return {"errors": self.errors, "closure": largest["closure"], "phase": phase, "drive": largest["drive"]}


CURVE_SAMPLES, ERROR_SPANS = 361, 180  # of a curve that is drawn


def largest_in_spans(count: int) -> Parts:
    """Parts of so many samples: equal spans of a run, of which a figure shows the largest error."""
    edges = np.linspace(0, count, min(ERROR_SPANS, count) + 1).astype(int)
    return Parts([int(b - a) for a, b in pairwise(edges)])


class DrawnCurve:
    """Errors for a figure: the largest in each of some equal spans."""

    def __init__(self) -> None:
        self._spans: Parts | None = None
        self._errors: list[tuple[float, float]] = []

    def add(self, angle: Array, error: Array, left: int) -> None:
        """Take in the errors (T,) that follow, at crank angles [rad]; so many samples come after them."""
        if self._spans is None:
            self._spans = largest_in_spans(len(angle) + left)
        self._errors += [(angles.mean(), off.max()) for angles, off in self._spans.add(angle, error)]

    @property
    def arrays(self) -> tuple[Array, Array]:
        """Mean angles [rad] and largest errors of the spans, each (M,)."""
        middles, largest = np.array(self._errors).T
        return middles, largest
