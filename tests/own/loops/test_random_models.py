"""Random models with loops are what they say: they compile, and are closed or open in the reference pose."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from random_models import GAPS, KINDS, RandomModel, random_loop_model, random_model

SEEDS = 110


def closures(model: mujoco.MjModel) -> tuple[float, int, int]:
    """The largest opening in the reference pose, rank and number of the closures' equations."""
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    jacobian = data.efc_J.reshape(-1, model.nv)[rows]
    return float(np.abs(data.efc_pos[rows]).max()), int(np.linalg.matrix_rank(jacobian, tol=1e-9)), len(rows)


@pytest.fixture(scope="module")
def models() -> list[tuple[RandomModel, mujoco.MjModel]]:
    made = [random_model(seed) for seed in range(SEEDS)]
    return [(random, mujoco.MjModel.from_xml_string(random.mjcf)) for random in made]


def test_every_joint_has_a_name_and_a_seed_makes_one_model(models) -> None:
    for random, model in models:
        names = [model.joint(joint).name for joint in range(model.njnt)]
        assert all(names)
        assert len({*names}) == model.njnt
        assert random_loop_model(random.seed) == random.mjcf


def test_models_are_closed_unless_they_are_meant_to_be_open(models) -> None:
    for random, model in models:
        opening, _, _ = closures(model)
        if random.kind in GAPS:
            assert random.gap / 2.0 < opening <= random.gap + 1e-12, random.seed
        else:
            assert opening < 1e-12, random.seed


def test_kinds_have_the_freedoms_that_they_are_for(models) -> None:
    mobilities, redundancies = {kind: [] for kind in KINDS}, {kind: [] for kind in KINDS}
    for random, model in models:
        _, rank, rows = closures(model)
        mobilities[random.kind].append(model.nv - rank)
        redundancies[random.kind].append(rows - rank)
    assert {*mobilities["locked"]} == {0}
    assert {*mobilities["planar"]} == {1}
    assert min(redundancies["planar"]) > 0
    assert min(redundancies["twice"]) >= 3
    assert {*mobilities["ring"]} == {1, 2, 3}
    assert {*redundancies["ring"]} == {0}
    assert min(mobilities["branching"]) >= 1
    assert min(mobilities["floating"]) >= 6
