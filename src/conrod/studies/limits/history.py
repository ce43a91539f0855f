"""A long run at the end of some of its revolutions."""

from __future__ import annotations

from conrod.motion import Array
from conrod.studies.limits.extremes import Mark

SHORT = 2.0  # revolutions of a run that needs no history
DECADE = (1, 2, 5)


def marked(revolutions: float) -> tuple[int, ...]:
    """1, 2, 5, 10, 20, .. and the last revolution that is completed; none of a short run."""
    if revolutions <= SHORT:
        return ()
    last = int(revolutions)
    series = (digit * 10**power for power in range(len(str(last))) for digit in DECADE)
    return (*(mark for mark in series if mark < last), last)


class History:
    """Marks of a run of which samples come in order, however many at a time."""

    def __init__(self, revolutions: float, steps_per_revolution: int) -> None:
        self.marks: list[Mark] = []
        self._steps = steps_per_revolution
        self._due = list(marked(revolutions))
        self._position = self._closure = 0.0

    @property
    def goes_on(self) -> bool:
        """Whether a mark is still to come."""
        return bool(self._due)

    def add(self, first: int, position: Array, closure: Array, phase: Array, clock: Array) -> None:
        """Take in the samples from the one of an index on; each argument (T,), as `Mark` has them."""
        begin, end = 0, len(position)
        while self._due and begin < end:
            at = self._due[0] * self._steps - first  # place of the mark's sample
            rows = slice(begin, min(at + 1, end))
            self._position = max(self._position, float(position[rows].max()))
            self._closure = max(self._closure, float(closure[rows].max()))
            if at < end:
                mark = Mark(self._due.pop(0), self._position, self._closure, float(phase[at]), float(clock[at]))
                self.marks.append(mark)
                self._position = self._closure = 0.0
            begin = rows.stop
