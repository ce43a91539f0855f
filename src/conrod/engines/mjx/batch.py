"""Many machines of one layout stepped in one call: JAX maps a step over their stacked models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import jax
import jax.numpy as jnp
import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.mjx import rollout
from conrod.engines.mjx.engine import ENGINE
from conrod.engines.mjx.settings import MJXSettings
from conrod.engines.mujoco import dynamics
from conrod.engines.mujoco.model import build
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.runs.trajectory import Trajectory, concatenate_pieces

_record = jax.jit(jax.vmap(rollout.record, in_axes=(0, 0, None)))
_advance = jax.jit(jax.vmap(rollout.advance, in_axes=(0, 0, None)))


class Batch:
    """Machines of one layout with the settings of each, in their exact states at crank angle 0.

    Raises:
        InvalidInput: their models differ in more than sizes, or their precisions do.
    """

    def __init__(self, machines: Sequence[Machine], settings: Sequence[MJXSettings]) -> None:
        self._machines, self._settings = machines, settings
        self._made = [build(machine, one) for machine, one in zip(machines, settings, strict=True)]
        self._double = settings[0].precision == "double"
        states = [made.start_state(machine, 0.0) for made, machine in zip(self._made, machines, strict=True)]
        placed = [rollout.put(made, *state, self._double) for made, state in zip(self._made, states, strict=True)]
        if len({one.precision for one in settings}) > 1 or len({jax.tree.structure(one) for one in placed}) > 1:
            raise InvalidInput("a batch is of machines that differ in sizes alone, in one precision")
        with jax.enable_x64(self._double):
            self._models, self._data = jax.tree.map(lambda *leaves: jnp.stack(leaves), *placed)

    def __call__(self, steps: int) -> None:
        """Step all machines, with nothing recorded."""
        with jax.enable_x64(self._double):
            jax.block_until_ready(_advance(self._models, self._data, steps))

    def trajectories(self, steps: int) -> Iterator[Trajectory]:
        """The recorded run of each machine, over so many steps from the start."""
        _, states, sensors = rollout.kept(_record, self._models, self._data, steps + 1, self._double)
        for k, (machine, settings, made) in enumerate(zip(self._machines, self._settings, self._made, strict=True)):
            clock = settings.timestep * np.arange(steps + 1)
            replayed = Replayed(np.column_stack([clock, states[k]]), sensors[k])
            turns = steps / settings.steps_per_revolution
            pieces = dynamics.recorded(made, replayed, machine, settings, turns, 0.0, steps, ENGINE.version)
            yield concatenate_pieces(list(pieces)).trajectory


class Replayed:
    """A recording of one piece that has been made: states (T, 1 + nq + nv) and sensor data (T, ..)."""

    warnings: Mapping[str, int] = {}

    def __init__(self, *recorded: Array) -> None:
        self._recorded = recorded

    def next(self, samples: int) -> tuple[Array, Array]:
        states, sensors = self._recorded
        return states, sensors
