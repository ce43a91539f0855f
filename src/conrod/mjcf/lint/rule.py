"""What a rule is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.finding import Finding, Note


@dataclass(frozen=True)
class Rule:
    """One thing that is looked for.

    Attributes:
        name: for the command line and for results.
        judge: looks at a model on the bench.
        needs_motion: whether it needs a run that does not break.
    """

    name: str
    judge: Callable[[Bench], Iterator[Finding | Note]]
    needs_motion: bool = True
