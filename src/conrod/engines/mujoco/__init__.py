"""MuJoCo: settings of a run, and the presets. Does not import the engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from conrod.engines.engine import DASHED, DOTTED, SOLID, STOCK, EngineSettings, Machine, Preset, step_length
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_count, check_number

# A larger factor leaves regularisation (1e-8: 4e-12 of the stroke in the press), a smaller one costs digits of the
# reaction forces by cancellation, about tenfold for each factor of ten.
HARDENING_FACTOR = 1e-9


# MuJoCo clips impedances to this range (mjMINIMP, mjMAXIMP).
MIN_IMPEDANCE, MAX_IMPEDANCE = 1e-4, 0.9999
MIN_TIME_CONSTANT_STEPS = 2.0  # MuJoCo raises a shorter time constant to this many steps (refsafe)

INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast", "discrete")
SOLVERS = ("PGS", "CG", "Newton")

STOCK_TOLERANCE, STOCK_ITERATIONS = 1e-8, 100
STOCK_SOLREF = (0.02, 1.0)
STOCK_SOLIMP = (0.9, 0.95, 0.001, 0.5, 2.0)
# The stiffest impedance that MuJoCo admits (mjMAXIMP), constant over the violation.
STIFF_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)
CONTACT_SOLIMP = (0.9, 0.9, 0.001, 0.5, 2.0)


@dataclass(frozen=True)
class MuJoCoSettings(EngineSettings):
    """Settings of a MuJoCo run, in SI, named as in MuJoCo where MuJoCo has them."""

    engine: ClassVar[str] = "mujoco"

    integrator: str = "Euler"
    solver: str = "Newton"
    iterations: int = STOCK_ITERATIONS
    # Scaled by the mean inertia: with the drive's armature any other value ends the solver before its first iteration.
    tolerance: float = 0.0
    solref: tuple[float, float] = STOCK_SOLREF  # of the loop closures: time constant [s], damping ratio
    solimp: tuple[float, float, float, float, float] = STOCK_SOLIMP  # of the loop closures
    hardening: float | None = None  # factor on the inverse weights that regularisation is scaled by
    gravity: bool = True
    armature: float = 1e13  # flywheel of the drive [kg m^2]; see `flywheel_inertia`
    autoreset: bool = False
    contact_solref: tuple[float, float] = STOCK_SOLREF
    contact_solimp: tuple[float, float, float, float, float] = STOCK_SOLIMP
    cam_vertices: int = 4000
    refsafe: bool = True  # a time constant below two steps is raised to them
    rounded_state: bool = False  # of runs: coordinates and rates to single precision, after each step
    dressing: tuple[str, ...] = ()  # names of model edits, see `model_edits.MODEL_EDITS`; kept sorted

    def __post_init__(self) -> None:
        super().__post_init__()
        # Equal models have equal settings, and one key, in whatever order their edits were named.
        object.__setattr__(self, "dressing", tuple(sorted(set(self.dressing))))
        for kind, value, choices in (
            ("integrator", self.integrator, INTEGRATORS),
            ("solver", self.solver, SOLVERS),
        ):
            if value not in choices:
                raise unknown_choice(kind, value, choices)
        check_count("iterations", self.iterations, 0, 10**6)
        check_count("cam_vertices", self.cam_vertices, 16, 10**5)
        check_number("tolerance", self.tolerance, 0.0, 1.0)
        check_number("armature", self.armature, 0.0, 1e30, "kg m²")
        if self.hardening is not None:
            check_number("hardening", self.hardening, 1e-15, 1.0)
        for name, pair in (("solref", self.solref), ("contact_solref", self.contact_solref)):
            check_number(f"{name} time constant", pair[0], -1e30, 1e30, "s")
            check_number(f"{name} damping ratio", pair[1], -1e30, 1e30)
        for name, limits in (("solimp", self.solimp), ("contact_solimp", self.contact_solimp)):
            for impedance in limits[:2]:
                check_number(f"{name} impedance", impedance, 0.0, 1.0)

    def time_constant(self, contact: bool) -> float:
        """Time constant [s] of solref, of contacts or of closures."""
        return (self.contact_solref if contact else self.solref)[0]

    @classmethod
    def stock(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """MuJoCo's defaults plus the drive, and the solver tolerance of 0 that the drive requires."""
        return replace(super().stock(machine, steps_per_revolution), armature=flywheel_inertia(machine))

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """The best settings that MJCF can express; see `with_tuned_solver`."""
        return cls.stock(machine, steps_per_revolution).with_tuned_solver(
            bool(machine.kinematics.mechanism.cam_contacts)
        )

    def with_tuned_solver(self, contact: bool) -> Self:
        """Return the settings with integrator, closures and contact of the preset `tuned`.

        Loops: RK4, the stiffest impedance, and a time constant of eight steps. Fewer steps close loops tighter (the gap
        goes with the square of the time constant), but the stiffer closure takes order from RK4, seen as an
        acceleration error that no shorter step removes.

        Contact is not smooth and gains nothing from RK4: Euler, a time constant of two steps (the least that MuJoCo
        admits) and an impedance of 0.9, because a stiffer contact (0.99) chatters.
        """
        return replace(
            self,
            preset="tuned",
            integrator="Euler" if contact else "RK4",
            solref=(8.0 * self.timestep, 1.0),
            solimp=STIFF_SOLIMP,
            contact_solref=(2.0 * self.timestep, 1.0),
            contact_solimp=CONTACT_SOLIMP,
        )

    @classmethod
    def hardened(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """Regularisation removed after compiling; time constant of a tenth of the period at any step."""
        slow = 0.1 * step_length(machine, 1)
        tuned = cls.tuned(machine, steps_per_revolution)
        return replace(tuned, preset="hardened", solref=(slow, 1.0), hardening=HARDENING_FACTOR)


def flywheel_inertia(machine: Machine) -> float:
    """Armature [kg m^2], a power of ten, that keeps the crank at its speed.

    The ripple of the rate is (energy exchanged per revolution) / (armature x speed^2). The armature makes it 1e-13 for
    links that all move with the largest velocity of an observed point and fall through its whole travel. Links that
    rotate faster exchange more; see `error_bound.speed_ripple_bound`.
    """
    exchanged = exchanged_inertia(machine)
    if not math.isfinite(exchanged):
        raise InvalidInput(
            f"{machine.kinematics.mechanism.name}: a force is not finite: do the two points of a load meet?"
        )
    return 10.0 ** math.ceil(math.log10(1e13 * exchanged))


def exchanged_inertia(machine: Machine) -> float:
    """Estimate the energy exchanged per revolution, over the crank speed^2 [kg m^2].

    It passes between the crank and all other bodies. The observed points' travel stands for that of all masses.
    """
    kinematics = machine.kinematics
    mass = sum(body.mass for body in kinematics.mechanism.bodies)
    weight = mass * math.hypot(*kinematics.mechanism.gravity)
    weight += sum(math.hypot(*push) for push in kinematics.mechanism.constant_forces.values())
    kinetic = mass * kinematics.travel**2
    work = 0.0
    if kinematics.mechanism.loads:
        from conrod.engines.tracks import load_work  # its imports are many, and few machines have loads

        work = load_work(kinematics, machine.speed)
    return kinetic + (weight * kinematics.travel + work) / machine.speed**2


MUJOCO_PRESETS: Mapping[str, Preset[MuJoCoSettings]] = {
    STOCK: Preset(MuJoCoSettings.stock, "MuJoCo as it comes, with the drive added", judged=False, style=DOTTED),
    "tuned": Preset(
        MuJoCoSettings.tuned,
        "the best that MJCF can express",
        forces={"contact": 0.02},
        order={"position": 2},  # a gap follows the square of its time constant, which follows the step
        style=DASHED,
    ),
    "hardened": Preset(
        MuJoCoSettings.hardened,
        "the regularisation of constraints removed after compiling",
        judged_free=True,
        forces={"torque": 1e-7, "reactions": 1e-6},
        forces_order=4,
        order=dict.fromkeys(("position", "velocity", "acceleration"), 4),  # that of RK4, as nothing else is left
        style=SOLID,
    ),
}
