"""A batch of MJX: machines of other sizes in one call are each the machine alone."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from conrod.engines.registry import engine_named
from conrod.runs.trajectory import concatenate_pieces


@pytest.mark.skipif(find_spec("mujoco.mjx") is None, reason="the extra conrod[mjx] is not installed")
@pytest.mark.slow
def test_each_machine_of_a_batch_is_that_machine_alone() -> None:
    from benchmarks.batch import STEPS, Batch, judged, page, saws  # loads JAX, after which nothing may fork

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
