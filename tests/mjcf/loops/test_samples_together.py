"""What is computed of all samples of a run is what MuJoCo and numpy compute of each; longer steps show orders."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod.comparison.trajectory import Outcome
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.mjcf import driving
from conrod.mjcf.loading import POINT_OBJECTS, FoundPoint
from conrod.mjcf.loop_results import LoopRun
from conrod.mjcf.point_tracks import point_motions, point_noter
from conrod.models.loops import study

MIXED = """
<mujoco><option gravity="1 -2 -9.81"/><worldbody>
  <body name="base" pos="1 2 3"><geom size=".1" pos=".3 0 0"/><site name="still"/>
    <body name="arm" pos="0 .2 0"><joint axis="1 2 0"/><geom name="ball" size=".1" pos=".5 .1 0"/>
      <body name="hand" pos=".4 0 .3"><joint type="ball"/><geom size=".1" pos="0 .2 .1"/>
        <site name="tip" pos=".1 .2 .3"/>
  </body></body></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("off", [False, True])
def test_points_noted_move_as_mujoco_says_to_the_last_bit(off: bool) -> None:
    model = mujoco.MjModel.from_xml_string(MIXED)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_GRAVITY if off else 0
    places = [("site", "tip"), ("body", "arm"), ("geom", "ball"), ("site", "still"), ("body", "hand")]
    points = []
    for kind, name in places:
        index = mujoco.mj_name2id(model, POINT_OBJECTS[kind], name)
        body = {"site": model.site_bodyid, "geom": model.geom_bodyid, "body": range(model.nbody)}[kind][index]
        points.append(FoundPoint(name, kind, index, int(body)))
    data, note = mujoco.MjData(model), point_noter(model, points)
    noted, told = [], []
    data.qvel[:] = 3.0, 1.0, -2.0, 0.7
    for _ in range(20):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        noted.append(note(data))
        told.append([np.array(point.motion(model, data)) for point in points])
    assert np.array_equal(point_motions(model, np.array(noted)), np.array(told))
    # A point that is taken for another body's moves otherwise.
    wrong = point_noter(model, [FoundPoint("tip", "site", points[0].index, 2)])(data)
    assert not np.allclose(point_motions(model, wrong[None])[0, 0], told[-1][0])


def test_square_closures_are_solved_as_by_least_squares() -> None:
    random = np.random.default_rng(5)
    matrices, right = random.normal(size=(7, 4, 4)) + 3.0 * np.eye(4), random.normal(size=(7, 4))
    expected = [np.linalg.lstsq(a, b, rcond=RANK_TOLERANCE)[0] for a, b in zip(matrices, right, strict=True)]
    assert np.allclose(driving._shortest_solutions(matrices, right), expected, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("least", [0.0, 1e-7])
def test_redundant_closures_have_the_shortest_forces(least: float) -> None:
    matrices = np.broadcast_to(np.diag([1.0, 2.0, least]), (3, 3, 3))
    found = driving._shortest_solutions(matrices, np.ones((3, 3)))
    assert np.allclose(found, [1.0, 0.5, 0.0], rtol=0.0, atol=1e-15)
    assert not np.allclose(np.linalg.pinv(matrices[0], rcond=1e-9) @ np.ones(3), found[0]) or least == 0.0


def bench_with(errors: dict[float, float | None]) -> tuple[Any, list[float]]:
    """A bench whose runs have given position errors by their number of steps, and the numbers that were run."""
    made = list[float]()

    def run(label: str, finer: float, *_: Any) -> LoopRun:
        if label == study.OWN_SETTINGS:
            made.append(finer)
        error = errors[finer]
        found = {} if error is None else {"position": error}
        return LoopRun(label, 0.01 / finer, Outcome.COMPLETED, "", found)

    bench = SimpleNamespace(
        _run=run, _costs=lambda: dict.fromkeys(study.LABELS, 1.0), seconds=1.0,
        model=SimpleNamespace(opt=SimpleNamespace(timestep=0.01)),
    )  # fmt: skip
    return bench, made


@pytest.mark.parametrize(
    ("errors", "tried", "order"),
    [
        ({0.25: 16e-3, 0.5: 4e-3, 1.0: 1e-3}, 3, 2.0),  # shown by longer steps
        ({0.25: 1e-3, 0.5: 1e-3, 1.0: 1e-3}, 3, None),  # does not fall at all
        ({0.25: 1.0, 0.5: 4e-3, 1.0: 1e-3, 2.0: 25e-5, 4.0: 62.5e-6}, 5, 2.0),  # seen at shorter ones alone
        ({0.25: None, 0.5: None, 1.0: 1e-3, 2.0: 25e-5, 4.0: 62.5e-6}, 5, 2.0),  # longer ones do not hold
    ],
)
def test_shorter_steps_are_run_where_longer_show_no_order(
    errors: dict[float, float | None], tried: int, order: float | None
) -> None:
    bench, made = bench_with(errors)
    runs, others, _ = study._LoopBench._runs(bench, 0.1)
    assert (len(made), len(others)) == (tried, 3 * (tried - 1))
    assert runs[0].order == (None if order is None else pytest.approx(order))
