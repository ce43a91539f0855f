"""Rules of a sweep, whose settings differ in their step alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from conrod.engines.engine import Machine
from conrod.errors import unknown_choice
from conrod.runs.trajectory import Settings

Grid = Literal["coarse", "default", "fine", "presets"]
GRIDS: tuple[Grid, ...] = ("coarse", "default", "fine")  # that engines have
PRESETS: Grid = "presets"  # of every engine, and nothing else

# Multiples of 20, so that all have samples at the same twenty angles of a turn.
STEPS: Mapping[Grid, tuple[int, ...]] = {
    "coarse": (20, 200, 2000, 20000),
    "default": (20, 40, 100, 200, 400, 1000, 2000, 4000, 10000, 20000),
    "fine": (20, 40, 60, 100, 140, 200, 300, 400, 640, 1000, 1400, 2000, 3000, 4000, 6400, 10000, 14000, 20000),
}
# A contact that is soft by a few steps needs more of them than a closed loop.
CONTACT_STEPS: Mapping[Grid, tuple[int, ...]] = {"coarse": (), "default": (50000,), "fine": (30000, 50000)}


@dataclass(frozen=True)
class Rule:
    """One point of a grid, the step apart.

    Attributes:
        name: all that a reader needs to tell it from other rules of its engine.
        softness_follows_step: whether refining the step also stiffens what closes the joints.
        knobs: every knob and where it stands, in words and values free of dimension where the rule is.
        settings: of a machine and a number of steps per revolution; their preset is named where they are those of one.
    """

    name: str
    softness_follows_step: bool
    knobs: Mapping[str, str] = field(compare=False)
    settings: Callable[[Machine, int], Settings] = field(compare=False, repr=False)


def step_counts(grid: Grid, *, contact: bool) -> tuple[int, ...]:
    """Steps per revolution of a grid; of the presets those of the default grid."""
    grid = "default" if grid == PRESETS else grid
    return STEPS[grid] + (CONTACT_STEPS[grid] if contact else ())


def grid_named(name: str) -> Grid:
    """The grid of a name.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    grids = (*GRIDS, PRESETS)
    for grid in grids:
        if grid == name:
            return grid
    raise unknown_choice("grid", name, grids)


def texts_of(knobs: Any) -> dict[str, str]:
    """Where each of the knobs stands that are the fields of a dataclass."""
    values = {one.name: getattr(knobs, one.name) for one in fields(knobs)}
    return {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in values.items()}
