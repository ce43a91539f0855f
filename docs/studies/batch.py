"""`python -m docs.studies.batch [--machines N] [--out DIR]`: saws of a drawing's tolerances, all in one call of MJX.

Lengths are drawn at random within ISO 2768-1, class m. Of each saw: by how much its exact stroke is off the drawing's,
the error of MJX's run and of MuJoCo's, and whether that is within the bound of the engine's law for this very saw.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.machine import described
from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Trajectory, concatenate_pieces
from conrod.crash import run_guarded
from conrod.engines import engine_named
from conrod.engines.engine import Engine, Machine
from conrod.engines.mjx import MJXSettings
from conrod.engines.mjx import engine as rollout
from conrod.engines.mujoco import MuJoCoSettings, dynamics
from conrod.engines.mujoco.model import build
from conrod.exact.motion import Array
from conrod.execution.files import folder_to_write
from conrod.execution.writing import write_together
from conrod.report.kind import Reproduction
from conrod.report.terminal import print_parts
from conrod.report.writer import report_batch
from conrod.scenes import Scene
from docs.studies.batch_report import BATCH_REPORT, BatchFindings, EngineBatch, Spread
from docs.studies.fleets import DRAWING, STEPS, saw, saw_sizes

PART = "batch"


@dataclass(frozen=True)
class Measured:
    """An engine on all saws: errors over L, and over the bounds of its law (n,); CPU seconds to compile and to step."""

    name: str
    errors: Array
    shares: Array
    compiling: float
    stepping: float


def saws(count: int) -> list[Scene]:
    """Saws of the drawing, each as it may have been made."""
    return [saw(size) for size in saw_sizes(count)]


def strokes(machines: Iterable[Scene]) -> Array:
    """Exact travel of the slider (n,) [m]."""
    return np.array(
        [np.ptp(one.motion(one.kinematics.angles(720), one.speed).point("C").position[:, 0]) for one in machines]
    )


def judged(
    name: str, engine: Engine[Any], machines: Sequence[Scene], settings: Sequence[Any], runs: Iterable[Trajectory],
    costs: tuple[float, float],
) -> Measured:  # fmt: skip
    """The errors of runs, each held against the engine's law."""
    law: Any = engine
    errors = np.array([compare(run, one).worst("position") for run, one in zip(runs, machines, strict=True)])
    bounds = [law.expected_error(one, by).position or np.nan for one, by in zip(machines, settings, strict=True)]
    return Measured(name, errors, errors / np.array(bounds), *costs)


_record = jax.jit(jax.vmap(rollout.record_block, in_axes=(0, 0, None)))
_advance = jax.jit(jax.vmap(rollout.advance, in_axes=(0, 0, None)))


class Batch:
    """Machines of one layout with the settings of each, in their exact states at crank angle 0, stepped in one call.

    JAX maps a step over their stacked models.
    """

    def __init__(self, machines: Sequence[Machine], settings: Sequence[MJXSettings]) -> None:
        self._machines, self._settings = machines, settings
        self._made = [build(machine, one) for machine, one in zip(machines, settings, strict=True)]
        self._double = settings[0].precision == "double"
        states = [made.start_state(machine, 0.0) for made, machine in zip(self._made, machines, strict=True)]
        placed = [
            rollout.put_on_device(made, *state, self._double) for made, state in zip(self._made, states, strict=True)
        ]
        with jax.enable_x64(self._double):
            self._models, self._data = jax.tree.map(lambda *leaves: jnp.stack(leaves), *placed)

    def __call__(self, steps: int) -> None:
        """Step all machines, with nothing recorded."""
        with jax.enable_x64(self._double):
            jax.block_until_ready(_advance(self._models, self._data, steps))

    def trajectories(self, steps: int) -> Iterator[Trajectory]:
        """The recorded run of each machine, over so many steps from the start."""
        _, states, sensors = rollout.record_samples(_record, self._models, self._data, steps + 1, self._double)
        for k, (machine, settings, made) in enumerate(zip(self._machines, self._settings, self._made, strict=True)):
            clock = settings.timestep * np.arange(steps + 1)
            replayed = Replayed(np.column_stack([clock, states[k]]), sensors[k])
            turns = steps / settings.steps_per_revolution
            pieces = dynamics.record_run(
                made, replayed, machine, settings, turns, 0.0, steps, engine_named("mjx").version
            )
            yield concatenate_pieces(list(pieces)).trajectory


class Replayed:
    """A recording of one piece that has been made: states (T, 1 + nq + nv) and sensor data (T, ..)."""

    warnings: Mapping[str, int] = {}

    def __init__(self, *recorded: Array) -> None:
        self._recorded = recorded

    def next_samples(self, samples: int) -> tuple[Array, Array]:
        states, sensors = self._recorded
        return states, sensors


def by_mjx(machines: Sequence[Scene], preset: str) -> Measured:
    """All in one call."""
    engine = engine_named("mjx")
    settings = [engine.presets[preset](one, STEPS) for one in machines]
    batch = Batch(machines, settings)
    costs = cpu_seconds(lambda: batch(0)), cpu_seconds(lambda: batch(STEPS))
    return judged(f"MJX {preset}", engine, machines, settings, batch.trajectories(STEPS), costs)


def by_mujoco(machines: Sequence[Scene], name: str, preset: Callable[[Machine, int], MuJoCoSettings]) -> Measured:
    """One after the other."""
    engine: Any = engine_named("mujoco")
    settings = [preset(one, STEPS) for one in machines]
    steppers = [engine.stepper(one, by) for one, by in zip(machines, settings, strict=True)]
    stepping = cpu_seconds(lambda: [one(STEPS) for one in steppers])
    pieces = (engine.run(one, by, 1.0) for one, by in zip(machines, settings, strict=True))
    runs = (concatenate_pieces(list(one)).trajectory for one in pieces)
    return judged(f"MuJoCo {name}", engine, machines, settings, runs, (0.0, stepping))


def as_mjx(machine: Machine, steps: int) -> MuJoCoSettings:
    """MuJoCo's settings that are those of MJX."""
    settings = vars(MJXSettings.tuned(machine, steps))
    return MuJoCoSettings(**{field.name: settings[field.name] for field in fields(MuJoCoSettings)})


def cpu_seconds(call: Callable[[], Any]) -> float:
    """Of this process, with all its threads."""
    begun = time.process_time()
    call()
    return time.process_time() - begun


def batch_findings(machines: Sequence[Scene], measured: Sequence[Measured]) -> BatchFindings:
    """Sum up what is found of all saws."""
    nominal, travel, made = strokes([DRAWING])[0], strokes(machines), described()
    engines = tuple(
        EngineBatch(
            one.name,
            spread(one.errors),
            None if np.isnan(one.shares).any() else spread(one.shares),
            int((one.shares <= 1.0).sum()),
            one.compiling,
            one.stepping / len(machines) / STEPS,
        )
        for one in measured
    )
    off = spread(np.abs(travel - nominal))
    return BatchFindings(len(machines), STEPS, float(nominal), off, engines, made["processor"], made["cores"])


def spread(values: Array) -> Spread:
    """Least, median, 95th percentile and largest of some values."""
    return Spread(*map(float, np.percentile(values, (0.0, 50.0, 95.0, 100.0))))


def main() -> None:
    """Run the saws, print what comes out, and write the page where it is asked for."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.batch", description=main.__doc__)
    parser.add_argument("--machines", type=int, default=1000, metavar="N", help="[1000]")
    parser.add_argument("--out", metavar="DIR", help="write the page")
    asked = parser.parse_args()
    machines = saws(asked.machines)
    found = [
        by_mjx(machines, "tuned"),
        by_mjx(machines, "tuned-single"),
        by_mujoco(machines, "tuned", MuJoCoSettings.tuned),
    ]
    found.append(by_mujoco(machines, "as MJX", as_mjx))
    findings = batch_findings(machines, found)
    print_parts(BATCH_REPORT.printed([findings]))
    if asked.out:
        folder = folder_to_write(asked.out, "--out")
        write_together([report_batch(BATCH_REPORT, {PART: findings}, folder, Reproduction("make batch"))])


if __name__ == "__main__":
    run_guarded(main)
