"""Loads that are programs in time act at their times, wherever a run begins."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.engines.running import whole_run
from conrod.exact.motion import Array
from conrod.mechanism.loads import Load, TimePulse, Turn
from conrod.scenes import scene_named
from conrod.scenes.scene import Scene

SAW = scene_named("saw-500rpm")
START = 2.0  # [rad]
BEGIN = START / SAW.speed  # [s]
TAKEN = {"mujoco": "stock", "pymunk": "tuned"}


class Loaded:
    """The saw with a pulse on its rod; what of its motion the pulse changes is what the engine's joints give."""

    def __init__(self, scene: Scene, *pulses: TimePulse) -> None:
        loads = tuple(Load(f"pulse-{k}", Turn("ground", "rod"), pulse) for k, pulse in enumerate(pulses))
        self.speed, self.kinematics = scene.speed, type(scene.kinematics)(replace(scene.mechanism(), loads=loads))


def slider(engine: str, *pulses: TimePulse) -> Array:
    """Positions of the slider and rates of the drive's crank in a quarter of a turn."""
    made = engine_named(engine)
    settings = made.presets[TAKEN[engine]](SAW, 200)
    machine: Any = Loaded(SAW, *pulses)
    run = whole_run(made, machine, settings, 0.25, START)
    assert run.bodies is not None
    return np.hstack([run.bodies.position.poses, run.bodies.position.rates])


@pytest.mark.parametrize("engine", TAKEN)
def test_a_pulse_acts_at_its_time_and_not_at_that_time_of_the_run(engine: str) -> None:
    without = slider(engine)
    # Over before the run begins; had the clock begun with the run it would act in all of it.
    over = slider(engine, TimePulse(3e3, 0.0, 0.9 * BEGIN))
    assert np.array_equal(over, without)
    acting = slider(engine, TimePulse(3e3, BEGIN, 2.0 * BEGIN))
    assert not np.array_equal(acting, without)
