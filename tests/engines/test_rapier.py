"""Rapier, where it is installed: loops in maximal coordinates, whole turns of a quaternion, and what it refuses."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from conrod.engines import engine_named, installed_extras
from conrod.engines.engine import SINGLE_EPSILON
from conrod.engines.space import SpatialRun
from conrod.scenes import SCENES
from conrod.scenes.space.tree import exact_points
from conrod.studies.space.plan import motion_scales
from conrod.testing import EngineConformance, machine_in_space

pytestmark = pytest.mark.skipif("rapier" not in installed_extras(), reason="Rapier is not installed")


class TestConformance(EngineConformance):
    scenes = ()
    rounding = 20.0 * SINGLE_EPSILON
    spatial_steps = 2000  # a free spin beside a loop is of order 1

    @pytest.fixture(autouse=True)
    def installed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Rapier, loaded where it is tested alone."""
        monkeypatch.setattr(type(self), "engine", engine_named("rapier"), raising=False)


def run_rapier(name: str, preset: str, steps: int, turns: float = 1.0, every: int = 1) -> SpatialRun:
    _, start = machine_in_space(name)
    engine: Any = engine_named("rapier")
    return engine.run_in_space(replace(start, step=start.period / steps), preset, round(steps * turns), every)  # type: ignore[no-any-return]


def errors(name: str, run: SpatialRun) -> list[float]:
    """Largest errors over the largest range, speed and acceleration of the machine's points."""
    machine, _ = machine_in_space(name)
    exact, scales = exact_points(machine, run.times), motion_scales(machine)
    return [
        max(float(np.linalg.norm(run.points[p][k] - exact[p][k], axis=1).max()) for p in exact) / size
        for k, size in enumerate(scales.values())
    ]


@pytest.mark.parametrize(("name", "most"), [("bennett", 3e-5), ("cardan", 2e-6), ("tilted-slider-crank", 1e-5)])
def test_rapier_closes_loops_by_more_iterations(name: str, most: float) -> None:
    tuned, stock = (errors(name, run_rapier(name, preset, 200)) for preset in ("tuned", "stock"))
    assert tuned[0] < most
    assert stock[0] > 10.0 * tuned[0]


def test_rapier_turns_on_over_whole_turns() -> None:
    # A quaternion that changes its sign after half a turn, or a turn, would be taken as a turn back: velocities of 4 x.
    run = run_rapier("cardan", "stock", 100, 3.0)
    assert run.failure == ""
    assert errors("cardan", run)[1] < 0.02


def test_rapier_positions_are_of_order_two() -> None:
    coarse, fine = (errors("bennett", run_rapier("bennett", "stock", n))[0] for n in (200, 400))
    assert coarse / fine == pytest.approx(4.0, rel=0.3)


def test_rapier_acceleration_begins_wrong_at_any_step() -> None:
    for steps in (200, 400):
        run, (machine, _) = run_rapier("cardan", "tuned", steps), machine_in_space("cardan")
        exact = exact_points(machine, run.times)
        off = np.max([np.linalg.norm(run.points[p][2] - exact[p][2], axis=1) for p in exact], axis=0)
        off /= motion_scales(machine)["acceleration"]
        assert off[0] == pytest.approx(0.054, rel=0.1)
        assert off[2:20].max() < 0.02


def test_rapier_run_ends_where_joints_come_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    from conrod.engines.rapier import space

    monkeypatch.setattr(space, "MAX_JOINT_GAP", 1e-9)
    run = run_rapier("bennett", "stock", 100)
    assert "the joint " in run.failure
    assert len(run.times) < 101


def test_every_second_sample_of_rapier_is_one_of_all() -> None:
    every, second = run_rapier("cardan", "stock", 60), run_rapier("cardan", "stock", 60, every=2)
    assert np.array_equal(every.times[::2], second.times)
    for name, moved in every.points.items():
        assert np.array_equal(moved[:, ::2], second.points[name])


@pytest.mark.parametrize(
    ("name", "said"), [("rssr", "not rod"), ("delta", "not platform"), ("stewart", "not cylinder_1")]
)
def test_rapier_refuses_several_joints_of_a_link(name: str, said: str) -> None:
    engine: Any = engine_named("rapier")
    assert said in engine.refusal_in_space(machine_in_space(name)[1], "stock")
    assert engine.refusal_in_space(machine_in_space("bennett")[1], "stock") is None


def test_rapier_refuses_planar_machines() -> None:
    engine = engine_named("rapier")
    saw = SCENES["saw-40rpm"]
    assert engine.refusal(saw, engine.presets["stock"](saw, 100)) == "rapier runs machines in space alone"
