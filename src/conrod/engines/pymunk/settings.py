"""Settings of a pymunk run, and the presets. Imports no engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.engines.engine import DASHED, DOTTED, STOCK, EngineSettings, ForceBars, Machine, Preset
from conrod.engines.pymunk.iteration import MOST, iterations_needed
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.dynamics.inverse import mass_ratio
from conrod.mechanism.mechanism import Mechanism
from conrod.mechanism.units import check_count, check_number

# Chipmunk's default: what remains of an error after a second is 0.9^60 of it, whatever the step.
STOCK_BIAS = (1.0 - 0.1) ** 60
ITERATIONS = 16  # with equal masses and one loop, where the motion is not known


@dataclass(frozen=True)
class PymunkSettings(EngineSettings):
    """Settings of a pymunk run; the names are pymunk's own where it has one. SI."""

    engine: ClassVar[str] = "pymunk"
    former: ClassVar[Mapping[str, Any]] = {"rod": "body"}  # links could be left out, as distances of their pins

    iterations: int = 10
    error_bias: float = STOCK_BIAS  # of the joints: share of an error left after a second
    collision_bias: float = STOCK_BIAS  # of contacts, likewise
    collision_slop: float = 0.1  # [m], overlap that contacts may keep
    gravity: bool = True
    cam_vertices: int = 4000

    def __post_init__(self) -> None:
        # On most of what is out of these ranges Chipmunk would abort the interpreter.
        super().__post_init__()
        check_count("iterations", self.iterations, 1, 10**6)
        check_count("cam_vertices", self.cam_vertices, 16, 10**5)
        check_number("error_bias", self.error_bias, 0.0, 1.0)
        check_number("collision_bias", self.collision_bias, 0.0, 1.0)
        check_number("collision_slop", self.collision_slop, 0.0, 1e6, "m")

    def time_constant(self, contact: bool) -> float:
        bias = self.collision_bias if contact else self.error_bias
        # What is left after a time t is bias^t.
        return math.inf if bias >= 1.0 else 0.0 if bias == 0.0 else -1.0 / math.log(bias)

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> PymunkSettings:
        """Full correction of joints and contacts at every step, and enough iterations for order 2.

        A contact may keep half the overlap that the follower, released, would fall into in one step: without any
        it is thrown out at every step and bounces; with more it is not the fall that limits it.
        """
        kinematics = machine.kinematics
        # What slides on a cam is held by two equations alone, which settle at once.
        known = not kinematics.mechanism.cam_contacts
        count = iterations_needed(kinematics, machine.speed) if known else iterations_by_masses(kinematics.mechanism)
        return _tuned(cls.stock(machine, steps_per_revolution), kinematics.mechanism, count)

    @classmethod
    def free(cls, mechanism: Mechanism, preset: str, timestep: float) -> PymunkSettings:
        """A preset for a motion that no crank prescribes, with a step of this length [s].

        Raises:
            InvalidInput: there is no such preset, or a value is out of range.
        """
        if preset not in PRESETS:
            raise unknown_choice("preset", preset, PRESETS)
        # There is no turn that steps are counted by: the field has the least that it may have.
        stock = cls(STOCK, 2, timestep)
        if preset not in (STOCK, "tuned"):
            raise InvalidInput(f"{mechanism.name}: preset {preset!r} has no rule for a motion without a drive")
        return stock if preset == STOCK else _tuned(stock, mechanism, iterations_by_masses(mechanism))


def _tuned(stock: PymunkSettings, mechanism: Mechanism, iterations: int) -> PymunkSettings:
    return replace(
        stock,
        preset="tuned",
        iterations=iterations,
        error_bias=0.0,
        collision_bias=0.0,
        collision_slop=0.5 * follower_fall(mechanism) * stock.timestep**2,
    )


def iterations_by_masses(mechanism: Mechanism) -> int:
    """A rule of thumb for motions that are not known before: the ratio of masses, times the number of loops.

    The iteration passes impulses from link to link; where the motion is known, `iterations_needed` follows it.
    """
    loops = max(1, len(mechanism.joints) - len(mechanism.bodies))
    return min(MOST, round(ITERATIONS * (1.0 + mass_ratio(mechanism)) * loops))


def follower_fall(mechanism: Mechanism) -> float:
    """Acceleration [m/s^2] that a cam's follower has when it is released; 0 without contact."""
    falls = [0.0]
    for contact in mechanism.cam_contacts:
        mass = mechanism.body(contact.b).mass
        x, y = mechanism.push_on(contact.b)
        falls.append(math.hypot(mechanism.gravity[0] + x / mass, mechanism.gravity[1] + y / mass))
    return max(falls)


PRESETS: Mapping[str, Preset[PymunkSettings]] = {
    STOCK: Preset(PymunkSettings.stock, "pymunk as it comes", judged=False, style=DOTTED),
    "tuned": Preset(
        PymunkSettings.tuned,
        "full correction at every step, and enough iterations for order 2",
        forces=ForceBars({"torque": 1e-3, "reactions": 1e-3, "contact": 0.02}, order=2),
        order=dict.fromkeys(("position", "velocity", "acceleration"), 2),  # scheme lag: full correction at every step
        style=DASHED,
    ),
}
