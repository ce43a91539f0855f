"""Refinement families: one setting at ever finer steps, along a path that says what follows the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from conrod.engines.engine import step_length
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.cell import SIGNED_ANGLES, Cell
from conrod.trajectory import Settings

# The step alone is refined, all softness stays as it is in seconds; or softness keeps its size in steps.
Path = Literal["step alone", "step with softness"]
PATHS: tuple[Path, ...] = ("step alone", "step with softness")

# Steps per revolution: multiples of the angles at which signed errors are kept, near enough to equal ratios.
GRIDS = tuple(SIGNED_ANGLES * k for k in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000))

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
    cells: tuple[Cell, ...]

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.cells[0].settings.engine

    @property
    def scene(self) -> Scene:
        """The scene that all cells run."""
        return self.cells[0].scene

    @cached_property
    def fixed(self) -> dict[str, Any]:
        """Settings that are the same at every step, as plain values."""
        return {k: v for k, v in self._settings[0].items() if k not in self.following}

    @cached_property
    def following(self) -> tuple[str, ...]:
        """Names of the settings that change with the step."""
        first = self._settings[0]
        return tuple(k for k in first if any(settings[k] != first[k] for settings in self._settings[1:]))

    @cached_property
    def _settings(self) -> list[dict[str, Any]]:
        return [{k: v for k, v in cell.settings.as_dict().items() if k != "preset"} for cell in self.cells]


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
    cells = tuple(Cell(name, scene, refined(scene, settings, n, path)) for n in steps)
    return Family(settings.preset, path, cells)


def refined(scene: Scene, settings: Settings, steps: int, path: Path = "step alone") -> Settings:
    """The same settings at another number of steps per revolution.

    MuJoCo's softness is the time constant of its constraints, pymunk's the share of an error that is left after a
    second; a slop is the way fallen in a step, and follows its square. MuJoCo itself raises a time constant below
    two steps to two steps, whatever is asked of it.

    Raises:
        TypeError: settings of an engine whose softness is not known here.
    """
    h = step_length(scene, steps)
    match settings:
        case MuJoCoSettings():
            same = replace(settings, preset="custom", steps_per_revolution=steps, timestep=h)
            if path == "step alone":
                return same
            return replace(
                same,
                solref=_in_steps(settings.solref, settings.timestep, h),
                contact_solref=_in_steps(settings.contact_solref, settings.timestep, h),
            )
        case PymunkSettings():
            alike = replace(settings, preset="custom", steps_per_revolution=steps, timestep=h)
            if path == "step alone":
                return alike
            # What is left after a step, bias^h, is what keeps its size.
            longer = settings.timestep / h
            return replace(
                alike,
                error_bias=settings.error_bias**longer,
                collision_bias=settings.collision_bias**longer,
                collision_slop=settings.collision_slop / settings.timestep**2 * h**2,
            )
        case _:
            raise TypeError(f"no refinement path for settings of {settings.engine!r}")


def _in_steps(solref: tuple[float, float], timestep: float, h: float) -> tuple[float, float]:
    # Divided first: a preset's eight steps are then eight steps to the last digit, and its runs are shared.
    # Negative values are MuJoCo's other form, stiffness and damping: they stay as they are.
    return (solref[0] / timestep * h, solref[1]) if solref[0] > 0.0 else solref


def rounding_level(steps: int) -> float:
    """Normalised error that is rounding: two turns' steps may sum a last digit each."""
    return max(LEAST_ROUNDING, 2.0 * steps * float(np.finfo(float).eps))
