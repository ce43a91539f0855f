"""A scene in an engine by the rule of a preset, and one run of it at its limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

from numpy.typing import ArrayLike

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import MissingCapability, SettingsVariations, capability, require_capability
from conrod.exact import GenericReference
from conrod.exact.motion import Motion, Side
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.case import Measurement
from conrod.studies.frame.run import MIN_PASS_STEPS, RunCase
from conrod.studies.limits.records import Extremes
from conrod.studies.limits.stream_run import stream_run

# Raised when what is recorded of a run comes out otherwise, or means something else, than before.
WATCH_VERSION = 3
LINKAGE_STEPS, CONTACT_STEPS = 1000, 20000  # steps per revolution where an axis varies something else
# Machines that an axis makes of a scene: their tables, which presets read, are then computed once for all runs.
VARIANTS_KEPT = 256


@dataclass(frozen=True)
class Redeclared(GenericReference):
    """A scene whose mechanism is declared in another order; it is run, and compared with the same closed form."""

    scene: Scene = field(repr=False)

    @property
    def lengths(self) -> Mapping[str, float]:
        """Normalising lengths [m]; they depend on no order."""
        return self.scene.lengths

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """Return the exact motion, which depends on no order."""
        return self.scene.motion(angle, speed, acceleration, side)

    def break_angles(self) -> tuple[float, ...]:
        return self.scene.break_angles()


@dataclass(frozen=True)
class LimitCase(RunCase):
    """A run whose measurement carries `Extremes`; see `stream_run`.

    Attributes:
        declared: the mechanism with its bodies and joints in another order; None is the scene's own.
    """

    signed_angles: int = 0
    declared: Mechanism | None = field(default=None, repr=False)

    def perform(self) -> Measurement:
        return stream_run(self)

    def _check_readable(self, measurement: Measurement) -> None:
        Extremes.of(measurement)

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        order = None
        if self.declared is not None:
            order = {kind: [one.name for one in getattr(self.declared, kind)] for kind in ("bodies", "joints")}
        return super()._identity(parameters) | {"watched": WATCH_VERSION, "declaration": order}

    @cached_property
    def machine(self) -> Scene | Redeclared:
        """The machine that is run and compared."""
        return self.scene if self.declared is None else Redeclared(self.declared, self.scene.speed, self.scene)


@dataclass(frozen=True)
class Setup:
    """A scene in an engine, by the rule of a preset: what an axis is walked for.

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
    def who(self) -> tuple[str, str, str]:
        """Names of scene, engine and preset."""
        return self.name, self.engine, self.preset

    @property
    def mechanism(self) -> Mechanism:
        """The scene's, as it declares it."""
        return self.scene.kinematics.mechanism

    @property
    def contact(self) -> bool:
        """True of a machine with a cam."""
        return bool(self.mechanism.cam_contacts)

    @property
    def fewest_steps(self) -> int:
        """Steps per revolution with which a run is just long enough to have accelerations, or two."""
        span = self.mechanism.driver.span
        return 2 if span is None else math.ceil(MIN_PASS_STEPS * 2.0 * math.pi / (span[1] - span[0]))

    @property
    def steps(self) -> int:
        """Steps per revolution where an axis varies something else."""
        return self.steps_per_revolution or (CONTACT_STEPS if self.contact else LINKAGE_STEPS)

    @property
    def loaded_engine(self) -> Engine[Any]:
        """The engine."""
        return engine_named(self.engine)

    @property
    def varied(self) -> SettingsVariations:
        """The engine as one whose settings can be varied; InvalidInput where they cannot, see `not_varied`."""
        return require_capability(self.loaded_engine, SettingsVariations)

    def not_varied(self) -> str | None:
        """None, or why the engine's settings cannot be varied."""
        found = capability(self.loaded_engine, SettingsVariations)
        return found.reason if isinstance(found, MissingCapability) else None

    def settings(self, scene: Scene | None = None, steps: int | None = None) -> Settings:
        """Return the preset's settings on this scene, or on one that it became, at the usual or other steps."""
        made: Settings = self.loaded_engine.presets[self.preset](scene or self.scene, steps or self.steps)
        return made

    def run(self, settings: Settings | None = None, **others: Any) -> LimitCase:
        """Return a run of the scene with the preset's settings or others; `others` are fields of `LimitCase`."""
        return LimitCase(self.name, self.scene, settings or self.settings(), **others)

    def run_of(self, scene: Scene, steps: int | None = None) -> LimitCase:
        """Return a run of a scene that this one became, by the preset's rule for it."""
        return LimitCase(self.name, scene, self.settings(scene, steps))

    def variant(self, **parameters: float) -> Scene:
        """Return the scene with other parameter values, SI; raises InvalidInput as its constructor does."""
        return _known(self.scene.with_parameters(**parameters))

    def refusal(self) -> str | None:
        """Return None, or why the preset is not for this scene."""
        return self.loaded_engine.refusal(self.scene, self.settings())


@lru_cache(VARIANTS_KEPT)
def _known(scene: Scene) -> Scene:
    return scene
