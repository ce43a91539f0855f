"""Cases, measurements and studies: a run that determines its result, and generators that ask for runs batch by batch.

A study is answered from the ledger or by an executor.
"""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar

import numpy as np

from conrod.engines import is_plugin
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.scenes.scene import canonical_json

QUANTITIES = ("position", "velocity", "acceleration")
MEASURES = ("max", "rms", "final")
Sizes = Mapping[str, float]


@dataclass(frozen=True)
class Measurement:
    """Outcome and, of a completed run alone, its errors; all normalised as docs/design.md says.

    Attributes:
        errors: point -> position, velocity, acceleration, total -> max, rms, final.
        closure: largest gap of a joint, its rate and its acceleration.
        phase: max and final [rad].
        drive: speed and acceleration.
        prediction: quantity -> largest error predicted from the joints alone, and its largest difference from the
            measured one.
        signed: point -> position, velocity, acceleration -> signed errors (K, 2) at K equally spaced crank angles of
            the last turn, the first at its start.
        extremes: what was watched of a run at its engine's limits, see `conrod.studies.limits.records`.
        beside: what a study's own task found besides; plain values that this study alone reads.
    """

    outcome: str
    reason: str = ""
    errors: Mapping[str, Mapping[str, Sizes]] | None = None
    closure: Sizes | None = None
    phase: Sizes | None = None
    drive: Sizes | None = None
    prediction: Mapping[str, Sizes] | None = None
    signed: Mapping[str, Mapping[str, list[list[float]]]] | None = None
    extremes: Mapping[str, Any] | None = None
    beside: Mapping[str, Any] | None = None

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity over the observed points; None unless the run completed."""
        # `max` would pass over what is no number.
        found = [point[quantity][measure] for point in (self.errors or {}).values()]
        return float(np.max(found)) if found else None

    def signed_of(self, point: str, quantity: str) -> Array:
        """Signed errors (K, 2) of a point; ValueError unless the run completed."""
        if self.signed is None:
            raise ValueError(f"a run that ended as {self.outcome!r} has no errors")
        return np.asarray(self.signed[point][quantity], dtype=float)


# Raised when the measurement of the same run would come out otherwise, or mean something else, than before.
RESULT_VERSION = 1


def key_of(text: str) -> str:
    """Canonical text of an identity in 32 hexadecimal digits."""
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Case(ABC):
    """Something to be run on a scene, in any process on any machine, with a result that a ledger can keep.

    Attributes:
        name: of the scene, for people; not part of the key.
    """

    name: str
    scene: Scene = field(repr=False)
    _key: ClassVar[str] = ""

    @property
    def engine_name(self) -> str | None:
        """Name of the engine that it runs in; None of no engine."""
        return None

    @property
    def brought_engine(self) -> str | None:
        """That name where the engine is another package's, which may do anything to its process; else None."""
        name = self.engine_name
        return name if name is not None and is_plugin(name) else None

    @property
    def effort(self) -> float:
        """Estimated duration relative to other cases: those that take long begin first."""
        return 0.0

    @abstractmethod
    def perform(self) -> Measurement:
        """The result, in the process that calls.

        Raises:
            InvalidInput: the case cannot be run for a reason that a user can mend.
        """

    @abstractmethod
    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        """All that determines the result, with the scene's parameters as they are given here."""

    def identity(self) -> dict[str, Any]:
        """All that determines the result, as plain values."""
        return self._identity(self.scene.identity())

    def understands(self, measurement: Measurement) -> bool:
        """False of a measurement that another conrod kept in a form that this one cannot read."""
        try:
            Outcome.from_slug(measurement.outcome)
            self._read(measurement)
        except (InvalidInput, KeyError, TypeError):
            return False
        return True

    def _read(self, measurement: Measurement) -> None:  # noqa: B027  most studies read a measurement as it is
        """Read what a study of such cases will; errors as `understands` catches."""

    @property
    def labels(self) -> dict[str, str]:
        """Names for people that a ledger keeps beside the identity; they change neither key nor result."""
        return {}

    @property
    def key(self) -> str:
        """Identity in 32 hexadecimal digits: equal for equal runs, in any process on any machine."""
        # Kept, but not by `cached_property`, whose lock and a dictionary for each case take time (docs/benchmarks.md).
        if not self._key:
            # The scene's part is a long text that is the same for all its cases.
            text = canonical_json(self._identity(None))
            text = text.replace('"parameters":null', f'"parameters":{self.scene.parameters_text}', 1)
            object.__setattr__(self, "_key", key_of(text))
        return self._key


# -- studies ---------------------------------------------------------------------------------------------------------

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
