"""The core of every engine: one run of a machine at constant crank speed. All else is a capability."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Generic, Protocol

from conrod.engines.presets import AnySettings, Preset
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.cam_law import LawProfile
from conrod.runs.trajectory import Piece


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
PIECE = 4096  # steps recorded at a time where a run is streamed


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
