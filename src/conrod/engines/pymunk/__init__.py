"""pymunk: settings of a run and the presets, with how many iterations its solver takes. Imports no engine.

Chipmunk goes through the joints in their order and gives each the impulse that brings it to the rate asked for, all
others left alone: Gauss-Seidel on J M^-1 J' p = b. Of the velocities, what is left of the impulses' error e is
y = M^-1 J' e, and a joint projects it: y -> (1 - M^-1 J_i' (J_i M^-1 J_i')^-1 J_i) y. The product T of all
projections is one iteration; N of them leave T^N y.

A step begins with the impulses of the last one. Where positions are mended whole at every step, what it leaves, the
next step has to undo twice, in the rates and in the gaps: with p the impulses that a settled iteration gives,

    e_n = T^N (3 e_(n-1) - 3 e_(n-2) + e_(n-3) - (p_n - p_(n-1))).

That decays where T^N is below 1/7, and is largest at the start, which knows no impulses: p_0 = 0, and p_1 are 3/2 h
times the exact motion's forces, as the first velocity belongs to 3/2 h. Rates are off by y_n - y_(n-1), and
accelerations, their difference over h, by 3/2 T^N M^-1 J' f: of order 0, where the step's own error is 5/12 h^2 x''''.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from conrod.engines.engine import DASHED, DOTTED, STOCK, EngineSettings, Machine, Preset
from conrod.engines.numerics import NEAR_CHANGE_POINT, inverse_masses, iteration_matrix, joint_rows, poses_by_centres
from conrod.errors import unknown_choice
from conrod.exact.dynamics import load_forces
from conrod.exact.dynamics.inverse import mass_ratio
from conrod.exact.equations import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Prismatic
from conrod.mechanism.units import check_count, check_number

SHARE = 0.01  # of the step's own error, that the iteration may leave
FINEST = 5000  # steps a turn; with more of them rounding, which grows with their square, is the larger error
SAMPLES = 36  # positions of the turn that a run may begin at
LEAST, MOST = 10, 100_000  # pymunk's default; what a step can be waited for
KEPT = 128


@lru_cache(KEPT)
def iterations_needed(kinematics: Kinematics, speed: float) -> int:
    """So many that they leave nothing beside the step's own error, wherever a run begins and whatever its step.

    Change points are left out: the closer to one, the more it takes, without end.
    """
    mechanism, angle = kinematics.mechanism, kinematics.angles(SAMPLES)
    clear = ~kinematics.near_change(angle, NEAR_CHANGE_POINT)
    angle = angle[clear] if clear.any() else angle
    derivatives = kinematics.derivatives(angle, 4)
    poses, rates = derivatives[0], derivatives[1] * speed
    forces = inertia_forces(mechanism, poses, rates, derivatives[2] * speed**2)
    if mechanism.loads:
        forces -= load_forces(mechanism, poses, rates, angle / speed)
    inverse = inverse_masses(mechanism, straight(mechanism))
    free = np.flatnonzero(inverse)
    of_centres = poses_by_centres(mechanism, poses)[:, :, free]
    begun = 1.5 * inverse[free] * (np.swapaxes(of_centres, 1, 2) @ forces[:, :, None])[:, :, 0]

    def size(of: list[Array], order: int) -> float:
        points = kinematics.point_derivatives(of)
        return max(
            float(np.linalg.norm(values[order], axis=1).max()) / kinematics.lengths[name]
            for name, values in points.items()
        )

    def left(changes: Array) -> float:
        return size([poses, (of_centres @ changes[:, :, None])[:, :, 0]], 1)

    step = 2.0 * np.pi / FINEST
    allowed = SHARE * 5.0 / 12.0 * step**2 * size(derivatives, 4) * speed**2
    jacobian = kinematics.jacobian(poses) @ of_centres
    return _iterations(iteration_matrix(jacobian, inverse[free], _constraints(kinematics)), begun, left, allowed)


def _iterations(once: Array, begun: Array, left: Callable[[Array], float], allowed: float) -> int:
    """The least number of iterations (S, n, n) that leave so much of what they begin with (S, n)."""
    powers, before, count = [once], begun[:, :, None], 1
    while left((powers[-1] @ before)[:, :, 0]) > allowed and 2 ** (len(powers) - 1) < MOST:
        powers.append(powers[-1] @ powers[-1])
    for k in reversed(range(len(powers) - 1)):
        after = powers[k] @ before
        if left(after[:, :, 0]) > allowed:
            before, count = after, count + 2**k
    return min(max(LEAST, count), MOST)


def straight(mechanism: Mechanism) -> set[str]:
    """Bodies that cannot turn: those on a slide of the ground."""
    return {body.name for body in mechanism.bodies if isinstance(mechanism.guide(body.name), Prismatic)}


def _constraints(kinematics: Kinematics) -> Iterator[slice]:
    """Equations that pymunk solves together, in its order: pins and slides, then gears."""
    last: list[slice] = []
    for joint, rows in joint_rows(kinematics):
        if isinstance(joint, Mesh):
            last.append(rows)
        elif isinstance(joint, Prismatic):
            yield slice(rows.start, rows.start + 1)
            if GROUND not in (joint.a, joint.b):  # else the body cannot turn
                yield slice(rows.start + 1, rows.stop)
        else:
            yield rows
    yield from last


# -- settings and presets ----------------------------------------------------------------------------------------------


# Chipmunk's default: what remains of an error after a second is 0.9^60 of it, whatever the step.
STOCK_BIAS = (1.0 - 0.1) ** 60
ITERATIONS = 16  # with equal masses and one loop, where the motion is not known


@dataclass(frozen=True)
class PymunkSettings(EngineSettings):
    """Settings of a pymunk run; the names are pymunk's own where it has one. SI."""

    engine: ClassVar[str] = "pymunk"
    former_fields: ClassVar[Mapping[str, Any]] = {"rod": "body"}  # links could be left out, as distances of their pins

    iterations: int = 10
    error_bias: float = STOCK_BIAS  # of the joints: share of an error left after a second
    collision_bias: float = STOCK_BIAS  # of contacts, likewise
    collision_slop: float = 0.1  # [m], overlap that contacts may keep
    gravity: bool = True
    cam_vertices: int = 4000
    rounded_state: bool = False  # of runs: to single precision, after each step

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
        if preset not in PYMUNK_PRESETS:
            raise unknown_choice("preset", preset, PYMUNK_PRESETS)
        # There is no turn that steps are counted by: the field has the least that it may have.
        stock = cls(STOCK, 2, timestep)
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


PYMUNK_PRESETS: Mapping[str, Preset[PymunkSettings]] = {
    STOCK: Preset(PymunkSettings.stock, "pymunk as it comes", judged=False, style=DOTTED),
    "tuned": Preset(
        PymunkSettings.tuned,
        "full correction at every step, and enough iterations for order 2",
        forces={"torque": 1e-3, "reactions": 1e-3, "contact": 0.02},
        forces_order=2,
        order=dict.fromkeys(("position", "velocity", "acceleration"), 2),  # scheme lag: full correction at every step
        style=DASHED,
    ),
}
