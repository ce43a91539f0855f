"""Searches that ask for runs, batch by batch, and are answered from the ledger or by the executor."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from typing import TypeVar

from conrod.studies.frame.measurement import Measurement
from conrod.studies.limits.cell import LimitCell

Found = TypeVar("Found")
Answers = Mapping[str, Measurement]  # key of a cell -> what it showed
# Yields the runs it wants next, is sent what all of them showed, returns what it found.
Search = Generator[Sequence[LimitCell], Answers, Found]


def pursue(searches: Sequence[Search[Found]], run: Callable[[list[LimitCell]], Answers]) -> list[Found]:
    """What all searches find; their wishes of one round are one batch, so that no core waits for another search.

    The runs asked for depend on nothing but the answers: the same searches on a ledger that has them run nothing.
    """
    found: dict[int, Found] = {}
    wishes: dict[int, Sequence[LimitCell]] = {}

    def advance(k: int, answers: Answers | None) -> None:
        try:
            wishes[k] = next(searches[k]) if answers is None else searches[k].send(answers)
        except StopIteration as end:
            wishes.pop(k, None)
            found[k] = end.value

    for k in range(len(searches)):
        advance(k, None)
    while wishes:
        wanted = dict(wishes)
        answers = run(list({cell.key: cell for cells in wanted.values() for cell in cells}.values()))
        for k, cells in wanted.items():
            advance(k, {cell.key: answers[cell.key] for cell in cells})
    return [found[k] for k in range(len(searches))]
