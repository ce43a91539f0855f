"""pymunk (Chipmunk2D), as one of conrod's engines, with its kinematic mode and its timed steps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pymunk

from conrod.engines.capabilities import TIMED_REFERENCE, KinematicResult
from conrod.engines.engine import STOCK, Engine, Machine, run_extent
from conrod.engines.numerics import frames_from_centres, place_at_angles, secant_root
from conrod.engines.pymunk import PYMUNK_PRESETS, PymunkSettings, dynamics, forces, grid, law, space
from conrod.engines.pymunk.dynamics import started as start_of
from conrod.engines.pymunk.dynamics import turns_at
from conrod.engines.pymunk.law import shape_error
from conrod.engines.pymunk.loads import pushes_of
from conrod.engines.pymunk.space import Build, build
from conrod.engines.pymunk.stepping import repeat, state
from conrod.engines.releases import Releases, read_releases
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Prismatic, pins_of

# -- kinematic mode: its own joints as a solver of positions and rates at prescribed crank angles ----------------------


# With the crank at rest and full correction every step is a Newton step on the joints, whatever its length.
STEP = 1e-6  # [s]
NEWTON_STEPS = 12
ITERATIONS = 2000
RATE_SOLVES = 20
RATE_DONE = 1e-13  # of the machine's size times the crank's speed, left in a joint
# A Newton step this small [m, rad] is rounding.
DONE = 1e-16


def solve_kinematics(machine: Machine, angle: Array) -> KinematicResult:
    """The crank held at each angle, the rest placed by the engine's own joints (or its distance query)."""
    settings = PymunkSettings.tuned(machine, 1000)
    still = replace(settings, iterations=ITERATIONS, gravity=False, error_bias=0.0)
    made = build(machine, still)
    _make_equal(made)
    contacts = made.mechanism.cam_contacts
    rows = []

    def place(theta: float, ahead: Array | None) -> Array:
        if ahead is not None:
            _place(made, ahead)
        if not contacts:
            _close_joints(made, made.mechanism.crank_turn(theta))
        return _centres(made)

    for theta in place_at_angles(machine.kinematics, angle, place):
        turn = made.mechanism.crank_turn(theta)
        if contacts:
            rows.append(_place_follower(made, contacts[0], turn))
        else:
            rows.append((_centres(made), _closing_rates(made, machine, turn)))
    centres, rates = (np.array(column) for column in zip(*rows, strict=True))
    poses, speeds = frames_from_centres(made.mechanism, centres, rates)
    observed = machine.kinematics.point_derivatives([poses, speeds])
    points = {name: (place, None if contacts else rate) for name, (place, rate) in observed.items()}
    error = shape_error(machine, settings) if contacts else None
    return KinematicResult(angle, poses, points, error)


def _make_equal(made: Build) -> None:
    """Unit masses, felt about alike at every joint: the pose depends on no mass, the engine's iteration does."""
    size = max(max(abs(x), abs(y)) for x, y, _ in made.mechanism.poses.values()) or 1.0
    slides = [j for j in made.mechanism.joints if isinstance(j, Prismatic) and GROUND not in (j.a, j.b)]
    sliding = {name for slide in slides for name in (slide.a, slide.b)}
    for link, body in zip(made.mechanism.bodies, made.bodies, strict=True):
        if body.body_type != pymunk.Body.DYNAMIC:
            continue
        body.mass = 1.0
        if math.isfinite(body.moment):
            arms = [math.dist(point, link.centre_of_gravity) for point in pins_of(made.mechanism, link.name)]
            # A wheel or a block is held at its middle; any size will do for what turns it. A slide hands on a turn.
            arm = size if link.name in sliding else 0.0
            body.moment = (max([arm, *arms]) or size) ** 2


def _place(made: Build, centres: Array) -> None:
    """Put centres of gravity and turns (3 n,) where they are to be."""
    for body, (x, y, turn) in zip(made.bodies, centres.reshape(-1, 3), strict=True):
        body.position, body.angle = (float(x), float(y)), float(turn)


def _close_joints(made: Build, turn: float) -> None:
    """Place all bodies, with the crank at a turn [rad]."""
    _set_bias(made, 0.0)
    made.crank.angular_velocity = 0.0
    made.crank.angle = turn
    before = _centres(made)
    for _ in range(NEWTON_STEPS):
        _stop(made)
        made.space.step(STEP)  # finds the velocities that close the joints
        made.space.step(STEP)  # moves by them
        now = _centres(made)
        if np.abs(now - before).max() < DONE:
            break
        before = now


def _closing_rates(made: Build, machine: Machine, turn: float) -> Array:
    """Rates of the centres of gravity (3 n,) that fit the joints where they are, at the crank's speed.

    A solve of the velocities alone: no correction, and the crank set back so that it arrives at `turn`. Where the
    joints are badly conditioned one solve is not enough. Each one more begins with the impulses of the last one, from
    bodies at rest, and so goes on where that ended.
    """
    spin = made.mechanism.driver.sense * machine.speed
    centres = _centres(made)
    _set_bias(made, 1.0)
    for _ in range(RATE_SOLVES):
        _stop(made)
        made.crank.angle, made.crank.angular_velocity = turn - spin * STEP, spin
        made.space.step(STEP)
        rates = np.asarray(state(made)[1][0])
        poses, speeds = frames_from_centres(made.mechanism, centres[None], rates[None])
        left = (machine.kinematics.jacobian(poses) @ speeds[:, :, None])[0, :-1, 0]
        if np.abs(left).max() <= RATE_DONE * abs(spin) * machine.kinematics.size:
            break
    return rates


def _stop(made: Build) -> None:
    for body in made.bodies:
        body.velocity, body.angular_velocity = (0.0, 0.0), 0.0


def _set_bias(made: Build, error_bias: float) -> None:
    for constraint in made.space.constraints:
        constraint.error_bias = error_bias


def _centres(made: Build) -> Array:
    return np.asarray(state(made)[0][0])


def _place_follower(made: Build, contact: CamContact, turn: float) -> tuple[Array, Array]:
    """The follower where the engine's own distance of cam and roller is zero (secant iteration along the slide)."""
    made.crank.angle = turn
    made.space.reindex_shapes_for_body(made.crank)
    follower = made.bodies[made.mechanism.body_index[contact.b]]
    start = follower.position
    slide = made.mechanism.guide(contact.b)
    assert isinstance(slide, Prismatic)  # or the machine is refused
    along = pymunk.Vec2d(1.0, 0.0).rotated(slide.direction)

    def gap(way: float) -> float:
        centre = start + along * way
        return min(shape.point_query(centre).distance for shape in made.crank.shapes) - contact.roller_radius

    way = secant_root(gap, 0.0, 1e-4 * contact.roller_radius, 1e-15)
    follower.position = start + along * way
    return _centres(made), np.zeros(3 * len(made.bodies))


# -- steps with nothing recorded, which is what pymunk itself costs ----------------------------------------------------


class BareRun:
    """A machine in the exact state of its start; calling it advances it by so many steps, counted as in a run."""

    def __init__(self, machine: Machine, settings: PymunkSettings) -> None:
        angle, _ = run_extent(machine, 1, 1.0)
        self.made, self._begin, self._steps = start_of(machine, settings, angle), angle / machine.speed, 0
        self._machine, self._timestep, self._pushes = machine, settings.timestep, pushes_of(self.made, settings)

    def __call__(self, steps: int) -> None:
        times = self._begin + self._timestep * np.arange(self._steps, self._steps + steps, dtype=float)
        loading = (self._pushes.give, times) if self._pushes else None
        repeat(self.made, self._timestep, turns_at(self._machine, times), loading)
        self._steps += steps


def reference_loop() -> BareRun:
    """The slider-crank that timings are ratios to, with pymunk's defaults."""
    return BareRun(TIMED_REFERENCE, PymunkSettings(STOCK, 1000, 0.001))


# -- the engine --------------------------------------------------------------------------------------------------------


class Pymunk(Engine[PymunkSettings]):
    """pymunk by way of its `Space`, with all capabilities but ingredients."""

    name = "pymunk"
    version = space.VERSION
    presets = PYMUNK_PRESETS
    refusal = staticmethod(space.refusal)
    run = staticmethod(dynamics.run)
    solve_kinematics = staticmethod(solve_kinematics)
    expected_error = staticmethod(law.expected_error)
    expected_forces = staticmethod(forces.expected_forces)
    forces = staticmethod(forces.forces)
    free_run = staticmethod(dynamics.free_run)
    stepper = BareRun
    reference_loop = staticmethod(reference_loop)
    paste = staticmethod(grid.paste)
    with_time_constant = staticmethod(grid.with_time_constant)
    with_regularisation = staticmethod(grid.with_regularisation)
    grid = staticmethod(grid.rules)

    @property
    def releases(self) -> Releases:
        return read_releases("conrod.engines.pymunk")

    def probes(self, machine: Machine, steps_per_revolution: int) -> dict[str, PymunkSettings]:
        return {name: preset(machine, steps_per_revolution) for name, preset in self.presets.items()}


PYMUNK_ENGINE = Pymunk()
