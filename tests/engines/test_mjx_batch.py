"""A batch of MJX: machines of other sizes in one call are each the machine alone."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from catalogue import EVERY_SCENE

from benchmarks.batch import DRAWING, STEPS, TOLERANCES, as_mjx, judged, page, saws, strokes
from conrod.engines.mjx.settings import PRESETS
from conrod.engines.registry import engine_named
from conrod.errors import InvalidInput
from conrod.runs.trajectory import concatenate_pieces

needs_mjx = pytest.mark.skipif(find_spec("mujoco.mjx") is None, reason="the extra conrod[mjx] is not installed")


def test_drawn_saws_stay_within_the_drawing_and_their_strokes_differ() -> None:
    machines: list[Any] = saws(50)
    for name, tolerance in TOLERANCES.items():
        off = np.array([getattr(one, name) - getattr(DRAWING, name) for one in machines])
        assert 0.5 * tolerance < np.abs(off).max() <= tolerance
    assert 0.2e-3 < np.ptp(strokes(machines)) < 2e-3


def test_mujoco_is_run_at_the_settings_of_mjx() -> None:
    settings = as_mjx(DRAWING, STEPS)
    assert (settings.engine, settings.integrator, settings.iterations) == ("mujoco", "Euler", 1)
    assert settings.solref == PRESETS["tuned"](DRAWING, STEPS).solref


@needs_mjx
@pytest.mark.slow
def test_each_machine_of_a_batch_is_that_machine_alone() -> None:
    from conrod.engines.mjx.batch import Batch

    engine, machines = engine_named("mjx"), saws(3)
    settings = [engine.presets["tuned"](one, STEPS) for one in machines]
    runs = list(Batch(machines, settings).trajectories(STEPS))
    for run, machine, by in zip(runs, machines, settings, strict=True):
        alone = concatenate_pieces(list(engine.run(machine, by, 1.0))).trajectory
        assert (run.outcome, run.settings) == (alone.outcome, by)
        for quantity in ("position", "velocity", "acceleration"):
            together, single = (getattr(one.points["C"], quantity).values for one in (run, alone))
            np.testing.assert_allclose(together, single, atol=1e-9 * np.abs(single).max())
    assert np.abs(runs[0].points["C"].position.values - runs[1].points["C"].position.values).max() > 1e-5
    # One that was made otherwise than it is compared with is out of the law's bound.
    right = judged("MJX", engine, machines, settings, runs, (9.0, 0.1))
    assert right.shares.max() <= 1.0
    wrong = judged("MJX", engine, [*machines[1:], machines[0]], settings, runs, (9.0, 0.1))
    assert wrong.shares.min() > 1.0
    assert "**3 of 3 runs are within the bound" in page(machines, [right])
    assert "**0 of 3 runs are within the bound" in page(machines, [wrong])


@needs_mjx
def test_machines_of_different_layouts_are_no_batch() -> None:
    from conrod.engines.mjx.batch import Batch

    machines = [DRAWING, EVERY_SCENE["saw-40rpm"], EVERY_SCENE["shear-press"]]
    settings = [PRESETS[name](one, STEPS) for one, name in zip(machines, ("tuned", "stock", "tuned"), strict=True)]
    for chosen in (slice(0, 2), slice(0, 3, 2)):
        with pytest.raises(InvalidInput, match="a batch is of machines that differ in sizes alone, in one precision"):
            Batch(machines[chosen], settings[chosen])
