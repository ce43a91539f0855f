"""One run that a study asks for, and the key under which its result is kept."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

from conrod.engines import engine_named
from conrod.engines.engine import run_of
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.scenes.scene import CANONICAL

# Raised when a measurement of the same run would come out otherwise, or mean something else, than before.
RESULT_VERSION = 1
REVOLUTIONS = 2.0
# Every number of steps in the grids is a multiple of this, so that signed errors are kept at angles that all share.
SIGNED_ANGLES = 20
LEAST_STEPS = 3  # of a run: before the first acceleration that is a difference of velocities


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


AnyCell = TypeVar("AnyCell", bound=Cell)


def as_run(cell: AnyCell) -> AnyCell:
    """The cell with the stretch that is run: of an input that cannot turn fully its one pass, whatever is asked."""
    if cell.scene.kinematics.mechanism.driver.span is None:
        return cell
    start, revolutions = run_of(cell.scene, cell.settings.steps_per_revolution, cell.revolutions)
    return replace(cell, start_angle=start, revolutions=revolutions)


def too_coarse(cell: Cell) -> str | None:
    """None, or why the one pass of an input that cannot turn fully is not run with so few steps.

    Args:
        cell: with the stretch that is run, see `as_run`.
    """
    taken = round(cell.settings.steps_per_revolution * cell.revolutions)
    if cell.scene.kinematics.mechanism.driver.span is None or taken >= LEAST_STEPS:
        return None
    return (
        f"the pass is {taken} steps long at {cell.settings.steps_per_revolution} steps a revolution; "
        f"{LEAST_STEPS} are needed to have accelerations"
    )
