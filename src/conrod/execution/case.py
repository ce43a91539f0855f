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

from conrod.comparison.trajectory import Outcome
from conrod.engines import is_plugin
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.scenes import Scene
from conrod.scenes.scene import canonical_json

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
        misfit: quantity -> difference of predicted and measured error, what is allowed, and the crank angle [rad], of
            quantities out of what is allowed alone; None where there is none, see `ReferenceGuard`.
        signed: point -> position, velocity, acceleration -> signed errors (K, 2) at K equally spaced crank angles of
            the last turn, the first at its start.
        extremes: records of a run at its engine's limits, see `conrod.studies.limits.records`.
        payload: further findings of one study, plain values that only this study reads; saved as `beside`.
    """

    outcome: str
    reason: str = ""
    errors: Mapping[str, Mapping[str, Sizes]] | None = None
    closure: Sizes | None = None
    phase: Sizes | None = None
    drive: Sizes | None = None
    prediction: Mapping[str, Sizes] | None = None
    misfit: Mapping[str, Sizes] | None = None
    signed: Mapping[str, Mapping[str, list[list[float]]]] | None = None
    extremes: Mapping[str, Any] | None = None
    payload: Mapping[str, Any] | None = None

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity over the observed points; None unless the run completed."""
        # `max` would pass over what is no number.
        found = [point[quantity][measure] for point in (self.errors or {}).values()]
        return float(np.max(found)) if found else None

    def signed_errors(self, point: str, quantity: str) -> Array:
        """Signed errors (K, 2) of a point; ValueError unless the run completed."""
        if self.signed is None:
            raise ValueError(f"a run that ended as {self.outcome!r} has no errors")
        return np.asarray(self.signed[point][quantity], dtype=float)


def contradictions(misfit: Mapping[str, Sizes]) -> dict[str, Sizes]:
    """Return the quantities whose measured errors the constraint violations do not explain."""
    return {name: found for name, found in misfit.items() if not found["difference"] <= found["allowed"]}


# Raised when the measurement of the same run would come out otherwise, or mean something else, than before.
RESULT_VERSION = 1


def identity_digest(text: str) -> str:
    """Digest of an identity's canonical text, 32 hexadecimal digits."""
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Case(ABC):
    """A run of a scene, in any process on any machine, whose result a ledger can keep.

    Attributes:
        name: name of the scene, for people; not part of the key.
    """

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

    @abstractmethod
    def perform(self) -> Measurement:
        """Run the case in the calling process and return its measurement.

        Raises:
            InvalidInput: the case cannot be run for a reason that a user can mend.
        """

    @abstractmethod
    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        """All values that determine the result, with these parameters in place of the scene's."""

    def identity(self) -> dict[str, Any]:
        """All values that determine the result, in plain types; the key is made from them."""
        return self._identity(self.scene.identity())

    def can_read(self, measurement: Measurement) -> bool:
        """Return whether this conrod can read a measurement, which another version may have kept."""
        try:
            Outcome.from_slug(measurement.outcome)
            self._check_readable(measurement)
        except (InvalidInput, KeyError, TypeError):
            return False
        return True

    def _check_readable(self, measurement: Measurement) -> None:  # noqa: B027  most studies read a measurement as it is
        """Read the parts that studies of this case read; raise the errors that `can_read` catches."""

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
Results = Mapping[str, Measurement]  # by the key of the case
# Yields the cases that it needs next, is sent the results of all of them, returns its findings.
Study = Generator[Sequence[Case], Results, Found]


def pursue(studies: Sequence[Study[Found]], run: Callable[[list[Any]], Results]) -> list[Found]:
    """Run all studies side by side and return their findings; each round's cases are one batch.

    The cases asked for depend on nothing but the results: the same studies on a ledger that has them run nothing.

    One batch a round, so that no core waits for another study.

    Args:
        run: returns the results of cases; each case is given once a round.
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
