"""Presets: named rules that make an engine's settings for any machine and step, and what is required of them.

A preset's name, its rule, what it is judged by and how its curves are drawn are one `Preset` in its engine's table.
Nothing else in conrod knows a preset by name, but for the conventions `STOCK` and `CUSTOM`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import Field, dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Protocol, TypeVar

from conrod.runs.trajectory import Settings

if TYPE_CHECKING:
    from conrod.engines.engine import Machine


class FieldSettings(Settings, Protocol):
    """Settings that are a frozen dataclass, whose fields are varied."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


AnySettings = TypeVar("AnySettings", bound=Settings)
AnyFields = TypeVar("AnyFields", bound=FieldSettings)
MadeSettings_co = TypeVar("MadeSettings_co", bound=Settings, covariant=True)

STOCK = "stock"  # by convention the preset that has an engine as it comes, which studies compare others with
CUSTOM = "custom"  # the name of settings that are those of no preset


def with_fields(settings: AnyFields, **fields: Any) -> AnyFields:
    """The settings with these values, which are then those of no preset."""
    return replace(settings, preset=CUSTOM, **fields)


def as_preset(
    settings: AnyFields, presets: Mapping[str, Preset[AnyFields]], machine: Machine, unused: Iterable[str] = ()
) -> AnyFields:
    """The preset that the settings of a machine are, if they are one; fields that the machine makes no use of apart."""
    for name, rule in presets.items():
        preset = rule(machine, settings.steps_per_revolution)
        if replace(settings, preset=name, **{field: getattr(preset, field) for field in unused}) == preset:
            return preset
    return settings


class MakesSettings(Protocol[MadeSettings_co]):
    """A rule in period and step, the same for all machines."""

    def __call__(self, machine: Machine, steps_per_revolution: int, /) -> MadeSettings_co:
        """The settings of a machine."""
        ...


@dataclass(frozen=True)
class LineStyle:
    """A curve's line and markers. Coarse ones are large and beneath, so that a curve on another one is still seen.

    Attributes:
        line: dashes, as matplotlib's `linestyle`.
        marker: as matplotlib's.
        size: of the markers [pt].
        filled: whether the markers are.
        above: order of drawing; larger ones come later.
    """

    line: Any
    marker: str
    size: float
    filled: bool
    above: int


DOTTED = LineStyle((0, (1, 1.5)), "o", 7.0, False, 3)
DASHED = LineStyle((0, (5, 2)), "s", 4.5, False, 4)
SOLID = LineStyle("-", "^", 3.5, True, 5)
OTHER_LINE = LineStyle("-.", "D", 4.0, False, 4)


@dataclass(frozen=True)
class ForceBars:
    """Largest errors allowed of the forces of a preset.

    Attributes:
        allowed: by group of quantities (torque, reactions, contact), the largest error over the exact peak.
        order: by which more is allowed at fewer steps than those that the bars are stated for.
    """

    allowed: Mapping[str, float] = field(default_factory=dict)
    order: int = 0


@dataclass(frozen=True)
class Preset(Generic[AnySettings]):
    """A preset of an engine.

    Attributes:
        rule: what makes its settings.
        meaning: what it is for, in a phrase.
        judged: whether a run at constant speed is judged by the engine's law of errors, or only measured.
        judged_free: whether a motion without a drive is judged.
        forces: what is required of its forces; nothing where it is only measured.
        style: of its curves.
    """

    rule: MakesSettings[AnySettings]
    meaning: str = ""
    judged: bool = True
    judged_free: bool = False
    forces: ForceBars = field(default_factory=ForceBars)
    style: LineStyle = OTHER_LINE

    def __call__(self, machine: Machine, steps_per_revolution: int) -> AnySettings:
        """The settings of a machine at so many steps per revolution."""
        return self.rule(machine, steps_per_revolution)
