"""Results of very many finished cases, read from the ledger block by block when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Any

from conrod.execution.case import Case

# Results are read this many at a time: each takes some ten kB. Whoever goes through all cases in order reads each once.
RESULTS_AT_ONCE, BLOCKS_IN_MEMORY = 1000, 2


class KeptResults(Mapping[str, Any]):
    """Results of finished cases by key, read when looked up; only recent blocks stay in memory."""

    def __init__(self, cases: Mapping[str, Case], read: Callable[[Mapping[str, Case]], Mapping[str, Any]]) -> None:
        """Read nothing yet.

        Args:
            cases: the cases by key, in the order in which their results are expected to be asked for.
            read: returns the results of some of them.
        """
        keys = list(cases)
        self._blocks = {key: k // RESULTS_AT_ONCE for k, key in enumerate(keys)}

        def read_block(block: int) -> Mapping[str, Any]:
            first = block * RESULTS_AT_ONCE
            return read({key: cases[key] for key in keys[first : first + RESULTS_AT_ONCE]})

        self._read_block = lru_cache(BLOCKS_IN_MEMORY)(read_block)

    def __getitem__(self, key: str) -> Any:
        return self._read_block(self._blocks[key])[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._blocks)

    def __len__(self) -> int:
        return len(self._blocks)
