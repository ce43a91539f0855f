"""A run that determines its result: what a study asks for, and the key under which the result is kept."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from conrod.engines import Engine, engine_named
from conrod.runs.plain import plain, restore
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.scenes.scene import CANONICAL
from conrod.studies.frame.measurement import MEASURES, Measurement

# Raised when the measurement of the same run would come out otherwise, or mean something else, than before.
RESULT_VERSION = 1


@dataclass(frozen=True)
class Case(ABC):
    """Something to be run on a scene, in any process on any machine, with a result that a ledger can keep.

    Attributes:
        name: of the scene, for people; not part of the key.
    """

    name: str
    scene: Scene = field(repr=False)

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

    @property
    def labels(self) -> dict[str, str]:
        """Names for people that a ledger keeps beside the identity; they change neither key nor result."""
        return {}

    @cached_property
    def key(self) -> str:
        """Identity in 32 hexadecimal digits: equal for equal runs, in any process on any machine."""
        # The scene's part is a long text that is the same for all its cases.
        text = CANONICAL.encode(self._identity(None))
        text = text.replace('"parameters":null', f'"parameters":{self.scene.parameters_text}', 1)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


# -- cases of a validation, whose whole result is kept and judged when it is read ------------------------------------


class Validated(Protocol):
    """A result of a validation: a frozen dataclass.

    Attributes:
        outcome, reason: how the run ended.
        passed: the verdict; None where nothing is judged.
    """

    @property
    def outcome(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def passed(self) -> bool | None: ...
    def largest(self, quantity: str, measure: str = "max", /) -> float | None:
        """Largest error of a quantity; None where there is none."""


# Of a result, those that have a column of their own in a table of many results.
COLUMNS = ("closure", "phase", "drive", "prediction")
Found = TypeVar("Found", bound=Validated)


@dataclass(frozen=True)
class EngineCase(Case, Generic[Found]):
    """A scene in an engine with a preset.

    Tolerances that a user asks for are no part of it: what they decide is decided when a result is read.

    Attributes:
        engine: name.
        preset: name; None of kinematic mode.
    """

    study: ClassVar[str]
    kind: ClassVar[type[Any]]  # of the result
    quantities: ClassVar[tuple[str, ...]]  # whose errors a result has
    measures: ClassVar[tuple[str, ...]] = MEASURES
    version: ClassVar[int] = 1  # raised when the same run would come out otherwise, or mean something else

    engine: str
    preset: str | None

    @property
    def made_by(self) -> Engine[Any]:
        """The engine itself."""
        return engine_named(self.engine)

    @abstractmethod
    def run(self) -> Found:
        """The result, judged by what the study requires of its own accord; raises InvalidInput as `perform`."""

    @abstractmethod
    def ended(self, outcome: Outcome, reason: str) -> Found:
        """The result where the process that ran the case did not live to give one."""

    @abstractmethod
    def judged(self, found: Found) -> Found:
        """The result with the verdict by the tolerances that are asked for."""

    @abstractmethod
    def determined_by(self) -> dict[str, Any]:
        """All besides scene, engine and preset that determines the result, as plain values."""

    def facts(self) -> dict[str, Any]:
        """Fields of the result that the case gives: equal machines may have other names."""
        return {"scene": self.name, "parameters": self.scene.parameters}

    def perform(self) -> Measurement:
        found = self.run()
        sizes = {
            q: {m: size for m in self.measures if (size := found.largest(q, m)) is not None} for q in self.quantities
        }
        kept = {"sizes": sizes, "passed": found.passed, "result": plain(found)}
        columns = {name: getattr(found, name, None) for name in COLUMNS}
        return Measurement(found.outcome, found.reason, **columns, beside=kept)

    def _sizes(self, found: Found, quantity: str) -> dict[str, float]:
        sizes = {measure: found.largest(quantity, measure) for measure in self.measures}
        return {measure: size for measure, size in sizes.items() if size is not None}

    def result(self, measurement: Measurement) -> Found:
        """The result that a measurement of this case holds, judged by the tolerances that are asked for.

        Raises:
            InvalidInput: the measurement is of another kind.
        """
        if measurement.beside is None:
            return self.ended(Outcome.of(measurement.outcome), measurement.reason)
        found: Any = restore(self.kind, measurement.beside["result"])
        return self.judged(replace(found, **self.facts()))

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return {
            "result_version": RESULT_VERSION,
            "study": self.study,
            "study_version": self.version,
            "scene": self.scene.kind,
            "parameters": parameters,
            "engine": self.engine,
            "engine_version": self.made_by.version,
            "preset": self.preset,
            **self.determined_by(),
        }
