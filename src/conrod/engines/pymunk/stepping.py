"""The loop over steps. The one module that goes past pymunk's public interface, with the public way beside it.

The public properties of the bodies cost several times the step itself. So the numbers are copied from where Chipmunk
keeps them, eight in a row for a body, which a look at a body of known state has found in place. Both ways give the
same bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pymunk

from conrod.engines.pymunk.built import Build, Loading, Pushed
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.exact.motion import Array, cache_blocks

ffi: Any
lib: Any
try:
    from pymunk._chipmunk_cffi import ffi, lib
except ImportError:  # another release of pymunk may have none
    ffi, lib = None, None

# In a cpBody position, velocity, force, angle and angular velocity follow two function pointers, four numbers of mass
# and the centre of gravity (chipmunk_structs.h).
OFFSET, WIDTH = 64, 8  # bytes, numbers
ANGLE = 6
CENTRE, RATE = (0, 1, ANGLE), (2, 3, 7)  # position with angle, velocity with angular velocity
BLOCK = 4096  # steps whose copies are kept together, so that they stay in the cache

PrivatePushed = list[tuple[Any, tuple[float, float]]]


def state(made: Build) -> tuple[Array, Array]:
    """Centres of gravity with turns, and their rates, as they are now; each (1, 3 n)."""
    centres, rates = np.empty((1, 3 * len(made.bodies))), np.empty((1, 3 * len(made.bodies)))
    _record(made.bodies, centres[0], rates[0])
    return centres, rates


def advance(
    made: Build,
    settings: PymunkSettings,
    turns: Array,
    known: tuple[Array, Array] | None = None,
    loading: Loading | None = None,
) -> tuple[Array, Array]:
    """Step through the given crank turns.

    Args:
        turns: (T,) [rad], of the crank body at each sample, which is the start of the step that follows it.
        known: the first samples, where the space is at the last of them; None where it is at the first one.

    Returns:
        Centres of gravity with turns, and their rates, at all samples; each (T, 3 n).
    """
    begun = state(made) if known is None else known
    first = len(begun[0])
    centres, rates = np.empty((2, len(turns), 3 * len(made.bodies)))
    centres[:first], rates[:first] = begun
    way = _by_memory if memory_is_known() else _by_properties
    turned = between(turns[first - 1 :], settings.substeps)
    if settings.rounded_state:
        turned = turned.astype(np.float32).astype(np.float64)
    # A number too large for single precision becomes infinite: the run diverges, which its record shows.
    with np.errstate(over="ignore"):
        if loading is not None:
            begins = between(loading.times[first - 1 :], settings.substeps)
            _by_properties(made, settings, turned, centres[first:], rates[first:], Loading(loading.give, begins))
        else:
            way(made, settings, turned, centres[first:], rates[first:])
    return centres, rates


def advance_free(made: Build, timestep: float, steps: int) -> tuple[Array, Array]:
    """Take so many steps with nothing driven; what a body is pushed with is constant.

    Returns:
        Centres of gravity with turns, and their rates, after each step; each (T, 3 n).
    """
    centres, rates = np.empty((2, steps, 3 * len(made.bodies)))
    by_memory = memory_is_known() and made.space.current_time_step > 0.0
    for rows in cache_blocks(steps, BLOCK):
        if not by_memory:
            for n in range(rows.start, rows.stop):
                for body, force in made.pushed:
                    body.force = force
                made.space.step(timestep)
                _record(made.bodies, centres[n], rates[n])
            continue
        memory, pushed = [memory_of(body) for body in made.bodies], [(body._body, f) for body, f in made.pushed]
        copies = _swing_and_copy(made.space._space, pushed, timestep, rows.stop - rows.start, memory)
        states = np.frombuffer(copies).reshape(-1, WIDTH * len(memory))
        centres[rows], rates[rows] = states[:, _columns(CENTRE, len(memory))], states[:, _columns(RATE, len(memory))]
    return centres, rates


def _swing_and_copy(
    space: Any, pushed: PrivatePushed, timestep: float, steps: int, memory: list[memoryview]
) -> bytearray:
    """As `_step_and_copy`, with no crank to turn."""
    set_force, take_step, join = lib.cpBodySetForce, lib.cpSpaceStep, b"".join
    copies = bytearray()
    for _ in range(steps):
        for body, force in pushed:
            set_force(body, force)
        take_step(space, timestep)
        copies += join(memory)
    return copies


def between(turns: Array, substeps: int) -> Array:
    """Crank turns [rad] at the beginning of every step of the space, from those at the T samples; (k (T - 1),)."""
    if substeps == 1:
        return turns[:-1]
    return np.asarray((turns[:-1, None] + np.diff(turns)[:, None] * np.arange(substeps) / substeps).ravel())


def repeat(space: pymunk.Space, crank: pymunk.Body, pushed: Pushed, timestep: float, turns: list[float]) -> None:
    """As `advance`, one step for each turn, with nothing recorded."""
    # A new space takes its first step by the public call: it checks the bodies' masses, which the private one does not.
    public = len(turns) if lib is None else int(space.current_time_step == 0.0)
    for turn in turns[:public]:
        crank.angle = turn
        for body, force in pushed:
            body.force = force
        space.step(timestep)
    if public < len(turns):
        _repeat_private(space._space, crank._body, [(b._body, f) for b, f in pushed], timestep, turns[public:])


def _repeat_private(space: Any, crank: Any, pushed: PrivatePushed, timestep: float, turns: list[float]) -> None:
    set_angle, set_force, take_step = lib.cpBodySetAngle, lib.cpBodySetForce, lib.cpSpaceStep
    for turn in turns:
        set_angle(crank, turn)
        for body, force in pushed:
            set_force(body, force)
        take_step(space, timestep)


def _by_properties(
    made: Build, settings: PymunkSettings, turns: Array, centres: Array, rates: Array, loading: Loading | None = None
) -> None:
    """Take a step from each turn, and fill in the samples after every one, or every so-many-th."""
    bodies, crank, substeps = made.bodies, made.crank, settings.substeps
    for n, turn in enumerate(turns.tolist(), start=1):
        crank.angle = turn
        if loading is None:
            for body, force in made.pushed:
                body.force = force
        else:
            loading.give(float(loading.times[n - 1]))
        made.space.step(settings.substep)
        if settings.rounded_state:
            _round(bodies)
        if n % substeps == 0:
            _record(bodies, centres[n // substeps - 1], rates[n // substeps - 1])


def _round(bodies: tuple[pymunk.Body, ...]) -> None:
    for body in bodies:
        x, y, turn, vx, vy, spin = np.array(
            [*body.position, body.angle, *body.velocity, body.angular_velocity], dtype=np.float32
        ).tolist()
        body.position, body.angle = (x, y), turn
        body.velocity, body.angular_velocity = (vx, vy), spin


def _record(bodies: tuple[pymunk.Body, ...], centres: Array, rates: Array) -> None:
    for i, body in enumerate(bodies):
        centres[3 * i : 3 * i + 3] = (*body.position, body.angle)
        rates[3 * i : 3 * i + 3] = (*body.velocity, body.angular_velocity)


def _by_memory(made: Build, settings: PymunkSettings, turns: Array, centres: Array, rates: Array) -> None:
    # A new space takes its first step by the public call: it checks the bodies' masses, which the private one does not.
    begun, substeps = int(made.space.current_time_step == 0.0), settings.substeps
    _by_properties(made, settings, turns[: begun * substeps], centres, rates)
    memory = [memory_of(body) for body in made.bodies]
    crank, pushed = memory_of(made.crank), [(body._body, force) for body, force in made.pushed]
    step_and_copy = _step_round_and_copy if settings.rounded_state else _step_and_copy
    for steps in cache_blocks(len(centres) - begun, BLOCK):
        rows = slice(begun + steps.start, begun + steps.stop)
        turned = turns[substeps * rows.start : substeps * rows.stop].tolist()
        copies = step_and_copy(made.space._space, crank, pushed, settings.substep, turned, memory)
        states = np.frombuffer(copies).reshape(len(turned), WIDTH * len(memory))[substeps - 1 :: substeps]
        # Without a mode, `take` would first fill an array of its own.
        np.take(states, _columns(CENTRE, len(memory)), axis=1, out=centres[rows], mode="clip")
        np.take(states, _columns(RATE, len(memory)), axis=1, out=rates[rows], mode="clip")


def _columns(of_body: tuple[int, ...], bodies: int) -> list[int]:
    """Columns of some of every body's numbers, where the bodies' numbers stand side by side."""
    return [WIDTH * body + k for body in range(bodies) for k in of_body]


def _step_and_copy(
    space: Any, crank: memoryview, pushed: PrivatePushed, timestep: float, turns: list[float], memory: list[memoryview]
) -> bytearray:
    """The bodies' memory after each step, one copy after the other."""
    angle = crank.cast("d")[ANGLE : ANGLE + 1]
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


def _step_round_and_copy(
    space: Any, crank: memoryview, pushed: PrivatePushed, timestep: float, turns: list[float], memory: list[memoryview]
) -> bytearray:
    """As `_step_and_copy`, with all numbers rounded to single precision after each step."""
    numbers = [np.frombuffer(body) for body in memory]
    copies = bytearray()
    for turn in turns:
        _step_and_copy(space, crank, pushed, timestep, [turn], memory)
        for own in numbers:
            own[:] = own.astype(np.float32)  # the forces among them are zero after a step
        copies += b"".join(memory)
    return copies


def memory_of(body: pymunk.Body) -> memoryview:
    """The numbers of a body that its steps change, where Chipmunk keeps them; valid as long as the body is."""
    return memoryview(ffi.buffer(ffi.cast("char *", body._body) + OFFSET, 8 * WIDTH))


def memory_is_known() -> bool:
    """True where Chipmunk keeps a body's state in the place of `memory_of`, and takes an angle there."""
    if lib is None:
        return False
    body = pymunk.Body(1.0, 1.0)
    body.position, body.velocity, body.force = (2.0, 3.0), (4.0, 5.0), (6.0, 7.0)
    body.angle, body.angular_velocity = 8.0, 9.0
    numbers = memory_of(body).cast("d")
    if numbers.tolist() != [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]:
        return False
    numbers[ANGLE] = 10.0
    return body.angle == 10.0
