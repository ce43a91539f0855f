"""Setups that an axis is walked for (scene, engine, preset), and their runs at the limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from conrod.comparison.trajectory import Settings
from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import MissingCapability, SettingsVariations, capability, require_capability
from conrod.exact.kinematics import GenericReference
from conrod.exact.motion import Motion, Side
from conrod.execution.case import MIN_PASS_STEPS
from conrod.execution.run import RunCase
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes import Scene
from conrod.studies.limits.records import LimitResult
from conrod.studies.limits.stream_run import stream_run

LINKAGE_STEPS, CONTACT_STEPS = 1000, 20000  # steps per revolution where an axis varies something else
# Variants of a scene are cached, so that tables that presets read are computed once for all runs.
MAX_CACHED_VARIANTS = 256


@dataclass(frozen=True)
class ReorderedMachine(GenericReference):
    """A scene with bodies and joints in another order, which has the scene's exact motion."""

    scene: Scene = field(repr=False)

    @property
    def lengths(self) -> Mapping[str, float]:
        """Normalising lengths [m] of the observed points, as in the scene."""
        return self.scene.lengths

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """Return the exact motion of the scene."""
        return self.scene.motion(angle, speed, acceleration, side)

    def break_angles(self) -> tuple[float, ...]:
        return self.scene.break_angles()


@dataclass(frozen=True)
class LimitCase(RunCase):
    """A run that is recorded up to its failure and beyond; see `stream_run`.

    Attributes:
        declared_mechanism: mechanism with bodies and joints in another order; None for the scene's own.
    """

    study: ClassVar[str] = "limits"
    result_type: ClassVar[type[Any]] = LimitResult

    signed_angles: int = 0
    declared_mechanism: Mechanism | None = field(default=None, repr=False)

    def perform(self) -> LimitResult:
        return stream_run(self)

    def key_fields(self) -> dict[str, Any]:
        order = None
        if self.declared_mechanism is not None:
            order = {
                kind: [one.name for one in getattr(self.declared_mechanism, kind)] for kind in ("bodies", "joints")
            }
        return super().key_fields() | {"declaration": order}

    @cached_property
    def machine(self) -> Scene | ReorderedMachine:
        """The machine that is run, with bodies and joints in the order of the case."""
        return (
            self.scene
            if self.declared_mechanism is None
            else ReorderedMachine(self.declared_mechanism, self.scene.speed, self.scene)
        )


@dataclass(frozen=True)
class Setup:
    """A scene in an engine with a preset, which is driven to its limits along axes.

    Attributes:
        name: name of the scene, for people.
        steps_per_revolution: steps if an axis varies something else; None for the usual number.
    """

    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str
    steps_per_revolution: int | None = None

    @property
    def names(self) -> tuple[str, str, str]:
        """Names of scene, engine and preset."""
        return self.name, self.engine, self.preset

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism of the scene, in the scene's order of declaration."""
        return self.scene.kinematics.mechanism

    @property
    def has_contact(self) -> bool:
        """True if the machine has a cam contact."""
        return bool(self.mechanism.cam_contacts)

    @property
    def min_steps(self) -> int:
        """Fewest steps per revolution of a run that is long enough to have accelerations."""
        span = self.mechanism.driver.span
        return 2 if span is None else math.ceil(MIN_PASS_STEPS * 2.0 * math.pi / (span[1] - span[0]))

    @property
    def steps(self) -> int:
        """Usual steps per revolution, for axes that do not vary the step."""
        return self.steps_per_revolution or (CONTACT_STEPS if self.has_contact else LINKAGE_STEPS)

    @property
    def loaded_engine(self) -> Engine[Any]:
        """The engine object of this name."""
        return engine_named(self.engine)

    @property
    def variations(self) -> SettingsVariations:
        """The engine's variations of settings; raises InvalidInput if it has none."""
        return require_capability(self.loaded_engine, SettingsVariations)

    def variation_refusal(self) -> str | None:
        """Return why the engine's settings cannot be varied, None if they can."""
        found = capability(self.loaded_engine, SettingsVariations)
        return found.reason if isinstance(found, MissingCapability) else None

    def settings(self, scene: Scene | None = None, steps: int | None = None) -> Settings:
        """Return the preset's settings for this scene or a variant, at the usual steps or others."""
        made: Settings = self.loaded_engine.presets[self.preset](scene or self.scene, steps or self.steps)
        return made

    def case_with(self, settings: Settings | None = None, **others: Any) -> LimitCase:
        """Return a run of the scene with the preset's settings or others.

        `others` are further fields of `LimitCase`.
        """
        return LimitCase(self.name, self.scene, settings or self.settings(), **others)

    def case_of_variant(self, scene: Scene, steps: int | None = None) -> LimitCase:
        """Return a run of a variant of the scene, with the preset's settings for it."""
        return LimitCase(self.name, scene, self.settings(scene, steps))

    def variant(self, **parameters: float) -> Scene:
        """Return the scene with other parameter values [SI].

        Raises InvalidInput as the scene's constructor does.
        """
        return _cached_variant(self.scene.with_parameters(**parameters))

    def refusal(self) -> str | None:
        """Return why the preset does not apply to this scene, None if it does."""
        return self.loaded_engine.refusal(self.scene, self.settings())


@lru_cache(MAX_CACHED_VARIANTS)
def _cached_variant(scene: Scene) -> Scene:
    """Return the cached scene that equals a scene, so that its tables are computed once."""
    return scene
