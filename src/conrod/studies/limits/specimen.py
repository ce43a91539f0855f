"""A run that is made on purpose to end in a certain way."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from conrod.engines import engine_named
from conrod.scenes import Scene
from conrod.studies.limits.bounded import BoundedCell
from conrod.studies.limits.cell import LimitCell
from conrod.trajectory import Outcome, Settings


@dataclass(frozen=True)
class Specimen:
    """A preset with what was done to it.

    Attributes:
        outcome: how it ends.
        title, what: what it is, and what was done to the preset, each in a line.
        name: of the scene.
        changes: of settings, by their names.
        step_constant: time constant of the joints in steps, set beside the changes; None leaves the preset's.
        unchecked: settings that conrod refuses, put past its check.
        timeout, headroom: of a run that needs limits of its own, see `BoundedCell`.
    """

    outcome: Outcome
    title: str
    what: str
    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str
    steps: int
    changes: Mapping[str, Any] = field(default_factory=dict)
    step_constant: float | None = None
    unchecked: Mapping[str, Any] = field(default_factory=dict)
    revolutions: float = 2.0
    timeout: float | None = None
    headroom: int | None = None

    @cached_property
    def settings(self) -> Settings:
        """The preset with its changes."""
        made = engine_named(self.engine).presets[self.preset](self.scene, self.steps)
        changes = dict(self.changes)
        if self.step_constant is not None:
            changes["solref"] = (self.step_constant * made.timestep, 1.0)
        if changes or self.unchecked:
            made = replace(made, preset="custom", **changes)
        return unchecked(made, **self.unchecked) if self.unchecked else made

    @cached_property
    def cell(self) -> LimitCell:
        """The run."""
        if self.headroom is not None:
            return BoundedCell(
                self.name, self.scene, self.settings, self.revolutions, headroom=self.headroom, whole=True
            )
        if self.timeout is not None:
            return BoundedCell(self.name, self.scene, self.settings, self.revolutions, timeout=self.timeout)
        return LimitCell(self.name, self.scene, self.settings, self.revolutions)


def unchecked(settings: Settings, **changes: Any) -> Settings:
    """Settings with values that their class refuses, for what an engine does when it is given them."""
    changed = copy.copy(settings)
    for name, value in changes.items():
        object.__setattr__(changed, name, value)
    return changed
