"""Why a table is off: what people commonly get wrong, each named only where undoing it makes the difference go away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from conrod.errors import InvalidInput
from conrod.own.tables.alignment import Alignment
from conrod.own.tables.error_hypotheses import ideas
from conrod.own.tables.judging import largest, table_errors
from conrod.own.tables.samples import Observed
from conrod.scenes import Scene

# A cause reproduces a difference where no more than this share of it is left once the cause is undone; of a difference
# beyond L itself, than this share of L.
LEFT = 0.05
MUCH_LESS, ALL = 0.1, 1e-6
# Rows that causes are looked for in, evenly spread: plenty to tell a twentieth.
MOST_ROWS = 5_000


@dataclass(frozen=True)
class Cause:
    """A likely cause.

    Attributes:
        kind: in a word or two, the same for all tables.
        text: with its size.
        explains: name of an error -> its largest value as it is, and with the cause undone.
    """

    kind: str
    text: str
    explains: Mapping[str, tuple[float, float]]


def likely_causes(observed: Observed, scene: Scene, alignment: Alignment, wrong: Sequence[str]) -> tuple[Cause, ...]:
    """Causes that reproduce what is wrong: those that explain most first, then those that leave least.

    Args:
        wrong: names of the errors that are to be explained.
    """
    rows = observed.thinned(MOST_ROWS)
    errors = table_errors(rows, scene, alignment)
    before = {name: size for name in wrong if (size := largest(errors, name))}
    found: dict[str, Cause] = {}
    for idea in ideas(rows, scene, alignment, tuple(before)):
        try:
            left = table_errors(idea.observed, scene, idea.alignment)
        except InvalidInput:
            continue  # the linkage does not come to where the crank would then be
        explains = {}
        for name, size in before.items():
            after = largest(left, name) if name in idea.concerns else None
            if after is not None and after <= LEFT * min(size, 1.0):
                explains[name] = (size, after)
        cause = Cause(idea.kind, idea.text, explains)
        # Of one kind the first is the simplest: another one must leave far less.
        if explains and (idea.kind not in found or _left(cause) < MUCH_LESS * _left(found[idea.kind])):
            found[idea.kind] = cause
    ranked = sorted(found.values(), key=lambda cause: (-len(cause.explains), _left(cause)))
    return tuple(cause for place, cause in enumerate(ranked) if not _beaten(cause, ranked[:place]))


def _beaten(cause: Cause, better: Sequence[Cause]) -> bool:
    """Whether others explain all that a cause does, and leave far less of it."""
    return all(
        any(name in b.explains and _left(b) < MUCH_LESS * _left(cause) for b in better) for name in cause.explains
    )


def _left(cause: Cause) -> float:
    """The share that is left; below a part in a million all is explained, and which leaves less is rounding."""
    return max(ALL, *(after / before for before, after in cause.explains.values()))
