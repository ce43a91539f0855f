"""MJX, where it is installed: closures without the term that MuJoCo has for their curvature, in two precisions."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, EVERY_SCENE, SAW

from conrod import Outcome
from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Trajectory, concatenate_pieces
from conrod.engines import engine_named
from conrod.engines.engine import SINGLE_EPSILON, with_fields
from conrod.engines.mjx import MJX_PRESETS
from conrod.scenes import scene_named
from conrod.testing import EngineConformance

FAST_SAW = EVERY_SCENE["saw-500rpm"]
INSTALLED = find_spec("mujoco.mjx") is not None and find_spec("jax") is not None
pytestmark = pytest.mark.skipif(not INSTALLED, reason="the extra conrod[mjx] is not installed")


@cache
def run_mjx(name: str, preset: str, steps: int, **fields: Any) -> Trajectory:
    """A turn of the fast saw."""
    engine = engine_named(name)
    settings = replace(engine.presets[preset](FAST_SAW, steps), **fields)
    return concatenate_pieces(list(engine.run(FAST_SAW, settings, 1.0))).trajectory


def error(preset: str, steps: int, quantity: str = "position", **fields: Any) -> float:
    return compare(run_mjx("mjx", preset, steps, **fields), FAST_SAW).worst(quantity)


@pytest.mark.slow
class TestConformance(EngineConformance):
    scenes = ("saw-40rpm",)
    rounding = 20.0 * SINGLE_EPSILON
    first_order = ("tuned",)  # Euler's velocity is half a step old

    @pytest.fixture(autouse=True)
    def installed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """MJX, loaded where it is tested alone."""
        monkeypatch.setattr(type(self), "engine", engine_named("mjx"), raising=False)


# -- its constraints ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_mujocos_defaults_open_a_loop_in_mjx_but_not_in_mujoco() -> None:
    assert run_mjx("mujoco", "stock", 250).outcome is Outcome.COMPLETED
    opened = run_mjx("mjx", "stock", 250)
    assert opened.outcome is Outcome.OPENED
    assert "slider-pin: gap up to 0.08" in opened.reason


@pytest.mark.slow
def test_short_time_constants_give_order_two_after_one_step() -> None:
    assert error("tuned", 250) / error("tuned", 500) == pytest.approx(4.0, rel=0.02)
    assert error("tuned", 250, "velocity") / error("tuned", 500, "velocity") == pytest.approx(2.0, rel=0.05)
    assert error("tuned", 250, "acceleration") == pytest.approx(error("tuned", 500, "acceleration"), rel=0.01)
    # At the same settings MuJoCo has the acceleration of the first step.
    same = {"solref": MJX_PRESETS["tuned"](FAST_SAW, 500).solref, "integrator": "Euler"}
    assert compare(run_mjx("mujoco", "tuned", 500, **same), FAST_SAW).worst("acceleration") < 0.05
    assert error("tuned", 500, "acceleration") > 0.25


def largest_errors(scene: Any, steps: int, machine: Any = None) -> list[tuple[float, float]]:
    """Errors of position, velocity and acceleration against a scene, of it or another machine, with their bounds."""
    engine, machine = engine_named("mjx"), machine or scene
    settings = MJX_PRESETS["tuned"](machine, steps)
    law = engine.expected_error(scene, settings)
    found = compare(concatenate_pieces(list(engine.run(machine, settings, 1.0))).trajectory, scene)
    return [(found.worst(name), getattr(law, name)) for name in ("position", "velocity", "acceleration")]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["saw-500rpm", "crank-shaper", "planetary-gear"])
def test_error_law_bounds_mjx_runs_closely(name: str) -> None:
    scene = EVERY_SCENE.get(name) or scene_named(name)
    for steps in (100, 1000):
        assert all(error <= bound for error, bound in largest_errors(scene, steps))
    (position, bound), _, (acceleration, most) = largest_errors(scene, 1000)
    assert position > 0.9 * bound
    assert acceleration > 0.3 * most
    if name == "saw-500rpm":
        assert largest_errors(scene, 1000, replace(scene, rod=scene.rod * 1.001))[0][0] > 2.0 * bound


# -- what it cannot do -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "fields", "reason"),
    [
        (CAM, {}, "no cams, which have thousands"),
        (scene_named("press-cutting"), {}, "mjx lacks what the model has: .*mjBIAS_USER"),
        (SAW, {"integrator": "implicit"}, "mjx lacks what the model has: .*IMPLICIT"),
        (SAW, {"solver": "PGS"}, "mjx lacks what the model has: .*PGS"),
    ],
    ids=["cam", "loads", "integrator", "solver"],
)
def test_mjx_refuses_what_it_lacks_with_its_own_reason(scene: Any, fields: dict[str, Any], reason: str) -> None:
    engine, settings = engine_named("mjx"), MJX_PRESETS["tuned"](scene, 1000)
    assert engine.refusal(SAW, MJX_PRESETS["tuned"](SAW, 1000)) is None
    assert re.search(reason, str(engine.refusal(scene, with_fields(settings, **fields))))


# -- a batch: machines of other sizes in one call ----------------------------------------------------------------------


@pytest.mark.slow
def test_each_machine_of_a_batch_runs_as_if_alone() -> None:
    from docs.studies.batch import STEPS, Batch, batch_findings, judged, saws  # loads JAX: nothing may fork then
    from docs.studies.batch_report import verdict_text

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
    assert "3 of 3 runs are within the bound" in verdict_text(batch_findings(machines, [right]))
    assert "0 of 3 runs are within the bound" in verdict_text(batch_findings(machines, [wrong]))
