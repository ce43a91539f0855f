"""The loop over steps. The one module that calls private functions of pymunk's package, with the public way beside it.

pymunk's own batched reader appends the state of all bodies to one growing buffer, which is read once at the end; the
public properties cost several times the step itself. Both ways give the same bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pymunk

from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import Build, Pushed
from conrod.motion import Array

try:
    from pymunk._chipmunk_cffi import ffi, lib
    from pymunk.batch import BodyFields, Buffer

    BATCHED_READER: Any = ffi.addressof(lib, "pmSpaceBodyGetIteratorFuncBatched")
except (ImportError, AttributeError):  # another release of pymunk may have none of these
    BATCHED_READER = None

WIDTH = 6  # numbers that the batched reader appends for a body: position, angle, velocity, angular velocity


def advance(made: Build, settings: PymunkSettings, turns: Array) -> tuple[Array, Array]:
    """Step through the given crank turns.

    Args:
        turns: (T,) [rad], of the crank body at the start of each step, and one at the end.

    Returns:
        Centres of gravity with turns, and their rates, before the first and after every step; each (T, 3 n).
    """
    way = _by_properties if BATCHED_READER is None else _by_batch
    return way(made, settings, turns)


def repeat(space: pymunk.Space, crank: pymunk.Body, pushed: Pushed, timestep: float, turns: list[float]) -> None:
    """As `advance`, one step for each turn, with nothing recorded."""
    # A new space takes its first step by the public call: it checks the bodies' masses, which the private one does not.
    public = len(turns) if BATCHED_READER is None else int(space.current_time_step == 0.0)
    for turn in turns[:public]:
        crank.angle = turn
        for body, force in pushed:
            body.force = force
        space.step(timestep)
    if public < len(turns):
        _repeat_private(space._space, crank._body, [(b._body, f) for b, f in pushed], timestep, turns[public:])


def _repeat_private(
    space: Any, crank: Any, pushed: list[tuple[Any, tuple[float, float]]], timestep: float, turns: list[float]
) -> None:
    set_angle, set_force, take_step = lib.cpBodySetAngle, lib.cpBodySetForce, lib.cpSpaceStep
    for turn in turns:
        set_angle(crank, turn)
        for body, force in pushed:
            set_force(body, force)
        take_step(space, timestep)


def _by_properties(made: Build, settings: PymunkSettings, turns: Array) -> tuple[Array, Array]:
    bodies, crank = made.bodies, made.crank
    centres, rates = np.empty((len(turns), 3 * len(bodies))), np.empty((len(turns), 3 * len(bodies)))
    _record(bodies, centres[0], rates[0])
    for n, turn in enumerate(turns[:-1].tolist(), start=1):
        crank.angle = turn
        for body, force in made.pushed:
            body.force = force
        made.space.step(settings.timestep)
        _record(bodies, centres[n], rates[n])
    return centres, rates


def _record(bodies: tuple[pymunk.Body, ...], centres: Array, rates: Array) -> None:
    for i, body in enumerate(bodies):
        centres[3 * i : 3 * i + 3] = (*body.position, body.angle)
        rates[3 * i : 3 * i + 3] = (*body.velocity, body.angular_velocity)


def _by_batch(made: Build, settings: PymunkSettings, turns: Array) -> tuple[Array, Array]:
    # The public call once: it checks the bodies' masses, which the private one does not.
    first = turns[:2] if len(turns) > 1 else turns
    centres, rates = _by_properties(made, settings, first)
    buffer, data = _reader()
    space, crank, step = made.space._space, made.crank._body, settings.timestep
    set_angle, set_force = lib.cpBodySetAngle, lib.cpBodySetForce
    take_step, each_body = lib.cpSpaceStep, lib.cpSpaceEachBody
    pushed = [(body._body, force) for body, force in made.pushed]
    for turn in turns[1:-1].tolist():
        set_angle(crank, turn)
        for body, force in pushed:
            set_force(body, force)
        take_step(space, step)
        each_body(space, BATCHED_READER, data)
    # A copy, because the buffer's memory goes with the buffer.
    visited = _visited(made)
    table = np.frombuffer(buffer.float_buf(), dtype=float).copy().reshape(-1, len(visited), WIDTH)
    table = table[:, [visited.index(body.id) for body in made.bodies]]
    centres = np.concatenate([centres, table[:, :, :3].reshape(len(table), -1)])
    return centres, np.concatenate([rates, table[:, :, 3:].reshape(len(table), -1)])


def _reader() -> tuple[Buffer, Any]:
    """A buffer, and the structure that tells the batched reader what to append to it."""
    buffer = Buffer()
    data = ffi.new("pmBatchedData *")
    data.fields = _fields().value
    data.floatArray, data.intArray = buffer._float_arr, buffer._int_arr
    return buffer, data


def _fields() -> BodyFields:
    return BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY


def _visited(made: Build) -> list[int]:
    """Identities of the bodies that the batched reader visits, in its order; the static body is among them."""
    buffer = Buffer()
    pymunk.batch.get_space_bodies(made.space, BodyFields.BODY_ID, buffer)
    return [int(identity) for identity in np.frombuffer(buffer.int_buf(), dtype=np.uintp)]
