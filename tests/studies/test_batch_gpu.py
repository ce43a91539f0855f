"""Fleets of saws and grippers: members, exact motions, errors, planted defects, and the page of a GPU's run."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod.comparison.compare import compare
from conrod.comparison.trajectory import concatenate_pieces
from conrod.engines import engine_named
from conrod.report.folder import restore_findings
from conrod.report.template import table_text
from conrod.report.writer import render_again

pytest.importorskip("mujoco.batch")  # since 4.0
fleets: Any = pytest.importorskip("docs.studies.fleets")
batch_gpu: Any = pytest.importorskip("docs.studies.batch_gpu")
page: Any = pytest.importorskip("docs.studies.batch_gpu_page")

LAYOUTS = tuple(fleets.LAYOUTS.values())
COMMITTED = Path(__file__).parents[2] / "reports" / "batch"


def named(layout: Any) -> str:
    return str(layout.name)


@pytest.mark.parametrize("layout", LAYOUTS, ids=named)
def test_fields_of_a_fleet_are_those_of_compiled_members(layout: Any) -> None:
    fleet = fleets.fleet(layout, 2)
    second = layout.compiled(fleet.sizes[1])
    for name, values in fleet.fields.items():
        np.testing.assert_allclose(values[1], getattr(second, name), atol=1e-12, err_msg=name)
    assert np.abs(fleet.fields["body_pos"][0] - fleet.fields["body_pos"][1]).max() > 1e-6


@pytest.mark.parametrize("layout", LAYOUTS, ids=named)
def test_exact_start_closes_the_loops_of_its_member_alone(layout: Any) -> None:
    fleet = fleets.fleet(layout, 2)
    opened = []
    for size in fleet.sizes:
        model = layout.compiled(size)
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = fleet.coordinates[1], fleet.rates[1]
        mujoco.mj_forward(model, data)
        opened.append(max(np.abs(data.efc_pos).max(), np.abs(data.efc_vel).max()))
    assert opened[1] < 1e-13
    assert opened[0] > 1e-6


def test_exact_gripper_closes_its_loops_on_the_way() -> None:
    layout = fleets.LAYOUTS["gripper"]
    sizes = layout.drawn(1)
    model = layout.compiled(sizes[0])
    data = mujoco.MjData(model)
    for coordinates in layout.exact(sizes)[0, ::50]:
        data.qpos[:] = coordinates
        mujoco.mj_forward(model, data)
        assert np.abs(data.efc_pos).max() < 1e-15


def stepped(fleet: Any) -> tuple[Any, Any]:
    job = batch_gpu.Job(batch_gpu.Variant("mujoco", threads=1), fleet)
    return job, batch_gpu.runner(job)[0]


def test_error_of_a_saw_is_what_conrod_says_of_its_run() -> None:
    fleet = fleets.fleet(fleets.LAYOUTS["saw"], 1).with_integrator("Euler")
    job, runner = stepped(fleet)
    row, _ = batch_gpu.measure(job, runner, 0.0)
    machine, engine = fleets.saw(fleet.sizes[0]), engine_named("mujoco")
    mjx = fleets.MJXSettings.tuned(machine, fleets.STEPS)
    settings = engine.presets["tuned"](machine, fleets.STEPS)
    settings = type(settings)(**{name: getattr(mjx, name) for name in vars(settings)})
    run = concatenate_pieces(list(engine.run(machine, settings, 1.0))).trajectory
    assert row["error"]["largest"] == pytest.approx(compare(run, machine).worst("position"), rel=1e-3)


@pytest.mark.parametrize("layout", LAYOUTS, ids=named)
def test_planted_lengths_of_another_member_are_seen(layout: Any) -> None:
    fleet = fleets.fleet(layout, 20)
    found = batch_gpu.control(*stepped(fleet))
    assert found["seen"] == [found["planted"]]
    assert found["others_seen"] >= 17
    unplanted = fleet.with_planted(3, 3)
    assert batch_gpu.control(*stepped(unplanted))["right"] == found["right"]


def test_gpu_wins_where_its_cost_falls_below_that_of_cores() -> None:
    cores = [{"count": count, "microseconds": 1.0} for count in (1, 10, 100)]
    gpu = [{"count": count, "microseconds": cost} for count, cost in ((1, 100.0), (10, 10.0), (100, 0.1))]
    assert page.wins_from(gpu, cores) == pytest.approx(10.0 * 10.0**0.5)
    assert page.wins_from([{**row, "microseconds": 2.0} for row in gpu], cores) is None
    assert page.wins_from([{**row, "microseconds": 0.5} for row in gpu], cores) == 1.0


def test_committed_page_of_a_gpu_follows_from_its_numbers(tmp_path: Path) -> None:
    (batch,) = [one for one in render_again(COMMITTED, tmp_path) if "gpu.md" in one.files]
    assert batch.files["gpu.md"] == (COMMITTED / "gpu.md").read_text()
    found = restore_findings(page.GpuBatches, json.loads((COMMITTED / "data/gpu.json").read_text()))
    swift = tuple({**row, "microseconds": 1e-9} if row["where"] == "16 cores" else row for row in found.rows)
    assert "at none" not in table_text(page.crossing_table(found))
    assert "at none" in table_text(page.crossing_table(replace(found, rows=swift)))
