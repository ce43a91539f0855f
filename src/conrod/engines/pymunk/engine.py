"""The pymunk engine (Chipmunk2D): its table of capabilities, kinematic mode, and steppers for timings."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from conrod.engines.engine import (
    STOCK,
    DeferredFunctions,
    DeferredLibrary,
    DescribedMachine,
    Engine,
    Machine,
    run_extent,
)
from conrod.engines.numerics import frames_from_centres, place_at_angles, secant_root
from conrod.engines.pymunk import PYMUNK_PRESETS, PYMUNK_VERSION, PymunkSettings
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Prismatic, pin_points

if TYPE_CHECKING:
    import pymunk

    from conrod.engines import capabilities, releases
    from conrod.engines.pymunk import dynamics, error_bound, forces, ingredients, loads, space, stepping, variants
    from conrod.engines.pymunk.space import PymunkSpace
else:
    pymunk = DeferredLibrary("pymunk")
    capabilities = DeferredLibrary("conrod.engines.capabilities")
    releases = DeferredFunctions("conrod.engines.releases")
    dynamics = DeferredFunctions("conrod.engines.pymunk.dynamics")
    error_bound = DeferredFunctions("conrod.engines.pymunk.error_bound")
    forces = DeferredFunctions("conrod.engines.pymunk.forces")
    ingredients = DeferredFunctions("conrod.engines.pymunk.ingredients")
    loads = DeferredFunctions("conrod.engines.pymunk.loads")
    space = DeferredFunctions("conrod.engines.pymunk.space")
    stepping = DeferredFunctions("conrod.engines.pymunk.stepping")
    variants = DeferredFunctions("conrod.engines.pymunk.variants")

# -- kinematic mode: its own joints as a solver of positions and rates at prescribed crank angles ----------------------


# With the crank at rest and full correction every step is a Newton step on the joints, whatever its length.
KINEMATIC_STEP = 1e-6  # [s]
MAX_KINEMATIC_STEPS = 12
KINEMATIC_ITERATIONS = 2000
MAX_RATE_SOLVES = 20
# Most machines need a small part of these iterations, which are tried first; of them, at most so many Newton steps an
# angle, the last of them so small [m, rad], and solutions for rates, with so large a residual rate.
FEW_ITERATIONS, MAX_FEW_STEPS, FEW_RATE_SOLVES = 200, 6, 2
FEW_PLACE_TOLERANCE, FEW_RATE_TOLERANCE = 1e-15, 1e-14
RATE_TOLERANCE = 1e-13  # residual rate of a joint, over the machine's size times the crank's speed
# A Newton step this small [m, rad] is rounding.
PLACE_TOLERANCE = 1e-16


def solve_kinematics(machine: Machine, angle: Array) -> capabilities.KinematicResult:
    """Hold the crank at each angle (T,) [rad] while pymunk's joints or distance query place the bodies."""
    settings = PymunkSettings.tuned(machine, 1000)
    found: tuple[Array, Array | None] | None
    if machine.kinematics.mechanism.cam_contacts:
        made = _build_still(machine, settings, KINEMATIC_ITERATIONS)
        found, error = _place_followers(made, machine, angle), error_bound.shape_error(machine, settings)
    else:
        made = _build_still(machine, settings, FEW_ITERATIONS)
        found, error = _solve_in_few_iterations(made, machine, angle), None
        if found is None:
            made = _build_still(machine, settings, KINEMATIC_ITERATIONS)
            found = _solve_in_many_iterations(made, machine, angle)
    centres, rates = found
    poses, speeds = frames_from_centres(made.mechanism, centres, np.zeros_like(centres) if rates is None else rates)
    observed = machine.kinematics.point_derivatives([poses, speeds])
    points = {name: (place, None if rates is None else rate) for name, (place, rate) in observed.items()}
    return capabilities.KinematicResult(angle, poses, points, error)


def _build_still(machine: Machine, settings: PymunkSettings, iterations: int) -> PymunkSpace:
    """Build the machine's space for kinematic mode."""
    still = replace(settings, iterations=iterations, gravity=False, error_bias=0.0)
    made = space.build(machine, still)
    _equalise_masses(made)
    return made


def _solve_in_few_iterations(made: PymunkSpace, machine: Machine, angle: Array) -> tuple[Array, Array] | None:
    """Solve for states (T, 3 n) of the centres of gravity at crank angles (T,) [rad]; None if it takes more iterations.

    The few suffice if Newton steps close the joints as fast as with exact solutions, and rates fit them to rounding.
    """
    motion, spin = stepping.StillSteps(made, KINEMATIC_STEP), made.mechanism.driver.sense * machine.speed
    _set_bias(made, 0.0)
    rows, closed = list[Array](), True

    def place(theta: float, ahead: Array | None) -> Array:
        """Place the machine by the engine's joints at a crank angle [rad], from a guess if one is given."""
        nonlocal closed
        if ahead is not None:
            _place_bodies(made, ahead)
        made.crank.angular_velocity, made.crank.angle = 0.0, made.mechanism.crank_turn(theta)
        before, length = motion.centres(), 0.0
        for _ in range(MAX_FEW_STEPS if closed else 0):
            motion.take_steps_from_rest(2)  # finds the velocities that close the joints, and moves by them
            now = motion.centres()
            length, before = max(map(abs, map(float.__sub__, now, before))), now
            if length < FEW_PLACE_TOLERANCE:
                break
        closed = closed and length < FEW_PLACE_TOLERANCE
        return np.array(before)

    for _ in place_at_angles(machine.kinematics, angle, place):
        if not closed:
            return None
        rows.append(_centres(made))
    centres, rates = np.array(rows), np.empty((len(rows), len(rows[0])))
    _set_bias(made, 1.0)
    for k, theta in enumerate(map(float, angle)):
        _place_bodies(made, centres[k])
        for _ in range(FEW_RATE_SOLVES):
            made.crank.angle = made.mechanism.crank_turn(theta) - spin * KINEMATIC_STEP
            motion.take_steps_from_rest(1, spin)
        rates[k] = stepping.read_states(made)[1][0]
    poses, speeds = frames_from_centres(made.mechanism, centres, rates)
    left = (machine.kinematics.jacobian(poses) @ speeds[:, :, None])[:, :-1, 0]
    fits = np.abs(left).max() <= FEW_RATE_TOLERANCE * abs(spin) * machine.kinematics.size
    return (centres, rates) if fits else None


def _solve_in_many_iterations(made: PymunkSpace, machine: Machine, angle: Array) -> tuple[Array, Array]:
    """Solve for states (T, 3 n) of the centres of gravity at crank angles (T,) [rad]."""

    def place(theta: float, ahead: Array | None) -> Array:
        if ahead is not None:
            _place_bodies(made, ahead)
        _close_joints(made, made.mechanism.crank_turn(theta))
        return _centres(made)

    rows = [
        (_centres(made), _closing_rates(made, machine, made.mechanism.crank_turn(theta)))
        for theta in place_at_angles(machine.kinematics, angle, place)
    ]
    centres, rates = (np.array(column) for column in zip(*rows, strict=True))
    return centres, rates


def _place_followers(made: PymunkSpace, machine: Machine, angle: Array) -> tuple[Array, Array | None]:
    """Place a cam's follower at crank angles (T,) [rad]; states (T, 3 n) of the centres of gravity, without rates."""

    def place(_: float, ahead: Array | None) -> Array:
        if ahead is not None:
            _place_bodies(made, ahead)
        return _centres(made)

    contact = made.mechanism.cam_contacts[0]
    turns = map(made.mechanism.crank_turn, place_at_angles(machine.kinematics, angle, place))
    return np.array([_place_follower(made, contact, turn) for turn in turns]), None


def _equalise_masses(made: PymunkSpace) -> None:
    """Give all bodies unit masses and like moments: poses do not depend on them, and iterations converge faster."""
    size = max(max(abs(x), abs(y)) for x, y, _ in made.mechanism.poses.values()) or 1.0
    slides = [j for j in made.mechanism.joints if isinstance(j, Prismatic) and GROUND not in (j.a, j.b)]
    sliding = {name for slide in slides for name in (slide.a, slide.b)}
    for link, body in zip(made.mechanism.bodies, made.bodies, strict=True):
        if body.body_type != pymunk.Body.DYNAMIC:
            continue
        body.mass = 1.0
        if math.isfinite(body.moment):
            arms = [math.dist(point, link.centre_of_gravity) for point in pin_points(made.mechanism, link.name)]
            # For a wheel or block held at its middle any moment will do. A slide transmits rotation, over any length.
            arm = size if link.name in sliding else 0.0
            body.moment = (max([arm, *arms]) or size) ** 2


def _place_bodies(made: PymunkSpace, centres: Array) -> None:
    """Set positions and angles of the centres of gravity (3 n,) [m, m, rad]."""
    for body, (x, y, turn) in zip(made.bodies, centres.reshape(-1, 3), strict=True):
        body.position, body.angle = (float(x), float(y)), float(turn)


def _close_joints(made: PymunkSpace, turn: float) -> None:
    """Place all bodies by the engine's joints, with the crank at an angle [rad]."""
    _set_bias(made, 0.0)
    made.crank.angular_velocity = 0.0
    made.crank.angle = turn
    before = _centres(made)
    for _ in range(MAX_KINEMATIC_STEPS):
        _stop_bodies(made)
        made.space.step(KINEMATIC_STEP)  # finds the velocities that close the joints
        made.space.step(KINEMATIC_STEP)  # moves by them
        now = _centres(made)
        if np.abs(now - before).max() < PLACE_TOLERANCE:
            break
        before = now


def _closing_rates(made: PymunkSpace, machine: Machine, turn: float) -> Array:
    """Rates of the centres of gravity (3 n,) that fit the joints at the present pose and the crank's speed.

    A step of the velocity solver alone: no correction, and the crank set back so that it arrives at `turn` [rad]. For
    badly conditioned joints one step is not enough: each further one starts from bodies at rest with the impulses of
    the step before, and so continues the iteration.
    """
    spin = made.mechanism.driver.sense * machine.speed
    centres = _centres(made)
    _set_bias(made, 1.0)
    for _ in range(MAX_RATE_SOLVES):
        _stop_bodies(made)
        made.crank.angle, made.crank.angular_velocity = turn - spin * KINEMATIC_STEP, spin
        made.space.step(KINEMATIC_STEP)
        rates = np.asarray(stepping.read_states(made)[1][0])
        poses, speeds = frames_from_centres(made.mechanism, centres[None], rates[None])
        left = (machine.kinematics.jacobian(poses) @ speeds[:, :, None])[0, :-1, 0]
        if np.abs(left).max() <= RATE_TOLERANCE * abs(spin) * machine.kinematics.size:
            break
    return rates


def _stop_bodies(made: PymunkSpace) -> None:
    """Set all velocities to zero."""
    for body in made.bodies:
        body.velocity, body.angular_velocity = (0.0, 0.0), 0.0


def _set_bias(made: PymunkSpace, error_bias: float) -> None:
    """Set the error bias of all joints."""
    for constraint in made.space.constraints:
        constraint.error_bias = error_bias


def _centres(made: PymunkSpace) -> Array:
    """Positions and angles of the centres of gravity (3 n,) [m, m, rad]."""
    return np.asarray(stepping.read_states(made)[0][0])


def _place_follower(made: PymunkSpace, contact: CamContact, turn: float) -> Array:
    """Place the follower where the engine's own distance of cam and roller is zero, by secant iteration."""
    made.crank.angle = turn
    made.space.reindex_shapes_for_body(made.crank)
    follower = made.bodies[made.mechanism.body_index[contact.b]]
    start = follower.position
    slide = made.mechanism.guide(contact.b)
    assert isinstance(slide, Prismatic)  # or the machine is refused
    along = pymunk.Vec2d(1.0, 0.0).rotated(slide.direction)

    def gap(displacement: float) -> float:
        centre = start + along * displacement
        return min(shape.point_query(centre).distance for shape in made.crank.shapes) - contact.roller_radius

    displacement = secant_root(gap, 0.0, 1e-4 * contact.roller_radius, 1e-15)
    follower.position = start + along * displacement
    return _centres(made)


# -- steps with nothing recorded, which is what pymunk itself costs ----------------------------------------------------


class PymunkStepper:
    """A machine in the exact state of its start; a call advances it by a number of steps."""

    def __init__(self, machine: Machine, settings: PymunkSettings) -> None:
        angle, _ = run_extent(machine, 1, 1.0)
        self.made = dynamics.build_at_angle(machine, settings, angle)
        self._begin, self._steps, self._pushes = angle / machine.speed, 0, loads.driven_loads(self.made, settings)
        self._machine, self._timestep = machine, settings.timestep

    def __call__(self, steps: int) -> None:
        times = self._begin + self._timestep * np.arange(self._steps, self._steps + steps, dtype=float)
        loading = (self._pushes.apply_for_step, times) if self._pushes else None
        angles = dynamics.crank_angles(self._machine, times)
        stepping.advance_unrecorded(self.made, self._timestep, angles, loading)
        self._steps += steps


def reference_loop() -> PymunkStepper:
    """Stepper of the fixed slider-crank, the unit of timings, with pymunk's defaults."""
    return PymunkStepper(capabilities.TIMED_REFERENCE, PymunkSettings(STOCK, 1000, 0.001))


# -- the engine --------------------------------------------------------------------------------------------------------


class Pymunk(Engine[PymunkSettings]):
    """pymunk through its `Space`, with all capabilities."""

    name = "pymunk"
    version = PYMUNK_VERSION
    presets = PYMUNK_PRESETS
    refusal = staticmethod(space.refusal)
    run = staticmethod(dynamics.run)
    solve_kinematics = staticmethod(solve_kinematics)
    expected_error = staticmethod(error_bound.expected_error)
    expected_forces = staticmethod(forces.expected_forces)
    forces = staticmethod(forces.forces)
    free_run = staticmethod(dynamics.free_run)
    stepper = PymunkStepper
    reference_loop = staticmethod(reference_loop)
    paste = staticmethod(variants.paste)
    with_time_constant = staticmethod(variants.with_time_constant)
    with_regularisation = staticmethod(variants.with_regularisation)
    grid = staticmethod(variants.rules)
    minimal_settings = staticmethod(ingredients.minimal_settings)
    ingredients = staticmethod(ingredients.ingredients)

    @property
    def releases(self) -> releases.Releases:
        return releases.read_releases("conrod.engines.pymunk")

    def model(self, name: str, machine: DescribedMachine, settings: PymunkSettings) -> str:
        from conrod.engines.pymunk.standalone import standalone_module  # templates are slow to load

        return standalone_module(name, machine, settings)

    def probes(self, machine: Machine, steps_per_revolution: int) -> dict[str, PymunkSettings]:
        return {name: preset(machine, steps_per_revolution) for name, preset in self.presets.items()}


PYMUNK_ENGINE = Pymunk()
