"""A run that determines its result: what a study asks for, and the key under which the result is kept."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from conrod.scenes import Scene
from conrod.scenes.scene import CANONICAL
from conrod.studies.frame.measurement import Measurement

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
