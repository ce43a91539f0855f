"""MuJoCo: a recorded run against one call of the engine that takes the same steps of the same model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import mujoco

from benchmarks.row import Row
from benchmarks.side_by_side import against, cpu_seconds, interleaved
from conrod import MuJoCoSettings, Saw
from conrod.comparison.trajectory import PointTracks
from conrod.engines.mujoco import dynamics
from conrod.engines.mujoco.engine import MUJOCO_ENGINE
from conrod.engines.mujoco.model import MuJoCoModel, build
from conrod.engines.run import run_in_one_piece

SAW = Saw(speed=52.36)
STEPS_PER_TURN, STEPS = 1000, 100_000
BASE, RECORDED, WHOLE = "one mj_step(nstep)", "all points recorded", "the whole run, judged"
# What is cheaper to step is harder to record for a tenth of it: Euler costs a quarter of RK4.
INTEGRATORS = ("RK4", "Euler")


def settings(integrator: str) -> MuJoCoSettings:
    """The hardened preset with an integrator."""
    return replace(MuJoCoSettings.hardened(SAW, STEPS_PER_TURN), integrator=integrator)


def started(made: MuJoCoModel) -> mujoco.MjData:
    """The state that a run starts from."""
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(SAW, 0.0)
    return data


def stepped(made: MuJoCoModel, data: mujoco.MjData, steps: int) -> None:
    """The base: steps, sensors included, and nothing kept."""
    mujoco.mj_step(made.model, data, nstep=steps)


def recorded(made: MuJoCoModel, chosen: MuJoCoSettings, steps: int) -> Mapping[str, PointTracks]:
    """What `run` does up to the tracks of all observed points."""
    times, states, sensors = dynamics.simulate(made, SAW, chosen, steps, 0.0)
    return dynamics.point_tracks(made, dynamics.sample_instants(made, times, states, sensors), sensors)


def rows(repeats: int) -> list[Row]:
    """Ratios for each integrator."""
    found = []
    for integrator in INTEGRATORS:
        chosen = settings(integrator)
        made = build(SAW, chosen)
        sides = {
            # A run takes one step more than it has samples after the first: the last sample's sensors come with it.
            BASE: partial(_stepping, made, STEPS + 1),
            RECORDED: partial(cpu_seconds, partial(recorded, made, chosen, STEPS)),
            WHOLE: partial(
                cpu_seconds, partial(run_in_one_piece, MUJOCO_ENGINE, SAW, chosen, STEPS / STEPS_PER_TURN, 0.0)
            ),
        }
        found += against(interleaved(sides, repeats), BASE, {RECORDED: 1.10, WHOLE: 1.20}, f"MuJoCo, {integrator}")
    return found


def _stepping(made: MuJoCoModel, steps: int) -> float:
    return cpu_seconds(partial(stepped, made, started(made), steps))
