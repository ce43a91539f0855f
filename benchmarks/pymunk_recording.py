"""pymunk: a recorded run against a Python loop over the step function of the wheel; and its kinematic mode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from benchmarks.row import Row
from benchmarks.side_by_side import Side, against, cpu_seconds, interleaved
from conrod import PymunkSettings, Saw
from conrod.comparison.trajectory import PointTracks
from conrod.engines.pymunk.dynamics import crank_angles, point_tracks, sample_instants
from conrod.engines.pymunk.engine import PYMUNK_ENGINE
from conrod.engines.pymunk.space import PymunkSpace, build
from conrod.engines.pymunk.stepping import advance, advance_unrecorded
from conrod.engines.run import run_in_one_piece
from conrod.exact.motion import Array

SAW = Saw(speed=52.36)
STEPS_PER_TURN, STEPS, ANGLES = 1000, 100_000, 360
BASE, DRIVEN = "a loop over cpSpaceStep", "that loop with the crank's angle written"
RECORDED, WHOLE = "all points recorded", "the whole run, judged"
# Rod and slider are bodies: the two-body form, which needs 30 iterations for order 2 in velocity.
SETTINGS = replace(PymunkSettings.tuned(SAW, STEPS_PER_TURN), iterations=30)


def started() -> PymunkSpace:
    """A space in the state that a run starts from."""
    made = build(SAW, SETTINGS)
    poses, slopes = SAW.kinematics.derivatives(np.zeros(1), 1)
    made.set_states(poses[0], slopes[0] * SAW.speed)
    return made


def times_of(steps: int) -> Array:
    """Times [s] of the samples of so many steps; the first included."""
    return np.asarray(SETTINGS.timestep * np.arange(steps + 1), dtype=float)


def stepped(made: PymunkSpace, steps: int) -> None:
    """The base: steps, and nothing else, the crank's angle left to the engine."""
    # The first step by the public call, which checks the space.
    made.space.step(SETTINGS.timestep)
    space, step, take_step = made.space._space, SETTINGS.timestep, lib.cpSpaceStep
    for _ in range(steps - 1):
        take_step(space, step)


def driven(made: PymunkSpace, steps: int) -> None:
    """The same steps with the crank's angle written before each, as a run does; nothing recorded."""
    advance_unrecorded(made, SETTINGS.timestep, crank_angles(SAW, times_of(steps)[:-1]))


def recorded(made: PymunkSpace, steps: int) -> Mapping[str, PointTracks]:
    """What `run` does up to the tracks of all observed points."""
    times = times_of(steps)
    centres, rates = advance(made, SETTINGS.timestep, crank_angles(SAW, times[:-1]))
    at = sample_instants(made.mechanism, SETTINGS.timestep, times, centres, rates)
    return point_tracks(made.mechanism, at, centres, rates)


def rows(repeats: int) -> list[Row]:
    """Ratios to the bare loop, and the time of kinematic mode."""
    sides: dict[str, Side] = {
        BASE: lambda: cpu_seconds(partial(stepped, started(), STEPS)),
        DRIVEN: lambda: cpu_seconds(partial(driven, started(), STEPS)),
        RECORDED: lambda: cpu_seconds(partial(recorded, started(), STEPS)),
        WHOLE: partial(
            cpu_seconds, partial(run_in_one_piece, PYMUNK_ENGINE, SAW, SETTINGS, STEPS / STEPS_PER_TURN, 0.0)
        ),
    }
    ratios = against(interleaved(sides, repeats), BASE, {RECORDED: 1.40, WHOLE: 1.50}, f"pymunk {pymunk.version}")
    solving = partial(cpu_seconds, partial(PYMUNK_ENGINE.solve_kinematics, SAW, SAW.kinematics.angles(ANGLES)))
    (seconds,) = interleaved({"kinematic mode": solving}, repeats).values()
    return [*ratios, Row("pymunk: kinematic mode of the saw, 360 angles", "ms", [1e3 * s for s in seconds], 60.0)]
