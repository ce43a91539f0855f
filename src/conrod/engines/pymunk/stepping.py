"""The loop over steps, through pymunk's private memory layout and functions, and through its public ones.

The public properties of bodies cost several times the step itself. So the numbers are copied from where Chipmunk keeps
them, eight in a row for a body, after a check on a body of known state that they are there. Both ways give the same
bits. No other module goes past pymunk's public interface.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from conrod.engines.engine import DeferredLibrary
from conrod.engines.pymunk.space import PymunkSpace
from conrod.exact.motion import Array, cache_blocks

if TYPE_CHECKING:
    import pymunk
    from pymunk import _chipmunk_cffi as chipmunk
else:
    pymunk = DeferredLibrary("pymunk")
    chipmunk = DeferredLibrary("pymunk._chipmunk_cffi")

# In a cpBody position, velocity, force, angle and angular velocity follow two function pointers, four numbers of mass
# and the centre of gravity (chipmunk_structs.h).
STATE_OFFSET, STATE_NUMBERS = 64, 8  # [bytes], [doubles]
ANGLE_COLUMN = 6
CENTRE_COLUMNS, RATE_COLUMNS = (0, 1, ANGLE_COLUMN), (2, 3, 7)  # position with angle, velocity with angular velocity
BLOCK_STEPS = 4096  # whose copies fit into the processor's cache

ApplyForces = Callable[[float], object]  # applies the loads of the step that starts at a time [s]
States = tuple[Array, Array]  # positions with angles of the centres of gravity, and their rates; (T, 3 n) each


def read_states(made: PymunkSpace) -> States:
    """Read the present states of all bodies, as samples with T = 1."""
    centres, rates = np.empty((2, 1, 3 * len(made.bodies)))
    _read_into(made.bodies, centres[0], rates[0])
    return centres, rates


def advance(
    made: PymunkSpace,
    timestep: float,
    turns: Array,
    known: States | None = None,
    loading: tuple[ApplyForces, Array] | None = None,
    rounded: bool = False,
) -> States:
    """Take a step from each of T crank angles, and return the states (T, 3 n) after each.

    Args:
        turns: angles (T,) [rad] of a driven crank's body at the start of each step; without a drive only their number
            is used.
        known: the last samples before, the present one included; None for the present one alone.
        loading: applies forces besides constant ones, with the times (T,) [s] at which the steps start.
        rounded: whether states are rounded to single precision after each step.

    Returns:
        The known samples, then those after the steps.
    """
    begun = read_states(made) if known is None else known
    first, count = len(begun[0]), len(turns)
    centres, rates = np.empty((2, first + count, 3 * len(made.bodies)))
    centres[:first], rates[:first] = begun
    after = centres[first:], rates[first:]
    public = count if loading or rounded or not memory_is_known() else min(count, _public_steps(made))
    with np.errstate(over="ignore"):  # too large a value becomes infinite, which the outcome reports
        begins = turns.astype(np.float32).astype(float) if rounded else turns
        for n, _ in enumerate(_step_publicly(made, timestep, begins[:public], loading)):
            if rounded:
                _round_states(made.bodies)
            _read_into(made.bodies, after[0][n], after[1][n])
    memory = [memory_of(body) for body in made.bodies]
    centre, rate = (
        [STATE_NUMBERS * k + column for k in range(len(memory)) for column in of]
        for of in (CENTRE_COLUMNS, RATE_COLUMNS)
    )
    for steps in cache_blocks(count - public, BLOCK_STEPS):
        rows = slice(public + steps.start, public + steps.stop)
        turned = turns[rows].tolist()
        states = np.frombuffer(_copy_memory(made, timestep, turned, memory)).reshape(
            len(turned), STATE_NUMBERS * len(memory)
        )
        # Without a mode, `take` would first fill an array of its own.
        np.take(states, centre, axis=1, out=after[0][rows], mode="clip")
        np.take(states, rate, axis=1, out=after[1][rows], mode="clip")
    return centres, rates


def advance_unrecorded(
    made: PymunkSpace, timestep: float, turns: Array, loading: tuple[ApplyForces, Array] | None = None
) -> None:
    """Take a step from each of T crank angles of a driven crank, with nothing recorded."""
    public = len(turns) if loading else _public_steps(made)
    for _ in _step_publicly(made, timestep, turns[:public], loading):
        pass
    set_angle, set_force, take_step = chipmunk.lib.cpBodySetAngle, chipmunk.lib.cpBodySetForce, chipmunk.lib.cpSpaceStep
    own, driven, forces = (
        made.space._space,
        made.crank._body,
        [(body._body, force) for body, force in made.constant_forces],
    )
    for turn in turns[public:].tolist():
        set_angle(driven, turn)
        for one, force in forces:
            set_force(one, force)
        take_step(own, timestep)


def _public_steps(made: PymunkSpace) -> int:
    """Steps to take by the public call: 1 in a new space, whose first step checks the bodies' masses, else 0."""
    return int(made.space.current_time_step == 0.0)


def _step_publicly(
    made: PymunkSpace, timestep: float, turns: Array, loading: tuple[ApplyForces, Array] | None
) -> Iterator[None]:
    """Take steps by pymunk's public interface, one at a time."""
    for n, turn in enumerate(turns.tolist()):
        if made.driven:
            made.crank.angle = turn
        for body, force in made.constant_forces:
            body.force = force
        if loading is not None:
            loading[0](float(loading[1][n]))
        made.space.step(timestep)
        yield


def _copy_memory(made: PymunkSpace, timestep: float, turns: list[float], memory: list[memoryview]) -> bytearray:
    """Take steps, and copy the bodies' memory after each."""
    # Without a drive the angle is written to memory that belongs to no body.
    crank = memory_of(made.crank) if made.driven else memoryview(bytearray(8 * STATE_NUMBERS))
    angle, space = crank.cast("d")[ANGLE_COLUMN : ANGLE_COLUMN + 1], made.space._space
    pushed = [(body._body, force) for body, force in made.constant_forces]
    set_force, take_step, join = chipmunk.lib.cpBodySetForce, chipmunk.lib.cpSpaceStep, b"".join
    copies = bytearray()
    for turn in turns:
        # A step recomputes all that depends on the angle as soon as it has moved the bodies, its first action.
        angle[0] = turn
        for body, force in pushed:
            set_force(body, force)
        take_step(space, timestep)
        copies += join(memory)
    return copies


class StillSteps:
    """Steps of a length [s], each few begun with all bodies at rest, as an iteration of a space's own joints takes."""

    def __init__(self, made: PymunkSpace, timestep: float) -> None:
        self._made, self._timestep, self._known = made, timestep, memory_is_known()
        self._numbers = [memory_of(body).cast("d") for body in made.bodies]
        self._crank = self._numbers[made.mechanism.body_index[made.mechanism.crank]]

    def take_steps_from_rest(self, count: int, spin: float = 0.0) -> None:
        """Set all rates to 0, but the crank's to `spin` [rad/s], and take a number of steps."""
        x, y, turn = RATE_COLUMNS
        if self._known and not _public_steps(self._made):
            for numbers in self._numbers:
                numbers[x] = numbers[y] = numbers[turn] = 0.0
            self._crank[turn] = spin
            take_step, space = chipmunk.lib.cpSpaceStep, self._made.space._space
            for _ in range(count):
                take_step(space, self._timestep)
            return
        for body in self._made.bodies:
            body.velocity, body.angular_velocity = (0.0, 0.0), 0.0
        self._made.crank.angular_velocity = spin
        for _ in range(count):
            self._made.space.step(self._timestep)

    def centres(self) -> list[float]:
        """Positions and angles of the centres of gravity (3 n,) [m, m, rad]."""
        if not self._known:
            return [float(value) for value in read_states(self._made)[0][0]]
        return [numbers[column] for numbers in self._numbers for column in CENTRE_COLUMNS]


def _round_states(bodies: tuple[pymunk.Body, ...]) -> None:
    """Round the states of all bodies to single precision."""
    for body in bodies:
        numbers = [*body.position, body.angle, *body.velocity, body.angular_velocity]
        x, y, turn, vx, vy, spin = np.array(numbers, dtype=np.float32).tolist()
        body.position, body.angle, body.velocity, body.angular_velocity = (x, y), turn, (vx, vy), spin


def _read_into(bodies: tuple[pymunk.Body, ...], centres: Array, rates: Array) -> None:
    """Read the states of all bodies into arrays (3 n,)."""
    for i, body in enumerate(bodies):
        centres[3 * i : 3 * i + 3] = (*body.position, body.angle)
        rates[3 * i : 3 * i + 3] = (*body.velocity, body.angular_velocity)


def memory_of(body: pymunk.Body) -> memoryview:
    """The numbers of a body that steps change, in Chipmunk's own memory; valid as long as the body is."""
    return memoryview(chipmunk.ffi.buffer(chipmunk.ffi.cast("char *", body._body) + STATE_OFFSET, 8 * STATE_NUMBERS))


def memory_is_known() -> bool:
    """Return True if Chipmunk keeps a body's state where `memory_of` expects it, and takes an angle there."""
    body = pymunk.Body(1.0, 1.0)
    body.position, body.velocity, body.force = (2.0, 3.0), (4.0, 5.0), (6.0, 7.0)
    body.angle, body.angular_velocity = 8.0, 9.0
    numbers = memory_of(body).cast("d")
    if numbers.tolist() != [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]:
        return False
    numbers[ANGLE_COLUMN] = 10.0
    return body.angle == 10.0
