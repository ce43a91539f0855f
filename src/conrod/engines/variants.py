"""Settings that studies vary: rules of a sweep, and ingredients, one thing each, added to settings or taken away."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from itertools import product
from typing import Any, Generic, Literal, TypeAlias

from conrod.engines.engine import AnyFields, Machine, with_fields
from conrod.errors import unknown_choice
from conrod.runs.trajectory import Settings

Grid = Literal["coarse", "default", "presets"]
GRIDS: tuple[Grid, ...] = ("coarse", "default")  # that engines have
PRESETS: Grid = "presets"  # of every engine, and nothing else

# Multiples of 20, so that all have samples at the same twenty angles of a turn.
STEPS: Mapping[Grid, tuple[int, ...]] = {
    "coarse": (20, 200, 2000, 20000),
    "default": (20, 40, 100, 200, 400, 1000, 2000, 4000, 10000, 20000),
    PRESETS: (20, 40, 60, 100, 140, 200, 300, 400, 640, 1000, 1400, 2000, 3000, 4000, 6400, 10000, 14000, 20000),
}
# A contact that is soft by a few steps needs more of them than a closed loop.
CONTACT_STEPS: Mapping[Grid, tuple[int, ...]] = {"coarse": (), "default": (50000,), PRESETS: (30000, 50000)}


@dataclass(frozen=True)
class Rule:
    """One point of a grid, the step apart.

    Attributes:
        name: all that a reader needs to tell it from other rules of its engine.
        settings: of a machine and a number of steps per revolution; their preset is named where they are those of one.
    """

    name: str
    settings: Callable[[Machine, int], Settings] = field(compare=False, repr=False)


def step_counts(grid: Grid, *, contact: bool) -> tuple[int, ...]:
    """Steps per revolution of a grid."""
    return STEPS[grid] + (CONTACT_STEPS[grid] if contact else ())


def grid_named(name: str) -> Grid:
    """The grid of a name.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    for grid in (grids := (*GRIDS, PRESETS)):
        if grid == name:
            return grid
    raise unknown_choice("grid", name, grids)


Knobs: TypeAlias = Mapping[str, Any]  # by name where each stands, values or words free of dimension


def all_of(**values: Iterable[Any]) -> tuple[Knobs, ...]:
    """Every combination of some values of knobs."""
    return tuple(dict(zip(values, combined, strict=True)) for combined in product(*values.values()))


def knob_rules(
    usual: Knobs,
    turned: Iterable[Knobs],
    name: Callable[[Knobs, Knobs], str],
    settings: Callable[[Knobs, Machine, int], Settings],
) -> tuple[Rule, ...]:
    """A rule for each point of a grid, without repetition.

    Args:
        usual: all knobs where they stand unless they are turned.
        turned: knobs that stand elsewhere, of each point.
        name: of a rule, from its knobs and the usual ones.
    """
    points = {tuple(knobs.items()): knobs for knobs in ({**usual, **some} for some in turned)}
    return tuple(Rule(name(knobs, usual), partial(settings, knobs)) for knobs in points.values())


Change: TypeAlias = Callable[[AnyFields], AnyFields]


class Quantity(Enum):
    """Quantities beside the observed motion that studies look at; the members' texts are for people."""

    DRIVE_TORQUE = "drive torque"
    REACTIONS = "joint reactions"
    IMPACT = "impact"
    WEAR = "wear"


@dataclass(frozen=True)
class Ingredient(Generic[AnyFields]):
    """Something that the minimal model lacks, or that it consists of.

    Attributes:
        name: short, for the command line and for results: "sensors-64".
        meaning: what is added to the model, or taken from it, in a sentence.
        added, removed: settings with it, and without it.
        needed_by: quantities that need it although the motion does not.
        minimal: whether the minimal model has it; it is then only taken away.
    """

    name: str
    meaning: str
    added: Change[AnyFields]
    removed: Change[AnyFields]
    needed_by: tuple[Quantity, ...] = ()
    minimal: bool = False


def edit(name: str, meaning: str, *needed_by: Quantity, absence: str = "", minimal: bool = False) -> Ingredient[Any]:
    """An ingredient that is an edit of the model, of the same name, or whose absence is an edit."""
    one = absence or name

    def edited(settings: Any) -> Any:
        return with_fields(settings, dressing=(*settings.dressing, one))

    def unedited(settings: Any) -> Any:
        return with_fields(settings, dressing=tuple(other for other in settings.dressing if other != one))

    added, removed = (unedited, edited) if absence else (edited, unedited)
    return Ingredient(name, meaning, added, removed, needed_by, minimal)


def fields(
    model: Any, name: str, meaning: str, *needed_by: Quantity, minimal: bool = False, **values: Any
) -> Ingredient[Any]:
    """Values of the settings' fields instead of those of the minimal model; of a part of that, values without it."""
    own = {name: getattr(model, name) for name in values}
    added, removed = (own, values) if minimal else (values, own)
    return Ingredient(
        name,
        meaning,
        lambda settings: with_fields(settings, **added),
        lambda settings: with_fields(settings, **removed),
        needed_by,
        minimal,
    )
