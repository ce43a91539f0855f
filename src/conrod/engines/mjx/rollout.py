"""MJX steps, and its states are kept. What is compiled serves all machines of one layout, whatever their sizes.

As in MuJoCo, the sensors that a step leaves belong to the state before it; but under RK4 to the last of its stages.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from conrod.engines.engine import Machine, run_of
from conrod.engines.mjx.settings import MJXSettings
from conrod.engines.mujoco import timing
from conrod.engines.mujoco.model import Build, build
from conrod.exact.motion import Array

with redirect_stdout(io.StringIO()):  # it prints that it has no Warp
    from mujoco import mjx

BLOCK = 512  # samples that are kept at a time: the length of an array of what is compiled


def stepped(model: Any, data: Any) -> Any:
    """Data after a step, of the same types: in double precision MJX also makes some of its integers longer."""
    return jax.tree.map(lambda after, before: after.astype(before.dtype), mjx.step(model, data), data)


def _record(model: Any, data: Any, samples: Any) -> tuple[Any, Any, Any]:
    """Data after so many steps, with states (BLOCK, nq + nv) and sensors (BLOCK, ..) before each."""

    def step(k: Any, carried: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        now, states, sensors = carried
        states = states.at[k].set(jnp.concatenate([now.qpos, now.qvel]))
        after = stepped(model, now)
        read = mjx.forward(model, now) if model.opt.integrator == mjx.IntegratorType.RK4 else after
        return after, states, sensors.at[k].set(read.sensordata)

    kept = (jnp.zeros((BLOCK, model.nq + model.nv)), jnp.zeros((BLOCK, model.nsensordata)))
    found: tuple[Any, Any, Any] = jax.lax.fori_loop(0, samples, step, (data, *kept))
    return found


def _advance(model: Any, data: Any, steps: Any) -> Any:
    """Data after so many steps, with nothing kept."""
    return jax.lax.fori_loop(0, steps, lambda _, now: stepped(model, now), data)


record, advance = jax.jit(_record), jax.jit(_advance)


def kept(of: Any, model: Any, data: Any, samples: int, double: bool) -> tuple[Any, Array, Array]:
    """Data after so many samples, with states (.., T, nq + nv) and sensor data (.., T, ..) of each, as doubles.

    Args:
        of: `record`, of one machine, or what is mapped from it over several.
    """
    found = []
    for done in range(0, samples, BLOCK):
        count = min(BLOCK, samples - done)
        with jax.enable_x64(double):
            data, *values = of(model, data, count)
        found.append([np.asarray(value[..., :count, :], dtype=float) for value in values])
    states, sensors = (np.concatenate(values, axis=-2) for values in zip(*found, strict=True))
    return data, states, sensors


class Recorder:
    """A machine that is stepped from a state of its model, as MuJoCo's recorder does it.

    Attributes:
        warnings: of the engine; it has none.
    """

    warnings: Mapping[str, int] = {}

    def __init__(self, made: Build, settings: MJXSettings, coordinates: Array, rates: Array) -> None:
        self._timestep, self._double, self._steps = settings.timestep, settings.precision == "double", 0
        self._model, self._data = put(made, coordinates, rates, self._double)

    def next(self, samples: int) -> tuple[Array, Array]:
        """The next T samples: states (T, 1 + nq + nv), clock first, and sensor data (T, ..), all doubles."""
        self._data, states, sensors = kept(record, self._model, self._data, samples, self._double)
        # From the step index: a sum of steps in single precision stands still.
        clock = self._timestep * np.arange(self._steps, self._steps + samples)
        self._steps += samples
        return np.column_stack([clock, states]), sensors


def put(made: Build, coordinates: Array, rates: Array, double: bool) -> tuple[Any, Any]:
    """Model and data of MJX, in a state.

    Raises:
        NotImplementedError: MJX says what it lacks of the model.
    """
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = coordinates, rates
    with jax.enable_x64(double):
        return mjx.put_model(made.model), mjx.put_data(made.model, data)


def stepper(machine: Machine, settings: MJXSettings) -> Callable[[int], None]:
    """A machine in the exact state of its start, with nothing recorded."""
    made = build(machine, settings, sensors=False)
    double = settings.precision == "double"
    return _compiled(*put(made, *made.start_state(machine, run_of(machine, 1, 1.0)[0]), double), double)


def reference_loop() -> Callable[[int], None]:
    """MuJoCo's slider-crank, in single precision."""
    loop = timing.reference_loop()
    return _compiled(mjx.put_model(loop.model), mjx.put_data(loop.model, loop.data), double=False)


def _compiled(model: Any, data: Any, double: bool) -> Callable[[int], None]:
    """Advance the data by so many steps at each call; compiled before the first."""

    def call(steps: int) -> None:
        nonlocal data
        with jax.enable_x64(double):
            data = jax.block_until_ready(advance(model, data, steps))

    call(0)
    return call
