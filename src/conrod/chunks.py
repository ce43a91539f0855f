"""Long series in pieces whose intermediate arrays stay in a core's own cache, which is faster than all at once."""

from __future__ import annotations

from collections.abc import Iterator


def chunks(count: int, length: int) -> Iterator[slice]:
    """Slices of at most `length` that cover a series of `count` samples, in order; an empty one if it has none."""
    for first in range(0, max(count, 1), length):
        yield slice(first, min(first + length, count))
