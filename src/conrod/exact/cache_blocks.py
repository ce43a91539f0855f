"""Long series in pieces whose intermediate arrays stay in a core's own cache, which is faster than all at once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

KEPT = 1 << 20  # numbers, 8 MB


def chunks(count: int, length: int) -> Iterator[slice]:
    """Slices of at most `length` that cover a series of `count` samples, in order; an empty one if it has none."""
    _let_memory_be_kept()
    for first in range(0, max(count, 1), length):
        yield slice(first, min(first + length, count))


def _let_memory_be_kept() -> None:
    """Have intermediate arrays of a piece take the memory of those of the piece before.

    The GNU C library hands freed memory back to the system at once, and has it cleared page by page when it is next
    needed, which takes as long as the arithmetic; but it keeps up to twice the largest block that was ever freed.
    """
    block = np.empty(KEPT)
    del block
