"""Optional capabilities of engines, as small protocols, and the functions that ask for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, cast, runtime_checkable

from conrod.engines.engine import Engine, Machine
from conrod.engines.releases import Releases
from conrod.engines.tracks import ForceTracks, FreeRun, Pace
from conrod.engines.variants import PRESETS_GRID, Grid, Ingredient, SettingsRule
from conrod.errors import InvalidInput
from conrod.exact.kinematics import GenericReference
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, Prismatic, Revolute

if TYPE_CHECKING:
    from conrod.engines.space import SpatialRun, SpatialStart


@dataclass(frozen=True)
class ExpectedError:
    """Bounds on a run's errors by the engine's own error law, normalised as errors are; None without a law.

    Attributes:
        position, velocity, acceleration: bounds on the max norm.
        velocity_rms: bound on the rms norm, if there is none on the max norm.
        rotation, angular_velocity, angular_acceleration: bounds of the driven links, normalised as `link_errors` says.
        ripple: bound on the relative variation of the crank speed in a revolution; 0 if the crank angle is prescribed.
        law: source of the bounds, as text for the report.
    """

    position: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    velocity_rms: float | None = None
    law: str = ""
    ripple: float = 0.0
    rotation: float | None = None
    angular_velocity: float | None = None
    angular_acceleration: float | None = None


@dataclass(frozen=True)
class KinematicResult:
    """Result of kinematic mode: the engine's own constraints solved at prescribed crank angles.

    Attributes:
        angle: prescribed crank angles (T,) [rad].
        poses: poses (T, 3 n) [m, m, rad] of all bodies, in the order of `Mechanism.bodies`.
        points: position (T, 2) [m] and velocity (T, 2) [m/s] of each observed point, as the engine computes them; the
            velocity is None if the engine has none without stepping in time.
        shape_error: bound on the position error of the collision shape itself [m]; None without contact.
    """

    angle: Array
    poses: Array
    points: Mapping[str, tuple[Array, Array | None]]
    shape_error: float | None = None


@runtime_checkable
class KinematicMode(Protocol):
    """Solves the engine's own constraints at prescribed crank angles (T,) [rad]."""

    def solve_kinematics(self, machine: Machine, angle: Array) -> KinematicResult:
        """Poses, points and shape error at the prescribed crank angles."""
        ...


@runtime_checkable
class ErrorLaw(Protocol):
    """Bounds the errors of a run before it is made, from the engine's documented scheme and the exact motion.

    The run starts in the exact state at `start_angle` [rad], 0 if the law takes none, or where the span starts.
    """

    def expected_error(self, machine: Machine, settings: Any) -> ExpectedError:
        """Bounds on the errors of a run with these settings."""
        ...


@runtime_checkable
class ForceReport(Protocol):
    """Reports drive torque and joint reactions of a run at constant crank speed, as the engine computes them.

    Quantities that the engine does not report are `unsupported` in the result, with the reason.
    """

    def forces(self, machine: Machine, settings: Any, revolutions: float, start_angle: float = 0.0) -> ForceTracks:
        """Drive torque and joint reactions at every step of a run, or why they are not reported."""
        ...


@dataclass(frozen=True)
class ExpectedForces:
    """Forces that an engine's scheme yields by its error law and the exact motion, before any run.

    Attributes:
        tracks: at the instants of a run, or at others in its revolutions; None if there is no bound, and no verdict.
        share: part of the predicted error by which the law itself may be off.
        law: source of the forces, as text for the report.
    """

    tracks: ForceTracks | None
    share: float
    law: str


@runtime_checkable
class ForceLaw(Protocol):
    """Predicts the forces of a run from an exact start, before the run; None if the engine has no such law."""

    def expected_forces(
        self, machine: Machine, settings: Any, revolutions: float, start_angle: float = 0.0
    ) -> ExpectedForces | None:
        """Forces of a run by the law of the scheme, with the share by which the law may be off."""
        ...


@runtime_checkable
class FreeMotionRuns(Protocol):
    """Simulates motion without a drive, free or under loads, with a given time step [s].

    It starts from exact poses and rates of all bodies (3 n,), which fulfil the joints, and is sampled after each
    `every` steps. Raises InvalidInput for an unknown preset, or a mechanism that the engine cannot represent.
    """

    def free_run(
        self, mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, pace: Pace,
        every: int = 1,
    ) -> FreeRun:  # fmt: skip
        """Simulate `steps` steps of `timestep` [s] with the settings of a preset."""
        ...


@runtime_checkable
class SpatialRuns(Protocol):
    """Runs machines in space whose joints follow laws, each from its exact state, with the settings of a preset."""

    def refusal_in_space(self, start: SpatialStart, preset: str) -> str | None:
        """Return the reason why the engine is not given the machine, or None."""
        ...

    def run_in_space(self, start: SpatialStart, preset: str, steps: int, every: int = 1) -> SpatialRun:
        """Make some steps; record the observed points at the start and after each `every` steps."""
        ...

    def stepper_in_space(self, start: SpatialStart, preset: str) -> Callable[[int], None]:
        """A function that advances the machine by a number of steps at each call, with nothing recorded."""
        ...


@runtime_checkable
class TimedStepping(Protocol):
    """Steps a machine with nothing recorded, for timings.

    Each call of a stepper advances a machine by a number of steps; it starts in the exact state of `run_extent`, and an
    input that makes one pass must not be driven beyond its end. The reference loop is a fixed slider-crank in this
    engine; timings are given as ratios to it.
    """

    def stepper(self, machine: Machine, settings: Any) -> Callable[[int], None]:
        """A function that advances the machine by a number of steps at each call."""
        ...

    def reference_loop(self) -> Callable[[int], None]:
        """Stepper of the fixed slider-crank, whose wall time is the unit of timings."""
        ...


@runtime_checkable
class SettingsGrid(Protocol):
    """Lists the settings that a sweep varies on a machine, presets first."""

    def grid(self, machine: Machine, grid: Grid) -> tuple[SettingsRule, ...]:
        """Rules of settings for a machine, presets first; more of them on a finer grid."""
        ...


@runtime_checkable
class SettingsVariations(Protocol):
    """Varies one solver parameter of given settings at a time: time constant, regularisation.

    Settings have the fields `iterations`, `rounded_state` and `cam_vertices`; two more parameters differ from engine to
    engine. `with_time_constant`: the time constant of joints, or of a cam's contact, in steps; an engine's own guard
    against short ones is switched off where it would act. `with_regularisation`: a share in (0, 1] of the
    regularisation that the engine adds to joints, or the distance of a contact's impedance from 1; None if the engine
    has none.
    """

    def with_time_constant(self, machine: Machine, settings: Any, steps: float) -> Any:
        """Settings with a time constant of a number of steps."""
        ...

    def with_regularisation(self, machine: Machine, settings: Any, share: float) -> Any | None:
        """Settings with a share of the regularisation; None if the engine has none."""
        ...


@runtime_checkable
class ModelIngredients(Protocol):
    """Offers a minimal model, the cheapest with the right motion, and the ingredients to add to it or remove."""

    def minimal_settings(self, machine: Machine, steps_per_revolution: int) -> Any:
        """Settings of the minimal model of a machine."""
        ...

    def ingredients(self, machine: Machine, minimal: Any) -> tuple[Ingredient[Any], ...]:
        """Ingredients that apply to a machine and its minimal model."""
        ...


@runtime_checkable
class PastableSettings(Protocol):
    """Writes settings as lines to paste into a user's own model or program."""

    def paste(self, machine: Machine, settings: Any) -> str:
        """Lines that put the settings into a user's model or program."""
        ...


@runtime_checkable
class ModelFile(Protocol):
    """Writes a scene with settings as a model file of the engine, with notes on all that the file lacks."""

    def model(self, name: str, machine: Any, settings: Any) -> str:
        """Text of a model file, under a scene's name."""
        ...


@runtime_checkable
class KnownReleases(Protocol):
    """Lists the engine's releases, and settings with which runs are compared between releases."""

    @property
    def releases(self) -> Releases:
        """Releases that can be installed side by side."""
        ...

    def probes(self, machine: Machine, steps_per_revolution: int) -> Mapping[str, Any]:
        """Settings by name whose runs are compared between releases."""
        ...


CAPABILITY_TITLES: Mapping[type, str] = {
    KinematicMode: "kinematic mode",
    ErrorLaw: "law of its errors",
    ForceReport: "report of forces",
    ForceLaw: "law of its forces' errors",
    FreeMotionRuns: "motion without a drive",
    SpatialRuns: "runs of machines in space",
    TimedStepping: "stepping with nothing recorded, which timings take",
    SettingsGrid: "grid of settings",
    SettingsVariations: "variations of its settings",
    ModelIngredients: "ingredients",
    PastableSettings: "settings to paste",
    ModelFile: "file of a model",
    KnownReleases: "list of its releases",
}

Capability = TypeVar("Capability")


@dataclass(frozen=True)
class MissingCapability:
    """The reason why an engine cannot take part in a study."""

    reason: str


def capability(engine: Engine[Any], kind: type[Capability]) -> Capability | MissingCapability:
    """Return the engine if it has a capability, else the reason why a study cannot use it."""
    if engine.has_capability(kind):
        return cast(Capability, engine)
    return MissingCapability(f"{engine.name} has no {CAPABILITY_TITLES[kind]}")


def failure_of(stepper: Callable[[int], None]) -> str:
    """Why a stepper has broken off, in its engine's words; empty while it goes on, or if it does not say."""
    return str(getattr(stepper, "failure", ""))


def require_capability(engine: Engine[Any], kind: type[Capability]) -> Capability:
    """Return the engine if it has a capability, else raise InvalidInput."""
    found = capability(engine, kind)
    if isinstance(found, MissingCapability):
        raise InvalidInput(found.reason)
    return found


def sweep_rules(engine: Engine[Any], machine: Machine, grid: Grid) -> tuple[SettingsRule, ...]:
    """Rules of settings that a sweep runs: the engine's grid, or its presets if it has no grid."""
    swept = capability(engine, SettingsGrid)
    if grid == PRESETS_GRID or isinstance(swept, MissingCapability):
        return tuple(SettingsRule(name, preset) for name, preset in engine.presets.items())
    return swept.grid(machine, grid)


def expected_error(engine: Engine[Any], machine: Machine, settings: Any, **start: float) -> ExpectedError:
    """Bounds on the errors of a run; without bounds, and with the reason, if the engine has no error law.

    Args:
        start: `start_angle` [rad], if the engine's law takes one.
    """
    law = capability(engine, ErrorLaw)
    if isinstance(law, MissingCapability):
        return ExpectedError(law=law.reason)
    return law.expected_error(machine, settings, **start)


# -- the slider-crank that timings are ratios to -----------------------------------------------------------------------

# NEVER CHANGE IT: ratios of any date and machine relate to this very system, run with each engine's defaults at 1000
# steps per revolution. A driven crank of 0.1 m, a rod of 0.3 m and a slider, in line at the start; no gravity.
TIMED_SLIDER_CRANK = Mechanism(
    name="reference loop",
    bodies=(Body("crank", 4.0, 0.02), Body("rod", 1.5, 0.01125), Body("slider", 6.0, 0.06)),
    joints=(
        Revolute("shaft", GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
        Revolute("crank-pin", "crank", "rod", (0.1, 0.0), (-0.15, 0.0)),
        Revolute("slider-pin", "rod", "slider", (0.15, 0.0), (0.0, 0.0)),
        Prismatic("slide", GROUND, "slider", (0.0, 0.0), (0.0, 0.0), direction=0.0),
    ),
    driver=Driver("shaft"),
    poses={"crank": (0.0, 0.0, 0.0), "rod": (0.25, 0.0, 0.0), "slider": (0.4, 0.0, 0.0)},
    observed=(),
)


# One revolution per second.
TIMED_REFERENCE = GenericReference(TIMED_SLIDER_CRANK, 6.283185307179586)
