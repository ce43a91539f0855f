"""The loop over steps. The one module that goes past pymunk's public interface, with the public way beside it.

The public properties of the bodies cost several times the step itself. So the numbers are copied from where Chipmunk
keeps them, eight in a row for a body, which a look at a body of known state has found in place. Both ways give the
same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.space import Build, Pushed
from conrod.exact.motion import Array, cache_blocks

# In a cpBody position, velocity, force, angle and angular velocity follow two function pointers, four numbers of mass
# and the centre of gravity (chipmunk_structs.h).
OFFSET, WIDTH = 64, 8  # bytes, numbers
ANGLE = 6
CENTRE, RATE = (0, 1, ANGLE), (2, 3, 7)  # position with angle, velocity with angular velocity
BLOCK = 4096  # steps whose copies are kept together, so that they stay in the cache

Give = Callable[[float], object]  # gives all bodies their forces for the step that begins at a time [s]


def state(made: Build) -> tuple[Array, Array]:
    """Centres of gravity with turns, and their rates, as they are now; each (1, 3 n)."""
    centres: Array = np.empty((1, 3 * len(made.bodies)))
    rates: Array = np.empty_like(centres)
    _record(made.bodies, centres[0], rates[0])
    return centres, rates


def advance(
    made: Build,
    settings: PymunkSettings,
    turns: Array,
    known: tuple[Array, Array] | None = None,
    loading: tuple[Give, Array] | None = None,
) -> tuple[Array, Array]:
    """Step through the given crank turns.

    Args:
        turns: (T,) [rad], of the crank body at each sample, which is the start of the step that follows it.
        known: the first samples, where the space is at the last of them; None where it is at the first one.
        loading: forces beside constant ones, with the times (T,) [s] of the samples.

    Returns:
        Centres of gravity with turns, and their rates, at all samples; each (T, 3 n).
    """
    begun = state(made) if known is None else known
    first = len(begun[0])
    turned, begins = turns[first - 1 : -1], None if loading is None else (loading[0], loading[1][first - 1 : -1])
    if settings.rounded_state:
        turned = turned.astype(np.float32).astype(float)
    centres, rates = np.empty((2, len(turns), 3 * len(made.bodies)))
    centres[:first], rates[:first] = begun
    loop = _Loop(made, settings.timestep, begins, rounded=settings.rounded_state)
    with np.errstate(over="ignore"):  # what is too large becomes infinite, which the outcome tells
        loop.through(turned, centres[first:], rates[first:])
    return centres, rates


def advance_free(
    made: Build, timestep: float, steps: int, loading: tuple[Give, Array] | None = None
) -> tuple[Array, Array]:
    """Take so many steps with nothing driven.

    Args:
        loading: forces beside constant ones, with the times (steps,) [s] at which the steps begin.

    Returns:
        Centres of gravity with turns, and their rates, after each step; each (steps, 3 n).
    """
    centres, rates = np.empty((2, steps, 3 * len(made.bodies)))
    _Loop(made, timestep, loading, driven=False).through(np.zeros(steps), centres, rates)
    return centres, rates


def repeat(space: pymunk.Space, crank: pymunk.Body, pushed: Pushed, timestep: float, turns: list[float]) -> None:
    """As `advance`, one step for each turn, with nothing recorded."""
    # A new space takes its first step by the public call: it checks the bodies' masses, which the private one does not.
    public = int(space.current_time_step == 0.0)
    for turn in turns[:public]:
        crank.angle = turn
        for body, force in pushed:
            body.force = force
        space.step(timestep)
    set_angle, set_force, take_step = lib.cpBodySetAngle, lib.cpBodySetForce, lib.cpSpaceStep
    own, driven, forces = space._space, crank._body, [(body._body, force) for body, force in pushed]
    for turn in turns[public:]:
        set_angle(driven, turn)
        for one, force in forces:
            set_force(one, force)
        take_step(own, timestep)


@dataclass(frozen=True)
class _Loop:
    """Steps of a space, of which every one is recorded.

    Attributes:
        loading: forces beside constant ones, with the times at which the steps begin.
        driven: whether the crank's angle is written before each step.
        rounded: to single precision, after each step.
    """

    made: Build
    timestep: float
    loading: tuple[Give, Array] | None = None
    driven: bool = True
    rounded: bool = False

    def through(self, turns: Array, centres: Array, rates: Array) -> None:
        """Take a step from each crank turn, and fill in the samples after them."""
        if self.loading is not None or self.rounded or not memory_is_known():
            self._by_properties(turns, centres, rates)
            return
        # A new space takes its first step by the public call, which checks the bodies' masses.
        begun = int(self.made.space.current_time_step == 0.0)
        self._by_properties(turns[:begun], centres, rates)
        memory = [memory_of(body) for body in self.made.bodies]
        centre, rate = ([WIDTH * k + column for k in range(len(memory)) for column in of] for of in (CENTRE, RATE))
        for steps in cache_blocks(len(centres) - begun, BLOCK):
            rows = slice(begun + steps.start, begun + steps.stop)
            turned = turns[rows].tolist()
            states = np.frombuffer(self._copy(turned, memory)).reshape(len(turned), WIDTH * len(memory))
            # Without a mode, `take` would first fill an array of its own.
            np.take(states, centre, axis=1, out=centres[rows], mode="clip")
            np.take(states, rate, axis=1, out=rates[rows], mode="clip")

    def _by_properties(self, turns: Array, centres: Array, rates: Array) -> None:
        made = self.made
        for n, turn in enumerate(turns.tolist()):
            if self.driven:
                made.crank.angle = turn
            if self.loading is None:
                for body, force in made.pushed:
                    body.force = force
            else:
                self.loading[0](float(self.loading[1][n]))
            made.space.step(self.timestep)
            if self.rounded:
                _round(made.bodies)
            _record(made.bodies, centres[n], rates[n])

    def _copy(self, turns: list[float], memory: list[memoryview]) -> bytearray:
        """The bodies' memory after each step, one copy after the other."""
        # Where nothing is driven a number that belongs to no body is written.
        crank = memory_of(self.made.crank) if self.driven else memoryview(bytearray(8 * WIDTH))
        angle, timestep, space = crank.cast("d")[ANGLE : ANGLE + 1], self.timestep, self.made.space._space
        pushed = [(body._body, force) for body, force in self.made.pushed]
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
