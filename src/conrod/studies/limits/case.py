"""One engine with one preset on one scene: what an axis is walked for."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import Lacking, Varied, capability, variations_of
from conrod.engines.variations import Variations
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.run import LEAST_STEPS

LINKAGE_STEPS, CONTACT_STEPS = 1000, 20000
# Machines that an axis makes of a scene: their tables, which presets read, are then computed once for all cases.
VARIANTS_KEPT = 256


@dataclass(frozen=True)
class Case:
    """A scene in an engine, by the rule of a preset.

    Attributes:
        name: of the scene, for people.
        steps_per_revolution: where an axis varies something else; None is the usual number.
    """

    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str
    steps_per_revolution: int | None = None

    @property
    def contact(self) -> bool:
        """Whether the machine has a cam."""
        return bool(self.scene.kinematics.mechanism.cam_contacts)

    @property
    def one_pass(self) -> bool:
        """Whether its input cannot turn fully, and every run is the one pass that it makes."""
        return self.scene.kinematics.mechanism.driver.span is not None

    @property
    def fewest_steps(self) -> int:
        """Steps per revolution with which a run is just long enough to have accelerations, or two."""
        span = self.scene.kinematics.mechanism.driver.span
        return 2 if span is None else math.ceil(LEAST_STEPS * 2.0 * math.pi / (span[1] - span[0]))

    @property
    def steps(self) -> int:
        """Steps per revolution where an axis varies something else."""
        return self.steps_per_revolution or (CONTACT_STEPS if self.contact else LINKAGE_STEPS)

    def settings(self, scene: Scene | None = None, steps: int | None = None) -> Settings:
        """The preset's settings on this scene, or on another one that it became, at the usual or other steps."""
        made: Settings = self.made_by.presets[self.preset](scene or self.scene, steps or self.steps)
        return made

    def variant(self, **parameters: float) -> Scene:
        """The scene with other parameter values, SI; raises InvalidInput as its constructor does."""
        return _known(self.scene.with_parameters(**parameters))

    @property
    def variations(self) -> Variations[Any]:
        """How the engine's settings are varied.

        Raises:
            InvalidInput: they cannot be; see `not_varied`.
        """
        return variations_of(self.made_by)

    @property
    def not_varied(self) -> str | None:
        """None, or why the engine's settings cannot be varied."""
        found = capability(self.made_by, Varied)
        return found.reason if isinstance(found, Lacking) else None

    @property
    def made_by(self) -> Engine[Any]:
        """The engine."""
        return engine_named(self.engine)

    def refusal(self) -> str | None:
        """None, or why the preset is not for this scene."""
        return self.made_by.refusal(self.scene, self.settings())


@lru_cache(VARIANTS_KEPT)
def _known(scene: Scene) -> Scene:
    return scene
