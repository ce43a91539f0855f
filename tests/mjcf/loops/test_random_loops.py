"""Random models with loops: each is moved exactly or refused in a line that says why, and MuJoCo agrees."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
import pytest
from random_models import RandomModel, random_model

from conrod.errors import InvalidInput
from conrod.exact.space.closing import jacobian
from conrod.exact.space.laws import law_of
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.exact.space.poses import poses
from conrod.exact.space.tree import SpatialTree
from conrod.mjcf.loops.kinematic import kinematic_mode
from conrod.mjcf.loops.reading import tree_of
from conrod.mjcf.loops.results import Question
from conrod.mjcf.loops.study import _Bench

FAST = (0, 5, 6, 8, 9, 21)
SEEDS = [pytest.param(seed, marks=() if seed in FAST else pytest.mark.slow) for seed in range(110)]
TIMES = np.linspace(0.0, 1.0, 41)
STROKES = {"rad": "sine:6deg,1Hz", "m": "sine:8mm,1Hz"}
# Of models whose loops no pose closes, whose freedoms turn about balls, or that reach no further.
REASONS = ("do not close", "no law drives it", "dead centre", "too many")


def drives_for(tree: SpatialTree) -> dict[str, str]:
    """Hinges and slides that take all freedoms which they can, each where most is left."""
    held = tuple(joint.name for joint in tree.joints if joint not in tree.looped)
    drivable = [joint for joint in tree.looped if joint.kind in ("hinge", "slide")]
    start, chosen = DrivenTree(tree, {}, held).closed(tree.start[:, None], 0.0)[0], dict[str, str]()
    while True:
        laws = {name: law_of("hold", "rad", 0.0, name) for name in chosen}
        machine = DrivenTree(tree, laws, held)
        matrix = jacobian(poses(tree, start), 1)[0][:, machine.free] * machine.weights
        values, directions = np.linalg.svd(matrix)[1:]
        loose = directions[int(np.sum(values > 1e-5 * values.max(initial=1e-300))) :]
        shares = {j: float(np.abs(loose[:, machine.free == j.rate]).max(initial=0.0))
                  for j in drivable if j.name not in chosen}  # fmt: skip
        if not shares or max(shares.values()) < 1e-3:
            return chosen
        best = max(shares, key=lambda joint: shares[joint])
        chosen[best.name] = STROKES[best.unit]


def moved(random: RandomModel, model: mujoco.MjModel) -> tuple[_Bench, SpatialMotion] | str:
    """The machine and its motion, or why it is refused."""
    try:
        drives = drives_for(tree_of(model, model.qpos0)) or {"hinge_1": STROKES["rad"]}
        bench = _Bench.of(model, Question(drives))
        return bench, bench.machine.motion(TIMES)
    except InvalidInput as error:
        return str(error)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_random_model_is_moved_as_mujocos_closures_ask_or_refused_with_the_reason(seed: int) -> None:
    random = random_model(seed)
    model = mujoco.MjModel.from_xml_string(random.mjcf)
    found = moved(random, model)
    if isinstance(found, str):
        assert any(reason in found for reason in REASONS) or "unknown joint 'hinge_1'" in found
        assert "\n" not in found
        assert random.kind != "planar"
        return
    assert random.kind not in ("apart", "locked")
    bench, motion = found
    ways = [np.ptp(motion.points[point.name].position, axis=0).max() for point in bench.points]
    if max(ways) > 1e-6:  # else the study refuses it: none of its sites moves
        off = kinematic_mode(model, bench.machine, bench.points, motion)[0]
        assert max(off.values()) < 1e-9, off
    assert opening_rate(model, motion) < 1e-12 * max(bench.machine.tree.extent, 1.0)


def opening_rate(model: mujoco.MjModel, motion: SpatialMotion) -> float:
    """How fast MuJoCo has any closure open [m/s or rad/s]."""
    data, fastest = mujoco.MjData(model), 0.0
    for k in range(len(motion.times)):
        data.qpos[:], data.qvel[:] = motion.coordinates[:, k], motion.rates[0, :, k]
        mujoco.mj_forward(model, data)
        closures = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        fastest = max(fastest, float(np.abs(data.efc_vel[closures]).max()))
    return fastest


def test_the_kinds_that_cannot_move_say_so() -> None:
    reasons: Mapping[int, str] = {7: "too many", 9: "do not close", 18: "too many"}
    for seed, words in reasons.items():
        random = random_model(seed)
        model = mujoco.MjModel.from_xml_string(random.mjcf)
        found = moved(random, model)
        assert isinstance(found, str)
        assert words in found, (random.kind, found)
