"""The loop over steps. The one module that goes past pymunk's public interface, with the public way beside it.

The public properties of the bodies cost several times the step itself. So the numbers are copied from where Chipmunk
keeps them, eight in a row for a body, which a look at a body of known state has found in place. Both ways give the
same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from conrod.engines.pymunk.space import Build
from conrod.exact.motion import Array, cache_blocks

# In a cpBody position, velocity, force, angle and angular velocity follow two function pointers, four numbers of mass
# and the centre of gravity (chipmunk_structs.h).
OFFSET, WIDTH = 64, 8  # bytes, numbers
ANGLE = 6
CENTRE, RATE = (0, 1, ANGLE), (2, 3, 7)  # position with angle, velocity with angular velocity
BLOCK = 4096  # steps whose copies are kept together, so that they stay in the cache

Give = Callable[[float], object]  # gives all bodies their forces for the step that begins at a time [s]
States = tuple[Array, Array]  # centres of gravity with turns, and their rates; (T, 3 n) each


def state(made: Build) -> States:
    """The states as they are now, T = 1."""
    centres, rates = np.empty((2, 1, 3 * len(made.bodies)))
    _record(made.bodies, centres[0], rates[0])
    return centres, rates


def advance(
    made: Build,
    timestep: float,
    turns: Array,
    known: States | None = None,
    loading: tuple[Give, Array] | None = None,
    rounded: bool = False,
) -> States:
    """Take a step from each of T turns of the crank.

    Args:
        turns: (T,) [rad], of a driven crank's body where each step begins; of a free one their number alone counts.
        known: the last samples before, the space's own among them; None for that one.
        loading: forces beside constant ones, with the times (T,) [s] at which the steps begin.
        rounded: whether the states go to single precision after each step.

    Returns:
        The known samples, then those after the steps.
    """
    begun = state(made) if known is None else known
    first, count = len(begun[0]), len(turns)
    centres, rates = np.empty((2, first + count, 3 * len(made.bodies)))
    centres[:first], rates[:first] = begun
    after = centres[first:], rates[first:]
    public = count if loading or rounded or not memory_is_known() else min(count, _checked(made))
    with np.errstate(over="ignore"):  # what is too large becomes infinite, which the outcome tells
        begins = turns.astype(np.float32).astype(float) if rounded else turns
        for n, _ in enumerate(_by_properties(made, timestep, begins[:public], loading)):
            if rounded:
                _round(made.bodies)
            _record(made.bodies, after[0][n], after[1][n])
    memory = [memory_of(body) for body in made.bodies]
    centre, rate = ([WIDTH * k + column for k in range(len(memory)) for column in of] for of in (CENTRE, RATE))
    for steps in cache_blocks(count - public, BLOCK):
        rows = slice(public + steps.start, public + steps.stop)
        turned = turns[rows].tolist()
        states = np.frombuffer(_copies(made, timestep, turned, memory)).reshape(len(turned), WIDTH * len(memory))
        # Without a mode, `take` would first fill an array of its own.
        np.take(states, centre, axis=1, out=after[0][rows], mode="clip")
        np.take(states, rate, axis=1, out=after[1][rows], mode="clip")
    return centres, rates


def repeat(made: Build, timestep: float, turns: Array, loading: tuple[Give, Array] | None = None) -> None:
    """As `advance`, of a driven crank, with nothing recorded."""
    public = len(turns) if loading else _checked(made)
    for _ in _by_properties(made, timestep, turns[:public], loading):
        pass
    set_angle, set_force, take_step = lib.cpBodySetAngle, lib.cpBodySetForce, lib.cpSpaceStep
    own, driven, forces = made.space._space, made.crank._body, [(body._body, force) for body, force in made.pushed]
    for turn in turns[public:].tolist():
        set_angle(driven, turn)
        for one, force in forces:
            set_force(one, force)
        take_step(own, timestep)


def _checked(made: Build) -> int:
    """1 where the space is new: it takes its first step by the public call, which checks the bodies' masses."""
    return int(made.space.current_time_step == 0.0)


def _by_properties(made: Build, timestep: float, turns: Array, loading: tuple[Give, Array] | None) -> Iterator[None]:
    """Take steps by pymunk's public interface, one at a time."""
    for n, turn in enumerate(turns.tolist()):
        if made.driven:
            made.crank.angle = turn
        for body, force in made.pushed:
            body.force = force
        if loading is not None:
            loading[0](float(loading[1][n]))
        made.space.step(timestep)
        yield


def _copies(made: Build, timestep: float, turns: list[float], memory: list[memoryview]) -> bytearray:
    """The bodies' memory after each step, one copy after the other."""
    # Where nothing is driven a number that belongs to no body is written.
    crank = memory_of(made.crank) if made.driven else memoryview(bytearray(8 * WIDTH))
    angle, space = crank.cast("d")[ANGLE : ANGLE + 1], made.space._space
    pushed = [(body._body, force) for body, force in made.pushed]
    set_force, take_step, join = lib.cpBodySetForce, lib.cpSpaceStep, b"".join
    copies = bytearray()
    for turn in turns:
        # What else follows from the angle, a step works out anew as soon as it has moved the bodies, its first act.
        angle[0] = turn
        for body, force in pushed:
            set_force(body, force)
        take_step(space, timestep)
        copies += join(memory)
    return copies


def _round(bodies: tuple[pymunk.Body, ...]) -> None:
    for body in bodies:
        numbers = [*body.position, body.angle, *body.velocity, body.angular_velocity]
        x, y, turn, vx, vy, spin = np.array(numbers, dtype=np.float32).tolist()
        body.position, body.angle, body.velocity, body.angular_velocity = (x, y), turn, (vx, vy), spin


def _record(bodies: tuple[pymunk.Body, ...], centres: Array, rates: Array) -> None:
    for i, body in enumerate(bodies):
        centres[3 * i : 3 * i + 3] = (*body.position, body.angle)
        rates[3 * i : 3 * i + 3] = (*body.velocity, body.angular_velocity)


def memory_of(body: pymunk.Body) -> memoryview:
    """The numbers of a body that its steps change, where Chipmunk keeps them; valid as long as the body is."""
    return memoryview(ffi.buffer(ffi.cast("char *", body._body) + OFFSET, 8 * WIDTH))


def memory_is_known() -> bool:
    """True where Chipmunk keeps a body's state in the place of `memory_of`, and takes an angle there."""
    body = pymunk.Body(1.0, 1.0)
    body.position, body.velocity, body.force = (2.0, 3.0), (4.0, 5.0), (6.0, 7.0)
    body.angle, body.angular_velocity = 8.0, 9.0
    numbers = memory_of(body).cast("d")
    if numbers.tolist() != [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]:
        return False
    numbers[ANGLE] = 10.0
    return body.angle == 10.0
