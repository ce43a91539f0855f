"""Refinement families: one setting at ever finer steps, along a path that says what follows the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from conrod.engines import engine_named
from conrod.engines.capabilities import variations_of
from conrod.engines.rule import STEPS
from conrod.engines.variations import Variations
from conrod.errors import InvalidInput
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.run import SIGNED_ANGLES, RunCase

# The step alone is refined, all softness stays as it is in seconds; or softness keeps its size in steps.
Path = Literal["step alone", "step with softness"]
PATHS: tuple[Path, ...] = ("step alone", "step with softness")

# Steps per revolution: those of a sweep, so that both share their runs.
GRIDS = STEPS["default"]

LEAST_ROUNDING = 1e-13  # of normalised errors


@dataclass(frozen=True)
class Family:
    """One setting at several steps.

    Attributes:
        label: of the setting that it started from, such as a preset's name.
        cells: with increasing numbers of steps per revolution.
    """

    label: str
    path: Path
    cells: tuple[RunCase, ...]

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.cells[0].settings.engine

    @property
    def scene(self) -> Scene:
        """The scene that all cells run."""
        return self.cells[0].scene


def family_of(name: str, scene: Scene, settings: Settings, path: Path, steps: Sequence[int] = GRIDS) -> Family:
    """The cells of a refinement.

    Args:
        name: of the scene.
        settings: where the path starts from; on it, softness in seconds is that of these settings.
        steps: per revolution, increasing, multiples of the number of angles at which signed errors are kept.

    Raises:
        InvalidInput: steps that do not increase, or at which the kept angles have no sample.
    """
    if list(steps) != sorted(set(steps)) or any(n < SIGNED_ANGLES or n % SIGNED_ANGLES for n in steps):
        raise InvalidInput(f"steps = {tuple(steps)} must increase and be multiples of {SIGNED_ANGLES}")
    cells = tuple(RunCase(name, scene, refined(scene, settings, n, path)) for n in steps)
    return Family(settings.preset, path, cells)


def refined(scene: Scene, settings: Settings, steps: int, path: Path = "step alone") -> Settings:
    """The same settings at another number of steps per revolution.

    Raises:
        InvalidInput: settings of an engine that is not in the table.
    """
    variations: Variations[Any] = variations_of(engine_named(settings.engine))
    found: Settings = variations.refined(scene, settings, steps, softness_follows=path == "step with softness")
    return found


def rounding_level(steps: int) -> float:
    """Normalised error that is rounding: two turns' steps may sum a last digit each."""
    return max(LEAST_ROUNDING, 2.0 * steps * float(np.finfo(float).eps))
