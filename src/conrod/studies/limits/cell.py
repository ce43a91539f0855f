"""A run at an engine's limits: streamed, and watched for how it fails."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

from conrod.scenes import Scene
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.limits.declaration import Declaration, Redeclared

# Raised when what is watched for comes out otherwise, or means something else, than before.
WATCH_VERSION = 3


@dataclass(frozen=True)
class LimitCell(RunCase):
    """A run whose measurement carries `Extremes`; see `watch`.

    Attributes:
        declaration: of bodies and joints; None is the scene's own.
    """

    signed_angles: int = 0
    declaration: Declaration | None = None

    def perform(self) -> Measurement:
        from conrod.studies.limits.stream_run import watch

        return watch(self)

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        declared = None if self.declaration is None else asdict(self.declaration)
        return super()._identity(parameters) | {"watched": WATCH_VERSION, "declaration": declared}

    @cached_property
    def machine(self) -> Scene | Redeclared:
        """What is run, and what it is compared with."""
        return self.scene if self.declaration is None else Redeclared(self.scene, self.declaration)
