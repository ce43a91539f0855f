"""What every engine offers to conrod."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, Protocol

from conrod.engines.capabilities import ForceTracks, FreeRun, Ingredient
from conrod.engines.mobility import MobilityCount
from conrod.engines.rule import Grid, Rule
from conrod.engines.variations import AnySettings, Variations
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.trajectory import Piece, Trajectory


class Machine(Protocol):
    """What an engine needs to know of a scene: the mechanism with its solver, and the speed it is driven at."""

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


@dataclass(frozen=True)
class ExpectedError:
    """Largest errors that the engine's own laws allow, normalised as errors are; None where there is no law.

    Attributes:
        position, velocity, acceleration: bounds on the max norm.
        velocity_rms: bound on the rms norm, where the max norm has none.
        law: where the bounds come from, for the report.
    """

    position: float | None
    velocity: float | None
    acceleration: float | None
    velocity_rms: float | None = None
    law: str = ""


@dataclass(frozen=True)
class Softness:
    """Largest position error that what closes the joints must cause, by the engine's documented law; normalised.

    Attributes:
        whole_run: over two turns from a start without error.
        last_turn: over the second of them, where the start is forgotten.
        law: in words.
    """

    whole_run: float
    last_turn: float
    law: str


@dataclass(frozen=True)
class KinematicResult:
    """Kinematic mode: the engine's own constraints solved at prescribed crank angles.

    Attributes:
        poses: of all bodies, stacked as in `Mechanism.bodies`.
        points: of each observed point position (T, 2) [m] and velocity (T, 2) [m/s], by the engine's account; the
            velocity is None where the engine has none without stepping in time.
        shape_error: bound on the position error that the collision shape itself has, None without contact.
    """

    angle: Array  # (T,) [rad]
    poses: Array  # (T, 3 n)
    points: Mapping[str, tuple[Array, Array | None]]
    shape_error: float | None = None  # [m]


class Engine(ABC, Generic[AnySettings]):
    """One physics engine: its presets and how they are varied, its translator and its two modes."""

    name: str
    presets: Mapping[str, Callable[..., AnySettings]]  # (machine, steps_per_revolution) -> settings
    variations: Variations[AnySettings]

    @property
    @abstractmethod
    def version(self) -> str:
        """Version of the installed engine."""

    @abstractmethod
    def refusal(self, machine: Machine, settings: AnySettings) -> str | None:
        """None, or the reason why these settings cannot be used on this machine."""

    @abstractmethod
    def run(self, machine: Machine, settings: AnySettings, revolutions: float, start_angle: float = 0.0) -> Trajectory:
        """Dynamic mode: real time stepping at constant crank speed, sampled at every step."""

    @abstractmethod
    def pieces(
        self, machine: Machine, settings: AnySettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
    ) -> Iterator[Piece]:
        """The run of `run`, bit for bit, in pieces of so many steps: memory does not grow with the revolutions.

        The first piece has the start beside its steps.
        """

    @abstractmethod
    def forces(
        self, machine: Machine, settings: AnySettings, revolutions: float, start_angle: float = 0.0
    ) -> ForceTracks:
        """Drive torque and joint reactions of a run at constant crank speed, by the engine's own account.

        What it does not tell is `unsupported`, with the reason; so is all of a run that did not come to its end.
        """

    @abstractmethod
    def free_run(
        self,
        mechanism: Mechanism,
        preset: str,
        timestep: float,
        steps: int,
        poses: Array,
        rates: Array,
        every: int = 1,
    ) -> FreeRun:
        """A motion without drive: free, or under the mechanism's loads.

        Args:
            timestep: of the engine [s].
            poses, rates: exact ones of all bodies to start from, each (3 n,), which the joints allow.
            every: how many steps lie between two instants that are told.

        Raises:
            InvalidInput: there is no such preset, or the engine cannot have the mechanism; says why.
        """

    @abstractmethod
    def solve_kinematics(self, machine: Machine, angle: Array) -> KinematicResult:
        """Kinematic mode at the given crank angles [rad]."""

    @abstractmethod
    def expected_error(self, machine: Machine, settings: AnySettings) -> ExpectedError:
        """Bounds on the errors of a run, derived from the engine's documented laws and the exact motion."""

    @abstractmethod
    def predicted_softness(self, machine: Machine, settings: AnySettings) -> Softness | None:
        """Size of the position error that what closes the joints must cause, by the engine's documented law.

        Where it acts by time (MuJoCo's springs) it is what is left at no step; where it acts by the step (pymunk's
        share of an error that a step mends) it is that of the settings' step, the lag of the scheme included.

        Returns:
            None where no law applies.

        Raises:
            InvalidInput: the machine cannot be given in the form that the settings ask for; see `refusal`.
        """

    @abstractmethod
    def stepper(self, machine: Machine, settings: AnySettings) -> Callable[[int], None]:
        """A machine in the exact state of its start, see `run_of`; each call advances it by so many steps.

        Nothing is recorded. An input that makes one pass must not be driven beyond its end: it cannot go on there.
        """

    @abstractmethod
    def reference_loop(self) -> Callable[[int], None]:
        """A fixed slider-crank of this engine; each call advances it by so many steps. Timings are told against it."""

    @abstractmethod
    def grid(self, machine: Machine, grid: Grid) -> tuple[Rule, ...]:
        """What a sweep varies on this machine: rules for settings, the presets first."""

    @abstractmethod
    def minimal(self, machine: Machine, steps_per_revolution: int) -> AnySettings:
        """The cheapest model that has the observed motion right, which studies of a model's ingredients start from."""

    @abstractmethod
    def ingredients(self, machine: Machine, minimal: AnySettings) -> tuple[Ingredient[AnySettings], ...]:
        """What the minimal model of a machine may carry beside what it needs, and what it consists of."""

    @abstractmethod
    def mobility(self, machine: Machine, settings: AnySettings, angle: Array) -> MobilityCount:
        """Degrees of freedom and constraints of the compiled model, at the exact poses of crank angles (T,) [rad].

        Raises:
            InvalidInput: the machine cannot be given in the form that the settings ask for; see `refusal`.
        """

    @abstractmethod
    def paste(self, machine: Machine, settings: AnySettings) -> str:
        """Settings as the lines that a user puts into a model or a program of their own."""
