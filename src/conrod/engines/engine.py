"""The core that every engine has: settings, presets, and runs at constant crank speed.

All else that an engine can do is a capability (`conrod.engines.capabilities`). A preset's name, rule, tolerances and
line style are one `Preset` in the table of its engine; no study of scenes knows a preset by name, except `STOCK` and
`CUSTOM`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, ClassVar, Generic, Protocol, Self, TypeVar

import numpy as np

from conrod.comparison.trajectory import Piece, Settings
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.units import Parameter, check_count, check_number


class DeferredLibrary:
    """An engine's library, imported when a name of it is first used: who reads finished runs needs none."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self._module), name)


class DeferredFunctions(DeferredLibrary):
    """A module of conrod that is imported when one of its functions is called."""

    def __getattr__(self, name: str) -> Any:
        def call(*arguments: Any, **named: Any) -> Any:
            return getattr(import_module(self._module), name)(*arguments, **named)

        return call


class Machine(Protocol):
    """A scene as engines see it: a mechanism with its exact motion, and its crank speed."""

    @property
    def speed(self) -> float:
        """Crank speed [rad/s]."""
        ...

    @property
    def kinematics(self) -> Kinematics:
        """The mechanism, with exact poses to start from."""
        ...


class DescribedMachine(Machine, Protocol):
    """A machine with title, source and frame to write into a file: a scene.

    Attributes:
        title, source: title of the machine, and source of its dimensions.
        frame: origin, axes and the crank angle's sense.
    """

    title: str
    source: str
    frame: str

    @property
    def parameters(self) -> Mapping[str, float]:
        """Values of all parameters, SI."""

    def parameter_facts(self) -> Mapping[str, Parameter]:
        """Unit and meaning of each parameter, by name."""

    @property
    def start_rates(self) -> Mapping[str, float]:
        """Angular rates [rad/s] of bodies, counter-clockwise, at the start of motion without a drive."""


LINKAGE_STEPS_PER_REVOLUTION, CAM_STEPS_PER_REVOLUTION = 1000, 62832
LAW_CAM_STEPS_PER_REVOLUTION = CAM_STEPS_PER_REVOLUTION // 8
PASTED_DIGITS = 6
PIECE_STEPS = 4096  # steps recorded at a time where a run is streamed
# Relative difference between a given time step and one revolution over its steps: settings made for another speed are
# off by more than the six digits that they are pasted with.
STEP_TOLERANCE = 1e-5
DOUBLE_EPSILON = float(np.finfo(float).eps)
SINGLE_EPSILON = float(np.finfo(np.float32).eps)  # relative spacing of the numbers that an engine may keep a state in


def step_length(machine: Machine, steps_per_revolution: int) -> float:
    """Time step [s]: one revolution of the crank over the number of steps."""
    return 2.0 * math.pi / abs(machine.speed) / steps_per_revolution


def run_extent(machine: Machine, steps_per_revolution: int, revolutions: float) -> tuple[float, float]:
    """Start angle [rad] and revolutions of a run; one whole pass if the input cannot turn fully.

    A pass takes whole steps, and ends where the last of them fits into the driver's span.
    """
    span = machine.kinematics.mechanism.driver.span
    if span is None:
        return 0.0, revolutions
    steps = math.floor((span[1] - span[0]) / (2.0 * math.pi) * steps_per_revolution * (1.0 + 1e-12))
    return span[0] if machine.speed > 0.0 else span[1], steps / steps_per_revolution


def default_steps(machine: Machine) -> int:
    """Default steps per revolution: 1000 for linkages, 62832 (ten thousand per radian) for cams.

    A cam that is made from a motion law has an eighth of that: on the cams of the catalogue contact then sinks by
    2e-5 of the lift, half a micrometre, and a run costs seconds.
    """
    contacts = machine.kinematics.mechanism.cam_contacts
    if any(isinstance(contact.profile, LawProfile) for contact in contacts):
        return LAW_CAM_STEPS_PER_REVOLUTION
    return CAM_STEPS_PER_REVOLUTION if contacts else LINKAGE_STEPS_PER_REVOLUTION


# -- settings and presets ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class EngineSettings(ABC):
    """Settings that every engine that ships has, in SI; InvalidInput names a value out of range."""

    engine: ClassVar[str]

    preset: str
    steps_per_revolution: int
    timestep: float  # [s]

    def __post_init__(self) -> None:
        check_count("steps_per_revolution", self.steps_per_revolution, 2, 10**8)
        check_number("timestep", self.timestep, 1e-14, 1e8, "s")

    @abstractmethod
    def time_constant(self, contact: bool) -> float:
        """Time constant [s] with which joints or contacts correct a violation; 0 if within one step."""

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as JSON values."""
        # `dataclasses.asdict` would copy each value, which took most of the time to find a finished run.
        return {name: list(value) if type(value) is tuple else value for name, value in vars(self).items()}

    @classmethod
    def stock(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """Settings with the defaults of the engine."""
        return cls(STOCK, steps_per_revolution, step_length(machine, steps_per_revolution))


AnySettings = TypeVar("AnySettings", bound=Settings)
AnyEngineSettings = TypeVar("AnyEngineSettings", bound=EngineSettings)

STOCK = "stock"  # by convention the preset with the engine's defaults, which studies compare others with
CUSTOM = "custom"  # preset name of settings that belong to no preset


def with_fields(settings: AnySettings, **fields: Any) -> AnySettings:
    """Return the settings with some fields replaced, as custom settings of no preset."""
    if hasattr(settings, "replace_fields"):  # settings of a plugin, which alone can change them
        changed: AnySettings = settings.replace_fields(**fields)
        return changed
    return replace(settings, preset=CUSTOM, **fields)  # type: ignore[type-var]


def round_settings(machine: Machine, settings: AnySettings) -> AnySettings:
    """Round settings to six digits for pasting; a step is rounded down where a pass must not overrun."""

    def round_value(value: Any) -> Any:
        """Round a float, or each float of a tuple, to `PASTED_DIGITS` digits; leave other values as they are."""
        match value:
            case float():
                return float(f"{value:.{PASTED_DIGITS}g}")
            case tuple():
                return tuple(map(round_value, value))
        return value

    own = settings.as_dict() if hasattr(settings, "replace_fields") else vars(settings)
    values = {name: round_value(value) for name, value in own.items()} | {"preset": CUSTOM}
    if values["timestep"] > settings.timestep and machine.kinematics.mechanism.driver.span is not None:
        values["timestep"] = round_value(settings.timestep * (1.0 - 0.5 * 10.0 ** (1 - PASTED_DIGITS)))
    if hasattr(settings, "replace_fields"):
        return with_fields(settings, **{k: v for k, v in values.items() if k != "preset" and v != own[k]})
    return type(settings)(**values)


def recognise_preset(
    settings: AnyEngineSettings,
    presets: Mapping[str, Preset[AnyEngineSettings]],
    machine: Machine,
    unused: Iterable[str] = (),
) -> AnyEngineSettings:
    """Return the preset that equals these settings, else the settings; fields in `unused` are ignored."""
    for name, rule in presets.items():
        preset = rule(machine, settings.steps_per_revolution)
        if replace(settings, preset=name, **{field: getattr(preset, field) for field in unused}) == preset:
            return preset
    return settings


@dataclass(frozen=True)
class LineStyle:
    """Line and markers of a curve; large markers lie beneath small ones, so that equal curves stay visible.

    Attributes:
        line: matplotlib's `linestyle`.
        marker: in matplotlib's notation.
        size: of the markers [pt].
        filled: whether the markers are filled.
        above: drawing order; a larger number is drawn later.
    """

    line: Any
    marker: str
    size: float
    filled: bool
    above: int


DOTTED = LineStyle((0, (1, 1.5)), "o", 7.0, False, 3)
DASHED = LineStyle((0, (5, 2)), "s", 4.5, False, 4)
SOLID = LineStyle("-", "^", 3.5, True, 5)
DEFAULT_LINE = LineStyle("-.", "D", 4.0, False, 4)


@dataclass(frozen=True)
class Preset(Generic[AnySettings]):
    """A named rule that makes settings for any machine, with its tolerances and line style.

    Attributes:
        rule: makes settings from a machine and steps per revolution; in period and step, the same for all machines.
        meaning: purpose of the preset, in a phrase.
        judged: whether runs at constant speed are judged by the engine's error law, or only measured.
        judged_free: whether motion without a drive is judged.
        forces: largest allowed error over the exact peak, by group of quantities (torque, reactions, contact).
        forces_order: order in the step by which `forces` grows at fewer steps than `default_steps`.
        order: formal order of the error of closed loops in the step, by quantity; absent if an error does not converge.
        style: line style of its curves.
    """

    rule: Callable[[Machine, int], AnySettings]
    meaning: str = ""
    judged: bool = True
    judged_free: bool = False
    forces: Mapping[str, float] = field(default_factory=dict)
    forces_order: int = 0
    order: Mapping[str, int] = field(default_factory=dict)
    style: LineStyle = DEFAULT_LINE

    def __call__(self, machine: Machine, steps_per_revolution: int) -> AnySettings:
        """Settings for a machine at a number of steps per revolution."""
        return self.rule(machine, steps_per_revolution)


def pass_sentence(machine: Machine, duration: str = "") -> str:
    """Sentence on where an input stops that cannot turn fully, for an exported model; empty if it can.

    Args:
        duration: how long the pass takes; in seconds where nothing is given.
    """
    span = machine.kinematics.mechanism.driver.span
    if span is None:
        return ""
    first, last = (math.degrees(angle) for angle in (span if machine.speed > 0.0 else reversed(span)))
    return (
        f" The input cannot turn fully: it begins at crank angle {first:.9g} deg and reaches {last:.9g} deg after "
        f"{duration or f'{(span[1] - span[0]) / abs(machine.speed):.9g} s'}. STOP THERE: beyond, nothing is promised."
    )


# -- engines -----------------------------------------------------------------------------------------------------------


class Engine(ABC, Generic[AnySettings]):
    """A physics engine that runs a machine at constant crank speed.

    An engine that can do more than run has the methods of a protocol in `conrod.engines.capabilities`; studies ask for
    what they need by `capability`, and an engine without it is `unsupported` there, with the reason.

    Attributes:
        name: on the command line, in settings and results.
        version: version of the installed engine.
        presets: by name, the engine as it comes (`STOCK`) first.
        epsilon: relative spacing of the numbers in which a state is kept, for an engine that has no double precision.
    """

    name: str
    version: str
    presets: Mapping[str, Preset[AnySettings]]
    epsilon: float = DOUBLE_EPSILON

    def has_capability(self, kind: type[Any]) -> bool:
        """Return True if the engine has the methods of a protocol of `conrod.engines.capabilities`."""
        return isinstance(self, kind)

    @abstractmethod
    def refusal(self, machine: Machine, settings: AnySettings) -> str | None:
        """Return the reason why the settings cannot be used on the machine, or None."""

    @abstractmethod
    def run(
        self,
        machine: Machine,
        settings: AnySettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE_STEPS,
    ) -> Iterator[Piece]:
        """Simulate a machine at constant crank speed from its exact state at a start angle [rad].

        Args:
            steps: steps in a piece; the first piece has the start sample too. Samples are the same to the last bit for
                any value, and memory does not grow with the revolutions.

        Returns:
            Pieces sampled at every step, with the outcome of the run so far; a failed run is data, never an exception.
        """


def judged_preset(engine: Engine[AnySettings]) -> str:
    """Name of the engine's first preset that is judged, or of its first preset if none is."""
    return next((name for name, preset in engine.presets.items() if preset.judged), next(iter(engine.presets)))
