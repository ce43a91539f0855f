"""pymunk: settings of a run, the presets, and the solver iterations they take. Does not import the engine.

Chipmunk's solver goes through the joints in order and gives each the impulse that brings its velocity error to zero,
the others unchanged: Gauss-Seidel iteration on J M^-1 J' p = b. With the error e of the impulses, the velocity error is
y = M^-1 J' e, and a joint projects it: y -> (1 - M^-1 J_i' (J_i M^-1 J_i')^-1 J_i) y. The product of all projections is
the matrix T of one iteration (`numerics.iteration_matrix`); N iterations leave T^N y.

A step starts with the impulses of the one before. With full correction of positions, the next step has to undo twice
what a step leaves, in the rates and in the gaps: with p the impulses of a converged iteration,

    e_n = T^N (3 e_(n-1) - 3 e_(n-2) + e_(n-3) - (p_n - p_(n-1))).

This decays if T^N is below 1/7, and is largest at the start, which has no impulses: p_0 = 0, and p_1 is 3/2 h times the
forces of the exact motion, as the first velocity belongs to 3/2 h. Rates are off by y_n - y_(n-1), and accelerations,
their difference over h, by 3/2 T^N M^-1 J' f: of order 0, where the scheme's own error is 5/12 h^2 x''''.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import version
from typing import Any, ClassVar

import numpy as np

from conrod.engines.engine import DASHED, DOTTED, STOCK, EngineSettings, Machine, Preset
from conrod.engines.numerics import NEAR_CHANGE_POINT, inverse_masses, iteration_matrix, joint_rows, poses_by_centres
from conrod.engines.pymunk.distance_rods import DistanceRod, eliminate_rods
from conrod.errors import unknown_choice
from conrod.exact.dynamics import load_forces
from conrod.exact.dynamics.inverse import mass_ratio
from conrod.exact.equations import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Prismatic
from conrod.mechanism.units import check_count, check_number

PYMUNK_VERSION = version("pymunk")  # what 7.0.0 says of itself is 2.0.0
ITERATION_ERROR_SHARE = 0.01  # of the scheme's own error, which the solver's iteration may add
FINEST_STEPS = 5000  # per revolution; with more, rounding, which grows with their square, is the larger error
START_POSITIONS = 36  # crank angles over a revolution at which a run may start
MIN_ITERATIONS, MAX_ITERATIONS = 10, 100_000  # pymunk's default, and the longest acceptable step
CACHED_COUNTS = 128  # machines whose number of iterations is kept


@lru_cache(CACHED_COUNTS)
def iterations_needed(kinematics: Kinematics, speed: float, rods: tuple[DistanceRod, ...] = ()) -> int:
    """Iterations after which the solver's error in acceleration is 1 % of the scheme's own, at any step and start.

    That is the least N with |3/2 T^N M^-1 f| <= 0.01 x 5/12 h^2 |x''''| (module docstring), for 5000 steps per
    revolution; with more steps rounding is the larger error. Positions next to change points are left out, where N has
    no bound. Rods are distance joints, without mass.
    """
    mechanism, angle = kinematics.mechanism, kinematics.angles(START_POSITIONS)
    clear = ~kinematics.near_change(angle, NEAR_CHANGE_POINT)
    angle = angle[clear] if clear.any() else angle
    derivatives = kinematics.derivatives(angle, 4)
    poses, rates = derivatives[0], derivatives[1] * speed
    forces = inertia_forces(mechanism, poses, rates, derivatives[2] * speed**2)
    if mechanism.loads:
        forces -= load_forces(mechanism, poses, rates, angle / speed)
    inverse = inverse_masses(mechanism, translating_bodies(mechanism))
    for rod in rods:
        inverse[rod.columns(mechanism)] = 0.0
    free = np.flatnonzero(inverse)
    by_centres = poses_by_centres(mechanism, poses)
    of_centres = by_centres[:, :, free]
    start = 1.5 * inverse[free] * (np.swapaxes(of_centres, 1, 2) @ forces[:, :, None])[:, :, 0]
    jacobian, constraints = kinematics.jacobian(poses) @ of_centres, list(_constraint_rows(kinematics))
    if rods:
        whole = kinematics.jacobian(poses) @ by_centres
        jacobian, constraints, moved = eliminate_rods(kinematics, rods, whole, free, constraints)
        of_centres = of_centres + by_centres @ moved

    def largest_derivative(of: list[Array], order: int) -> float:
        points = kinematics.point_derivatives(of)
        return max(
            float(np.linalg.norm(values[order], axis=1).max()) / kinematics.lengths[name]
            for name, values in points.items()
        )

    def velocity_error(changes: Array) -> float:
        return largest_derivative([poses, (of_centres @ changes[:, :, None])[:, :, 0]], 1)

    step = 2.0 * np.pi / FINEST_STEPS
    allowed = ITERATION_ERROR_SHARE * 5.0 / 12.0 * step**2 * largest_derivative(derivatives, 4) * speed**2
    once = iteration_matrix(jacobian, inverse[free], constraints)
    return _smallest_count(once, start, velocity_error, allowed)


def _smallest_count(once: Array, start: Array, size: Callable[[Array], float], allowed: float) -> int:
    """Smallest number of iterations whose matrix power reduces velocities (S, n) to the allowed size."""
    powers, before, count = [once], start[:, :, None], 1
    while size((powers[-1] @ before)[:, :, 0]) > allowed and 2 ** (len(powers) - 1) < MAX_ITERATIONS:
        powers.append(powers[-1] @ powers[-1])
    for k in reversed(range(len(powers) - 1)):
        after = powers[k] @ before
        if size(after[:, :, 0]) > allowed:
            before, count = after, count + 2**k
    return min(max(MIN_ITERATIONS, count), MAX_ITERATIONS)


def translating_bodies(mechanism: Mechanism) -> set[str]:
    """Names of the bodies that cannot rotate: those on a slide of the ground."""
    return {body.name for body in mechanism.bodies if isinstance(mechanism.guide(body.name), Prismatic)}


def _constraint_rows(kinematics: Kinematics) -> Iterator[slice]:
    """Yield the rows of equations that pymunk solves together, in its order: pins and slides, then gears."""
    last: list[slice] = []
    for joint, rows in joint_rows(kinematics):
        if isinstance(joint, Mesh):
            last.append(rows)
        elif isinstance(joint, Prismatic):
            yield slice(rows.start, rows.start + 1)
            if GROUND not in (joint.a, joint.b):  # else the body cannot rotate
                yield slice(rows.start + 1, rows.stop)
        else:
            yield rows
    yield from last


# -- settings and presets ----------------------------------------------------------------------------------------------


# Chipmunk's default: 0.9^60 of an error is left after a second, whatever the step.
STOCK_BIAS = (1.0 - 0.1) ** 60
STOCK_SLOP = 0.1  # [m]
DISTANCE_RODS, LIGHT_RODS = "distance-rods", "light-rods"
# Names of edits of a model, which ingredients of `conrod ablate` are made of; see `model_edits`.
MODEL_EDITS = (
    DISTANCE_RODS,
    "filtered-shapes",
    LIGHT_RODS,
    "no-contact",
    "open-loop",
    "redundant-joints",
    "touching-shapes",
)
LOOP_EDITS, CONTACT_EDITS = ("open-loop", "touching-shapes"), ("no-contact",)
EQUAL_MASS_ITERATIONS = 16  # for one loop of equal masses, if the motion is not known


@dataclass(frozen=True)
class PymunkSettings(EngineSettings):
    """Settings of a pymunk run, in SI, named as in pymunk where pymunk has them."""

    engine: ClassVar[str] = "pymunk"

    iterations: int = 10
    error_bias: float = STOCK_BIAS  # of the joints: share of an error left after a second
    collision_bias: float = STOCK_BIAS  # of contacts, likewise
    collision_slop: float = STOCK_SLOP  # [m], overlap that contacts may keep
    gravity: bool = True
    cam_vertices: int = 4000
    rounded_state: bool = False  # of runs: to single precision, after each step
    dressing: tuple[str, ...] = ()  # names of model edits, see `MODEL_EDITS`; kept sorted

    def __post_init__(self) -> None:
        # Chipmunk aborts the interpreter on most values out of these ranges.
        super().__post_init__()
        for name in self.dressing:
            if name not in MODEL_EDITS:
                raise unknown_choice("dressing", name, MODEL_EDITS)
        # Equal models have equal settings, and one key, in whatever order their edits were named.
        object.__setattr__(self, "dressing", tuple(sorted(set(self.dressing))))
        check_count("iterations", self.iterations, 1, 10**6)
        check_count("cam_vertices", self.cam_vertices, 16, 10**5)
        check_number("error_bias", self.error_bias, 0.0, 1.0)
        check_number("collision_bias", self.collision_bias, 0.0, 1.0)
        check_number("collision_slop", self.collision_slop, 0.0, 1e6, "m")

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as JSON values, without an empty `dressing`, which the keys of runs do not have."""
        found = super().as_dict()
        if not self.dressing:
            del found["dressing"]
        return found

    def time_constant(self, contact: bool) -> float:
        """Time constant -1 / ln(bias) [s]: the share bias^t of an error is left after a time t [s]."""
        bias = self.collision_bias if contact else self.error_bias
        return math.inf if bias >= 1.0 else 0.0 if bias == 0.0 else -1.0 / math.log(bias)

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> PymunkSettings:
        """Full correction of joints and contacts at every step, and enough iterations for order 2.

        A contact may keep half the overlap into which the released follower would fall in one step: without overlap it
        is thrown out at every step and bounces; with more, the overlap and not the fall limits the error.
        """
        kinematics = machine.kinematics
        # A follower on a cam has two equations alone, which are solved in one iteration.
        known = not kinematics.mechanism.cam_contacts
        count = iterations_needed(kinematics, machine.speed) if known else iterations_by_masses(kinematics.mechanism)
        return _with_tuned_fields(cls.stock(machine, steps_per_revolution), kinematics.mechanism, count)

    @classmethod
    def for_free_motion(cls, mechanism: Mechanism, preset: str, timestep: float) -> PymunkSettings:
        """Settings of a preset for motion without a drive, with a time step [s].

        Raises:
            InvalidInput: there is no such preset, or a value is out of range.
        """
        if preset not in PYMUNK_PRESETS:
            raise unknown_choice("preset", preset, PYMUNK_PRESETS)
        # No revolution exists to count steps by: the field has its least value.
        stock = cls(STOCK, 2, timestep)
        return stock if preset == STOCK else _with_tuned_fields(stock, mechanism, iterations_by_masses(mechanism))


def _with_tuned_fields(stock: PymunkSettings, mechanism: Mechanism, iterations: int) -> PymunkSettings:
    """Return stock settings with full correction, iterations and slop of the preset `tuned`."""
    return replace(
        stock,
        preset="tuned",
        iterations=iterations,
        error_bias=0.0,
        collision_bias=0.0,
        collision_slop=0.5 * follower_fall(mechanism) * stock.timestep**2,
    )


def iterations_by_masses(mechanism: Mechanism) -> int:
    """Iterations for motions that are not known before: 16 (1 + ratio of masses) times the number of loops.

    The iteration passes impulses from link to link. For known motions `iterations_needed` follows the error itself.
    """
    loops = max(1, len(mechanism.joints) - len(mechanism.bodies))
    return min(MAX_ITERATIONS, round(EQUAL_MASS_ITERATIONS * (1.0 + mass_ratio(mechanism)) * loops))


def follower_fall(mechanism: Mechanism) -> float:
    """Acceleration [m/s^2] of a cam's follower when it is released; 0 without contact."""
    falls = [0.0]
    for contact in mechanism.cam_contacts:
        mass = mechanism.body(contact.b).mass
        x, y = mechanism.constant_force_on(contact.b)
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
