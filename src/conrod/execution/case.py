"""Cases, results and studies: a run that determines its result, and generators that ask for runs batch by batch.

A study is answered from the ledger or by an executor.
"""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, ClassVar, Self, TypeVar

from conrod.comparison.plain_values import restore
from conrod.comparison.trajectory import Outcome
from conrod.engines import is_plugin
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.scenes.scene import canonical_json

OUTCOMES = {outcome.slug: outcome for outcome in Outcome}
SIZES = "sizes"  # saved with a result: its largest errors by quantity and measure, see `CaseResult.sizes`
FAILURE_FIELDS = {"outcome", "reason", SIZES}  # all that is kept of a case whose process gave no result
MEASURES = ("max", "rms", "final")
# Results are read this many at a time: each takes some ten kB. Whoever goes through all cases in order reads each once.
RESULTS_AT_ONCE, BLOCKS_IN_MEMORY = 1000, 2
MIN_PASS_STEPS = 3  # fewer steps have no acceleration that is a difference of velocities
POINTS_PREFIX = "points'"  # of the names of misfits of points with their bodies
Sizes = Mapping[str, float]

# Raised when a result of the same case would come out otherwise, mean something else or be written otherwise than
# before: each ledger of an older version is emptied.
CACHE_VERSION = 4


@dataclass(frozen=True)
class CaseResult:
    """The result of a case, by one class in memory, in a ledger and in JSON; each study extends it.

    Attributes:
        outcome: slug of an `Outcome`; errors are those of a completed run alone.
        reason: why it ended so, in words.
    """

    quantities: ClassVar[tuple[str, ...]] = ()  # whose errors stand in the table of all runs
    measures: ClassVar[tuple[str, ...]] = MEASURES

    outcome: str = Outcome.COMPLETED.slug
    reason: str = ""

    @property
    def completed(self) -> bool:
        """True if the run came to its end."""
        return self.outcome == Outcome.COMPLETED.slug

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity; None if the quantity has no error."""
        return None

    def sizes(self) -> dict[str, dict[str, float]]:
        """Largest errors, by quantity and measure, for the table of all runs."""
        found = {
            q: {m: size for m in self.measures if (size := self.largest(q, m)) is not None} for q in self.quantities
        }
        return {quantity: sizes for quantity, sizes in found.items() if sizes}


def contradictions(misfit: Mapping[str, Sizes]) -> dict[str, Sizes]:
    """Return the quantities whose measured errors the constraint violations do not explain."""
    return {name: found for name, found in misfit.items() if not found["difference"] <= found["allowed"]}


def identity_digest(text: str) -> str:
    """Digest of an identity's canonical text, 32 hexadecimal digits."""
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Case(ABC):
    """A run of a scene, in any process on any machine, whose result a ledger can keep.

    Attributes:
        name: name of the scene, for people; not part of the key.
    """

    study: ClassVar[str]  # name of the study that makes the case, for the table of all runs
    result_type: ClassVar[type[CaseResult]]

    name: str
    scene: Scene = field(repr=False)
    _key: ClassVar[str] = ""

    @property
    def engine_name(self) -> str | None:
        """Name of the engine that runs the case; None if no engine does."""
        return None

    @property
    def plugin_name(self) -> str | None:
        """Name of the engine if it comes from another package, and so may harm its process; else None."""
        name = self.engine_name
        return name if name is not None and is_plugin(name) else None

    @property
    def effort(self) -> float:
        """Estimated duration relative to other cases; the longest cases start first."""
        return 0.0

    # What cases of a scene would each compute alike: a function that can be pickled, and its arguments. It is called
    # once, in one of the processes, and its result is given to all of them. None if there is nothing.
    shared_call: ClassVar[Callable[..., Any] | None] = None

    @property
    def shared_arguments(self) -> tuple[Any, ...]:
        """Arguments of `shared_call`, which tell whether two cases share its result."""
        return ()

    def with_shared(self, result: Any) -> Self:
        """Return the case with the result of `shared_call`."""
        return self

    @abstractmethod
    def perform(self) -> CaseResult:
        """Run the case in the calling process and return its result.

        Raises:
            InvalidInput: the case cannot be run for a reason that a user can mend.
        """

    def failed_result(self, outcome: Outcome, reason: str) -> CaseResult:
        """Return the result of a case whose process ended without giving one."""
        return self.result_type(outcome.slug, reason)

    def restore_result(self, saved: Mapping[str, Any]) -> CaseResult:
        """Restore a result of this case from plain values, or from outcome and reason of a failed call.

        Raises:
            InvalidInput: the values are of another kind.
        """
        if (outcome := saved.get("outcome")) not in OUTCOMES:
            raise InvalidInput(f"saved values have the outcome {outcome!r}, which no run has")
        if saved.keys() <= FAILURE_FIELDS:
            return self.failed_result(OUTCOMES[outcome], str(saved["reason"]))
        return restore(self.result_type, saved)

    @abstractmethod
    def key_fields(self) -> dict[str, Any]:
        """Plain values that determine the result in addition to the study and the scene; part of the key."""

    def identity(self) -> dict[str, Any]:
        """All values that determine the result, in plain types; the key is made from them."""
        return self._identity(self.scene.identity())

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        """The identity with these parameters in place of the scene's."""
        named = {"cache_version": CACHE_VERSION, "study": self.study, "scene": self.scene.kind}
        return named | {"parameters": parameters} | self.key_fields()

    @property
    def labels(self) -> dict[str, str]:
        """Names for people, kept with the identity but no part of the key."""
        return {}

    @property
    def key(self) -> str:
        """Digest of the identity, 32 hexadecimal digits: equal for equal runs on any machine."""
        # Kept, but not by `cached_property`, whose lock and a dictionary for each case take time (docs/benchmarks.md).
        if not self._key:
            # The scene's part is a long text that is the same for all its cases.
            text = canonical_json(self._identity(None))
            text = text.replace('"parameters":null', f'"parameters":{self.scene.parameters_text}', 1)
            object.__setattr__(self, "_key", identity_digest(text))
        return self._key


# -- studies ---------------------------------------------------------------------------------------------------------

Found = TypeVar("Found")
Results = Mapping[str, Any]  # by the key of the case, each of its own class


class ResultsOfRounds(Mapping[str, Any]):
    """Results of cases by key, each looked up in the results of the round that made them."""

    def __init__(self, rounds: Mapping[str, Results]) -> None:
        """Take the results that have each key, by that key."""
        self._rounds = rounds

    def __getitem__(self, key: str) -> Any:
        return self._rounds[key][key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._rounds)

    def __len__(self) -> int:
        return len(self._rounds)


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


# Yields the cases that it needs next, is sent the results of all of them, returns its findings.
Study = Generator[Sequence[Case], Results, Found]


def pursue(studies: Sequence[Study[Found]], run: Callable[[list[Any]], Results]) -> list[Found]:
    """Run all studies side by side and return their findings; each round's cases are one batch.

    A study's next cases depend only on its results so far, so a ledger that has all results answers it without a run.
    One batch a round keeps all cores busy.

    Args:
        run: returns the results of cases; each case is given once a round.
    """
    found: dict[int, Found] = {}
    waiting: dict[int, Sequence[Case]] = {}

    def advance(k: int, results: Results | None) -> None:
        """Send results to study k; keep the cases that the study asks for next, or its findings."""
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
            advance(k, ResultsOfRounds({case.key: results for case in cases}))
    return [found[k] for k in range(len(studies))]
