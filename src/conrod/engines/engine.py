"""An engine: one run of a machine at constant crank speed, by settings that presets make. All else is a capability.

A preset's name, its rule, what it is judged by and how its curves are drawn are one `Preset` in its engine's table.
Nothing else in conrod knows a preset by name, but for the conventions `STOCK` and `CUSTOM`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Generic, Protocol, Self, TypeVar

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.units import check_count, check_number
from conrod.runs.trajectory import Piece, Settings


class Machine(Protocol):
    """A scene as engines see it: the mechanism with its solver, and the speed it is driven at."""

    @property
    def speed(self) -> float:
        """Crank speed [rad/s]."""
        ...

    @property
    def kinematics(self) -> Kinematics:
        """The mechanism, with exact poses to start from."""
        ...


LINKAGE_STEPS, CONTACT_STEPS = 1000, 62832
LAW_STEPS = CONTACT_STEPS // 8
PASTED_DIGITS = 6
PIECE = 4096  # steps recorded at a time where a run is streamed
SINGLE = float(np.finfo(np.float32).eps)  # relative spacing of the numbers that an engine may keep a state in


def step_length(machine: Machine, steps_per_revolution: int) -> float:
    """Time step [s] that divides a revolution into so many."""
    return 2.0 * math.pi / abs(machine.speed) / steps_per_revolution


def run_of(machine: Machine, steps_per_revolution: int, revolutions: float) -> tuple[float, float]:
    """Start angle [rad] and revolutions of a run: those asked for, or the one pass of an input that cannot turn.

    A pass takes whole steps, and ends where the last of them fits into the driver's span.
    """
    span = machine.kinematics.mechanism.driver.span
    if span is None:
        return 0.0, revolutions
    steps = math.floor((span[1] - span[0]) / (2.0 * math.pi) * steps_per_revolution * (1.0 + 1e-12))
    return span[0] if machine.speed > 0.0 else span[1], steps / steps_per_revolution


def default_steps(machine: Machine) -> int:
    """Steps per revolution where nothing else is said: 1000 for linkages, ten thousand a radian for contact.

    A cam that is made from a motion law has an eighth of that: on the cams of the catalogue contact then sinks by
    2e-5 of the lift, half a micrometre, and a run costs seconds.
    """
    contacts = machine.kinematics.mechanism.cam_contacts
    if any(isinstance(contact.profile, LawProfile) for contact in contacts):
        return LAW_STEPS
    return CONTACT_STEPS if contacts else LINKAGE_STEPS


# -- settings and presets ----------------------------------------------------------------------------------------------

# Fields that settings gained after results had been kept, with the value that all runs before them had. Where a field
# has it, it is left out: keys of results, and reports, stay what they were.
LATER_FIELDS: Mapping[str, Any] = {"refsafe": True, "rounded_state": False, "dressing": ()}


@dataclass(frozen=True)
class EngineSettings(ABC):
    """Settings that every engine that ships has; SI. InvalidInput names a value out of its range."""

    engine: ClassVar[str]
    # Fields that settings have lost since results were kept, with the value that they had: keys stay what they were.
    former: ClassVar[Mapping[str, Any]] = {}

    preset: str
    steps_per_revolution: int
    timestep: float  # [s]

    def __post_init__(self) -> None:
        check_count("steps_per_revolution", self.steps_per_revolution, 2, 10**8)
        check_number("timestep", self.timestep, 1e-14, 1e8, "s")

    @abstractmethod
    def time_constant(self, contact: bool) -> float:
        """Time [s] in which what closes the joints, or a contact, mends an error; 0 where it does so at once."""

    def as_dict(self) -> dict[str, Any]:
        """The fields as values that JSON has, former ones too, and later ones only where they differ from before."""
        # `dataclasses.asdict` would copy each value, which took most of the time to find a finished run.
        return {**self.former} | {
            name: list(value) if type(value) is tuple else value
            for name, value in vars(self).items()
            if name not in LATER_FIELDS or value != LATER_FIELDS[name]
        }

    @classmethod
    def stock(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """The engine as it comes: its defaults."""
        return cls(STOCK, steps_per_revolution, step_length(machine, steps_per_revolution))


AnySettings = TypeVar("AnySettings", bound=Settings)
AnyFields = TypeVar("AnyFields", bound=EngineSettings)

STOCK = "stock"  # by convention the preset that has an engine as it comes, which studies compare others with
CUSTOM = "custom"  # the name of settings that are those of no preset


def with_fields(settings: AnySettings, **fields: Any) -> AnySettings:
    """The settings, a dataclass, with these values, which are then those of no preset."""
    if hasattr(settings, "changed"):  # those of another package's engine, which alone knows how
        changed: AnySettings = settings.changed(**fields)
        return changed
    return replace(settings, preset=CUSTOM, **fields)  # type: ignore[type-var]


def shortened(machine: Machine, settings: AnySettings) -> AnySettings:
    """The settings with numbers of so few digits that people paste them; a step is not longer where a pass ends."""

    def short(value: Any) -> Any:
        match value:
            case float():
                return float(f"{value:.{PASTED_DIGITS}g}")
            case tuple():
                return tuple(map(short, value))
        return value

    own = settings.as_dict() if hasattr(settings, "changed") else vars(settings)
    values = {name: short(value) for name, value in own.items()} | {"preset": CUSTOM}
    if values["timestep"] > settings.timestep and machine.kinematics.mechanism.driver.span is not None:
        values["timestep"] = short(settings.timestep * (1.0 - 0.5 * 10.0 ** (1 - PASTED_DIGITS)))
    if hasattr(settings, "changed"):
        return with_fields(settings, **{k: v for k, v in values.items() if k != "preset" and v != own[k]})
    return type(settings)(**values)


def as_preset(
    settings: AnyFields, presets: Mapping[str, Preset[AnyFields]], machine: Machine, unused: Iterable[str] = ()
) -> AnyFields:
    """The preset that the settings of a machine are, if they are one; fields that the machine makes no use of apart."""
    for name, rule in presets.items():
        preset = rule(machine, settings.steps_per_revolution)
        if replace(settings, preset=name, **{field: getattr(preset, field) for field in unused}) == preset:
            return preset
    return settings


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
class Preset(Generic[AnySettings]):
    """A preset of an engine.

    Attributes:
        rule: what makes its settings, of a machine and steps per revolution; in period and step, for all alike.
        meaning: what it is for, in a phrase.
        judged: whether a run at constant speed is judged by the engine's law of errors, or only measured.
        judged_free: whether a motion without a drive is judged.
        forces: by group of quantities (torque, reactions, contact), the largest error allowed over the exact peak.
        forces_order: by which more is allowed at fewer steps than those that this is stated for.
        order: formal order in the step, by quantity, of the motion of loops; none where an error stays at any step.
        style: of its curves.
    """

    rule: Callable[[Machine, int], AnySettings]
    meaning: str = ""
    judged: bool = True
    judged_free: bool = False
    forces: Mapping[str, float] = field(default_factory=dict)
    forces_order: int = 0
    order: Mapping[str, int] = field(default_factory=dict)
    style: LineStyle = OTHER_LINE

    def __call__(self, machine: Machine, steps_per_revolution: int) -> AnySettings:
        """The settings of a machine at so many steps per revolution."""
        return self.rule(machine, steps_per_revolution)


# -- engines -----------------------------------------------------------------------------------------------------------


class Engine(ABC, Generic[AnySettings]):
    """One physics engine.

    An engine that can do more than run has the methods of a protocol in `conrod.engines.capabilities`; studies ask for
    what they need by `capability`, and an engine without it is `unsupported` there, with the reason.

    Attributes:
        name: on the command line, in settings and results.
        version: of the installed engine.
        presets: by name, the engine as it comes (`STOCK`) first.
    """

    name: str
    version: str
    presets: Mapping[str, Preset[AnySettings]]

    def has(self, kind: type[Any]) -> bool:
        """True if the engine has the methods of a protocol in `conrod.engines.capabilities`."""
        return isinstance(self, kind)

    @abstractmethod
    def refusal(self, machine: Machine, settings: AnySettings) -> str | None:
        """None, or the reason why these settings cannot be used on this machine."""

    @abstractmethod
    def run(
        self, machine: Machine, settings: AnySettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
    ) -> Iterator[Piece]:
        """Real time stepping at constant crank speed from the exact state at an angle [rad], sampled at every step.

        Args:
            steps: in a piece; the first one has the start beside its steps. Samples do not depend on it, bit for bit,
                and memory does not grow with the revolutions.

        Returns:
            Pieces whose trajectories have the outcome of the run so far; a run that fails is data, never an exception.
        """


def judged_preset(engine: Engine[AnySettings]) -> str:
    """The first of an engine's presets that is judged; the first of all where none is."""
    return next((name for name, preset in engine.presets.items() if preset.judged), next(iter(engine.presets)))
