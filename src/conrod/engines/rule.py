"""Rules of a sweep, whose settings differ in their step alone; and settings as plain values, for keys."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from conrod.engines.engine import Machine, Preset
from conrod.errors import unknown_choice
from conrod.runs.trajectory import Settings

Grid = Literal["coarse", "default", "fine"]
GRIDS: tuple[Grid, ...] = ("coarse", "default", "fine")

# Multiples of 20, so that all have samples at the same twenty angles of a turn.
STEPS: Mapping[Grid, tuple[int, ...]] = {
    "coarse": (20, 200, 2000, 20000),
    "default": (20, 40, 100, 200, 400, 1000, 2000, 4000, 10000, 20000),
    "fine": (20, 40, 60, 100, 140, 200, 300, 400, 640, 1000, 1400, 2000, 3000, 4000, 6400, 10000, 14000, 20000),
}
# A contact that is soft by a few steps needs more of them than a closed loop.
CONTACT_STEPS: Mapping[Grid, tuple[int, ...]] = {"coarse": (), "default": (50000,), "fine": (30000, 50000)}


class Rule(ABC):
    """One point of a grid, the step apart. Its subclasses are frozen dataclasses whose fields are the knobs."""

    @property
    @abstractmethod
    def name(self) -> str:
        """All that a reader needs to tell it from other rules of its engine."""

    @property
    @abstractmethod
    def softness_follows_step(self) -> bool:
        """True where refining the step also stiffens what closes the joints."""

    @abstractmethod
    def knobs(self) -> dict[str, str]:
        """Every knob and where it stands, in words and values free of dimension where the rule is."""

    @abstractmethod
    def settings(self, machine: Machine, steps_per_revolution: int) -> Settings:
        """The settings for a machine and a step; their preset is named where they are those of one."""


@dataclass(frozen=True)
class PresetRule(Rule):
    """A preset as a rule: what is swept of an engine that has no grid of its own."""

    preset: str
    made_by: Preset[Any] = field(repr=False)

    @property
    def name(self) -> str:
        return self.preset

    @property
    def softness_follows_step(self) -> bool:
        return True

    def knobs(self) -> dict[str, str]:
        return {"preset": self.preset}

    def settings(self, machine: Machine, steps_per_revolution: int) -> Settings:
        settings: Settings = self.made_by(machine, steps_per_revolution)
        return settings


def step_counts(grid: Grid, *, contact: bool) -> tuple[int, ...]:
    """Steps per revolution of a grid."""
    return STEPS[grid] + (CONTACT_STEPS[grid] if contact else ())


def grid_named(name: str) -> Grid:
    """The grid of a name.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    for grid in GRIDS:
        if grid == name:
            return grid
    raise unknown_choice("grid", name, GRIDS)


def texts_of(rule: Any) -> dict[str, str]:
    """The knobs of a rule that is a dataclass, and where each stands."""
    values = {one.name: getattr(rule, one.name) for one in fields(rule)}
    return {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in values.items()}


def distinct(rules: Iterable[Rule]) -> tuple[Rule, ...]:
    """Rules without repetition, in their first order."""
    return tuple(dict.fromkeys(rules))


# Fields that settings gained after results had been kept, with the value that all runs before them had. Where a field
# has it, it is left out: keys of results, and reports, stay what they were.
LATER_FIELDS: Mapping[str, Any] = {"refsafe": True, "rounded_state": False, "dressing": []}


def plain(settings: object) -> dict[str, Any]:
    """The fields of a settings object as values that JSON has, later ones only where they differ from before."""
    # `dataclasses.asdict` would copy each value, which took most of the time to find a finished run.
    values = {name: list(value) if isinstance(value, tuple) else value for name, value in vars(settings).items()}
    for name, before in LATER_FIELDS.items():
        if values.get(name) == before:
            del values[name]
    return values
