"""Studies: generators that ask for cases batch by batch, and are answered from the ledger or by an executor."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from typing import Any, TypeVar

from conrod.studies.frame.case import Case
from conrod.studies.frame.measurement import Measurement

Found = TypeVar("Found")
Results = Mapping[str, Measurement]  # by the key of the case
# Yields the cases that it needs next, is sent the results of all of them, returns its findings.
Study = Generator[Sequence[Case], Results, Found]


def pursue(studies: Sequence[Study[Found]], run: Callable[[list[Any]], Results]) -> list[Found]:
    """Findings of all studies; their cases of one round are one batch, so that no core waits for another study.

    The cases asked for depend on nothing but the results: the same studies on a ledger that has them run nothing.

    Args:
        run: results of cases, each of which is given once a round.
    """
    found: dict[int, Found] = {}
    waiting: dict[int, Sequence[Case]] = {}

    def advance(k: int, results: Results | None) -> None:
        try:
            waiting[k] = next(studies[k]) if results is None else studies[k].send(results)
        except StopIteration as end:
            waiting.pop(k, None)
            found[k] = end.value

    for k in range(len(studies)):
        advance(k, None)
    while waiting:
        asked = dict(waiting)
        results = run(list({case.key: case for cases in asked.values() for case in cases}.values()))
        for k, cases in asked.items():
            advance(k, {case.key: results[case.key] for case in cases})
    return [found[k] for k in range(len(studies))]
