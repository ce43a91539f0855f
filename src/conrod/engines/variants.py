"""Settings that studies vary: rules of a sweep's grid, and ingredients of a minimal model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from itertools import product
from typing import Any, Generic, Literal, TypeAlias

from conrod.comparison.trajectory import Settings
from conrod.engines.engine import AnyEngineSettings, Machine, with_fields
from conrod.errors import unknown_choice

Grid = Literal["coarse", "default", "presets"]
ENGINE_GRIDS: tuple[Grid, ...] = ("coarse", "default")  # of engines with the capability `SettingsGrid`
PRESETS_GRID: Grid = "presets"  # of every engine: its presets alone

# Multiples of 20, so that all runs have samples at the same twenty crank angles.
GRID_STEPS: Mapping[Grid, tuple[int, ...]] = {
    "coarse": (20, 200, 2000, 20000),
    "default": (20, 40, 100, 200, 400, 1000, 2000, 4000, 10000, 20000),
    PRESETS_GRID: (20, 40, 60, 100, 140, 200, 300, 400, 640, 1000, 1400, 2000, 3000, 4000, 6400, 10000, 14000, 20000),
}
# A contact whose time constant is a few steps needs shorter steps than a closed loop.
GRID_CAM_STEPS: Mapping[Grid, tuple[int, ...]] = {"coarse": (), "default": (50000,), PRESETS_GRID: (30000, 50000)}


@dataclass(frozen=True)
class SettingsRule:
    """A rule of a sweep: settings for any machine and number of steps per revolution.

    Attributes:
        name: distinguishes the rule from all others of its engine.
        settings: makes settings from a machine and steps per revolution; settings that equal a preset carry its name.
    """

    name: str
    settings: Callable[[Machine, int], Settings] = field(compare=False, repr=False)


def step_counts(grid: Grid, *, contact: bool) -> tuple[int, ...]:
    """Steps per revolution that a sweep runs on a grid."""
    return GRID_STEPS[grid] + (GRID_CAM_STEPS[grid] if contact else ())


def grid_named(name: str) -> Grid:
    """Return the grid of a name.

    Raises:
        InvalidInput: no grid has the name; names the choices.
    """
    for grid in (grids := (*ENGINE_GRIDS, PRESETS_GRID)):
        if grid == name:
            return grid
    raise unknown_choice("grid", name, grids)


Knobs: TypeAlias = Mapping[str, Any]  # adjustable parameters by name, as dimensionless values or words


def knob_combinations(**values: Iterable[Any]) -> tuple[Knobs, ...]:
    """All combinations of the values given for each knob."""
    return tuple(dict(zip(values, combined, strict=True)) for combined in product(*values.values()))


def knob_rules(
    usual: Knobs,
    turned: Iterable[Knobs],
    name: Callable[[Knobs, Knobs], str],
    settings: Callable[[Knobs, Machine, int], Settings],
) -> tuple[SettingsRule, ...]:
    """Rules for all points of a grid of knobs, without duplicates.

    Args:
        usual: usual values of all knobs.
        turned: for each point, the knobs with other values.
        name: makes a rule's name from its knobs and the usual ones.
        settings: makes settings from knobs, a machine and steps per revolution.
    """
    points = {tuple(knobs.items()): knobs for knobs in ({**usual, **some} for some in turned)}
    return tuple(SettingsRule(name(knobs, usual), partial(settings, knobs)) for knobs in points.values())


SettingsChange: TypeAlias = Callable[[AnyEngineSettings], AnyEngineSettings]


class Quantity(Enum):
    """Quantities other than motion that a model may be used for, with their texts in reports."""

    DRIVE_TORQUE = "drive torque"
    REACTIONS = "joint reactions"
    IMPACT = "impact"
    WEAR = "wear"


@dataclass(frozen=True)
class Ingredient(Generic[AnyEngineSettings]):
    """A part or setting that a minimal model lacks, or that it consists of.

    Attributes:
        name: short, for the command line and for results: "sensors-64".
        meaning: what is added to the model, or removed from it, in a sentence.
        added, removed: return settings with the ingredient, and without it.
        needed_by: quantities that need the ingredient although the motion does not.
        minimal: whether the minimal model has the ingredient; it is then only removed.
        refusal: reason why the machine cannot have the ingredient; empty if it can.
    """

    name: str
    meaning: str
    added: SettingsChange[AnyEngineSettings]
    removed: SettingsChange[AnyEngineSettings]
    needed_by: tuple[Quantity, ...] = ()
    minimal: bool = False
    refusal: str = ""


# Reasons why a machine cannot have an ingredient.
NO_CONTACT, NO_LOOPS = "the machine has no cam", "no joint of the machine closes a loop"
NO_GRAVITY = "the machine is described without gravity"


def model_edit_ingredient(
    name: str, meaning: str, *needed_by: Quantity, absence: str = "", minimal: bool = False
) -> Ingredient[Any]:
    """Ingredient that is one of the engine's model edits, or whose absence is one."""
    one = absence or name

    def add_edit(settings: Any) -> Any:
        return with_fields(settings, dressing=(*settings.dressing, one))

    def remove_edit(settings: Any) -> Any:
        return with_fields(settings, dressing=tuple(other for other in settings.dressing if other != one))

    added, removed = (remove_edit, add_edit) if absence else (add_edit, remove_edit)
    return Ingredient(name, meaning, added, removed, needed_by, minimal)


def field_ingredient(
    model: Any, name: str, meaning: str, *needed_by: Quantity, minimal: bool = False, refusal: str = "", **values: Any
) -> Ingredient[Any]:
    """Ingredient that sets fields of the settings; with `minimal`, removing it sets them."""
    own = {name: getattr(model, name) for name in values}
    added, removed = (own, values) if minimal else (values, own)
    return Ingredient(
        name,
        meaning,
        lambda settings: with_fields(settings, **added),
        lambda settings: with_fields(settings, **removed),
        needed_by,
        minimal,
        refusal,
    )
