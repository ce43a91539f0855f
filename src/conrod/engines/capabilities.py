"""Capabilities of an engine beside running a machine: small protocols, and the one way to ask for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar, cast, runtime_checkable

from conrod.engines.engine import Engine, Machine
from conrod.engines.releases import Releases
from conrod.engines.tracks import ForceTracks, FreeRun, Pace
from conrod.engines.variants import PRESETS, Grid, Ingredient, Rule
from conrod.errors import InvalidInput
from conrod.exact import GenericReference
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, Prismatic, Revolute


@dataclass(frozen=True)
class ExpectedError:
    """Largest errors that the engine's own laws allow, normalised as errors are; None where there is no law.

    Attributes:
        position, velocity, acceleration: bounds on the max norm.
        velocity_rms: bound on the rms norm, where the max norm has none.
        ripple: largest share by which a turn changes the drive's rate; 0 where the crank's angle is written.
        law: where the bounds come from, for the report.
    """

    position: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    velocity_rms: float | None = None
    law: str = ""
    ripple: float = 0.0


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


@runtime_checkable
class KinematicMode(Protocol):
    """The engine's own constraints as a solver at prescribed crank angles (T,) [rad]."""

    def solve_kinematics(self, machine: Machine, angle: Array) -> KinematicResult: ...


@runtime_checkable
class ErrorLaw(Protocol):
    """Bounds on the errors of a run, before it is made, from the engine's documented laws and the exact motion.

    The run begins exact, at crank angle 0 where its law takes no `start_angle`, or at the begin of the driver's span.
    """

    def expected_error(self, machine: Machine, settings: Any) -> ExpectedError: ...


@runtime_checkable
class ReportsForces(Protocol):
    """Drive torque and joint reactions of a run at constant crank speed, by the engine's own account.

    What the engine does not report of a machine is `unsupported` in them, with the reason.
    """

    def forces(self, machine: Machine, settings: Any, revolutions: float, start_angle: float = 0.0) -> ForceTracks: ...


@dataclass(frozen=True)
class ExpectedForces:
    """Forces that an engine's own scheme takes, by its laws and the exact motion, before any run.

    Attributes:
        tracks: at the instants of a run, or at others of its turns; None where nothing bounds them, nor is judged.
        share: of their errors, that the law leaves out.
        law: where they come from, for the report.
    """

    tracks: ForceTracks | None
    share: float
    law: str


@runtime_checkable
class ForceLaw(Protocol):
    """Errors of the forces of a run that begins exact, before it is made; None where the engine has no law of them."""

    def expected_forces(
        self, machine: Machine, settings: Any, revolutions: float, start_angle: float = 0.0
    ) -> ExpectedForces | None: ...


@runtime_checkable
class FreeMotion(Protocol):
    """A motion without drive, free or under the mechanism's loads, by steps of a length [s].

    It begins with exact poses and rates of all bodies, each (3 n,), which the joints allow, and is reported after
    `every` so many steps. InvalidInput where there is no such preset, or the engine cannot have the mechanism.
    """

    def free_run(
        self, mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, pace: Pace,
        every: int = 1,
    ) -> FreeRun: ...  # fmt: skip


@runtime_checkable
class Timed(Protocol):
    """Stepping with nothing recorded, for timings.

    Each call of a stepper advances a machine from the exact state of its start (`run_of`) by so many steps; an input
    that makes one pass must not be driven beyond its end. The reference loop is a fixed slider-crank of this engine,
    which timings are ratios to.
    """

    def stepper(self, machine: Machine, settings: Any) -> Callable[[int], None]: ...

    def reference_loop(self) -> Callable[[int], None]: ...


@runtime_checkable
class Swept(Protocol):
    """A grid of settings that a sweep varies, for a machine; the presets first."""

    def grid(self, machine: Machine, grid: Grid) -> tuple[Rule, ...]: ...


@runtime_checkable
class Varied(Protocol):
    """Settings varied on purpose, one thing at a time.

    They have the fields `iterations`, `rounded_state` and `cam_vertices`, and two more things that engines say each in
    their own way. `stabilised`: with a time constant of so many steps, of what closes the joints or, of a cam, of the
    contacts; guards of the engine against short ones are off where they would act. `regularised`: with a share in
    (0, 1] of the regularisation that the engine puts on a joint by itself, of a contact what impedance lacks of 1; None
    where the engine has none.
    """

    def stabilised(self, machine: Machine, settings: Any, steps: float) -> Any: ...

    def regularised(self, machine: Machine, settings: Any, share: float) -> Any | None: ...


@runtime_checkable
class HasIngredients(Protocol):
    """A minimal model, the cheapest that has the observed motion right, and the ingredients that it may carry."""

    def minimal(self, machine: Machine, steps_per_revolution: int) -> Any: ...

    def ingredients(self, machine: Machine, minimal: Any) -> tuple[Ingredient[Any], ...]: ...


@runtime_checkable
class Pasted(Protocol):
    """Settings as lines of a user's own model or program."""

    def paste(self, machine: Machine, settings: Any) -> str: ...


@runtime_checkable
class ModelFile(Protocol):
    """A scene with settings as a file of the engine's own; how to apply what the file cannot say stands in it."""

    def model(self, name: str, machine: Any, settings: Any) -> str: ...


@runtime_checkable
class Released(Protocol):
    """Releases that can be installed beside each other, and the settings by which they are told apart, by name."""

    @property
    def releases(self) -> Releases: ...

    def probes(self, machine: Machine, steps_per_revolution: int) -> Mapping[str, Any]: ...


MEANINGS: Mapping[type, str] = {
    KinematicMode: "kinematic mode",
    ErrorLaw: "law of its errors",
    ReportsForces: "report of forces",
    ForceLaw: "law of its forces' errors",
    FreeMotion: "motion without a drive",
    Timed: "stepping with nothing recorded, which timings take",
    Swept: "grid of settings",
    Varied: "variations of its settings",
    HasIngredients: "ingredients",
    Pasted: "settings to paste",
    ModelFile: "file of a model",
    Released: "list of its releases",
}

Wanted = TypeVar("Wanted")


@dataclass(frozen=True)
class Lacking:
    """The reason why an engine cannot take part in a study."""

    reason: str


def capability(engine: Engine[Any], kind: type[Wanted]) -> Wanted | Lacking:
    """The engine as one that has a capability, or the reason why it is unsupported where that is needed."""
    if engine.has(kind):
        return cast(Wanted, engine)
    return Lacking(f"{engine.name} has no {MEANINGS[kind]}")


def required(engine: Engine[Any], kind: type[Wanted]) -> Wanted:
    """The engine as one that has a capability; InvalidInput where it has not."""
    found = capability(engine, kind)
    if isinstance(found, Lacking):
        raise InvalidInput(found.reason)
    return found


def rules_of(engine: Engine[Any], machine: Machine, grid: Grid) -> tuple[Rule, ...]:
    """The settings that a sweep varies: the engine's grid, or its presets where these are asked for or it has none."""
    swept = capability(engine, Swept)
    if grid == PRESETS or isinstance(swept, Lacking):
        return tuple(Rule(name, preset) for name, preset in engine.presets.items())
    return swept.grid(machine, grid)


def expected_error(engine: Engine[Any], machine: Machine, settings: Any, **start: float) -> ExpectedError:
    """Bounds on the errors of a run; none, with the reason in place of the law, of an engine that states no law.

    Args:
        start: `start_angle` [rad], of an engine whose law takes it.
    """
    law = capability(engine, ErrorLaw)
    if isinstance(law, Lacking):
        return ExpectedError(law=law.reason)
    return law.expected_error(machine, settings, **start)


# -- the slider-crank that timings are ratios to -----------------------------------------------------------------------

# NEVER CHANGE IT: ratios of any date and machine relate to this very system, run with each engine's defaults at 1000
# steps a turn. A driven crank of 0.1 m, a rod of 0.3 m and a slider, in line at the start; no gravity.
SLIDER_CRANK = Mechanism(
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


# One turn a second.
REFERENCE = GenericReference(SLIDER_CRANK, 6.283185307179586)
