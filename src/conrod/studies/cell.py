"""One run that a study asks for, and the key under which its result is kept."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from conrod.engines import engine_named
from conrod.scenes import Scene
from conrod.scenes.scene import CANONICAL
from conrod.trajectory import Settings

# Raised when a measurement of the same run would come out otherwise, or mean something else, than before.
RESULT_VERSION = 1
REVOLUTIONS = 2.0
# Every number of steps in the grids is a multiple of this, so that signed errors are kept at angles that all share.
SIGNED_ANGLES = 20


@dataclass(frozen=True)
class Cell:
    """A run of a scene: what determines its result, and the name by which people know the scene.

    Attributes:
        name: of the scene, for people; not part of the key.
        signed_angles: equally spaced crank angles of the last turn at which signed errors are kept.
    """

    name: str
    scene: Scene = field(repr=False)
    settings: Settings
    revolutions: float = REVOLUTIONS
    start_angle: float = 0.0  # [rad]
    signed_angles: int = SIGNED_ANGLES

    def identity(self) -> dict[str, Any]:
        """All that determines the result, as plain values; the preset's name does not."""
        return self._identity(self.scene.identity())

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        # Fields that settings gained later are not in it where they are as they always were: keys stay what they were.
        settings = self.settings.as_dict()
        del settings["preset"]
        return {
            "result_version": RESULT_VERSION,
            "scene": self.scene.kind,
            "parameters": parameters,
            "engine": self.settings.engine,
            "engine_version": engine_named(self.settings.engine).version,
            "settings": settings,
            "revolutions": self.revolutions,
            "start_angle": self.start_angle,
            "signed_angles": self.signed_angles,
        }

    @cached_property
    def key(self) -> str:
        """Identity in 32 hexadecimal digits: equal for equal runs, in any process on any machine."""
        # The scene's part is a long text that is the same for all its cells.
        text = CANONICAL.encode(self._identity(None))
        text = text.replace('"parameters":null', f'"parameters":{self.scene.parameters_text}', 1)
        return hashlib.sha256(text.encode()).hexdigest()[:32]
