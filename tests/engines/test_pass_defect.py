"""What MuJoCo's closures and RK4 do to an error is predicted before the run."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.mujoco.law import LEFT_OUT, Course, local_errors
from conrod.engines.mujoco.model import build
from conrod.engines.running import whole_run
from conrod.runs.comparison import compare
from conrod.scenes import SCENES


@pytest.mark.parametrize("start_angle", [0.0, 2.0])
@pytest.mark.parametrize("preset", ["tuned", "hardened"])
@pytest.mark.parametrize("name", ["saw-500rpm", "shear-press"])
def test_the_law_is_the_error_from_whatever_start(name: str, preset: str, start_angle: float) -> None:
    scene, mujoco = SCENES[name], engine_named("mujoco")
    settings = mujoco.presets[preset](scene, 250)
    law = mujoco.expected_error(scene, settings, start_angle)
    found = compare(whole_run(mujoco, scene, settings, 1.0, start_angle), scene)
    for quantity in ("position", "velocity", "acceleration"):
        assert 1.0 < getattr(law, quantity) / found.worst(quantity) < 1.03 + LEFT_OUT
    # Negative control: the law of another start is another one, where the closures give way.
    if (name, preset) == ("saw-500rpm", "tuned"):
        other = mujoco.expected_error(scene, settings, start_angle + 1.5)
        assert other.acceleration / law.acceleration != pytest.approx(1.0, rel=0.1)


def test_local_errors_are_those_of_order_four_and_a_wrong_length_is_not_in_them() -> None:
    scene: Any = SCENES["saw-500rpm"]
    settings = MuJoCoSettings.hardened(scene, 250)
    tree, constant = build(scene, settings).tree, abs(scene.speed) * settings.solref[0]
    step = 2.0 * math.pi / 250
    sizes = [
        np.abs(local_errors(tree, Course.of(scene, 0.0, h, constant), constant, h)[0]).max() for h in (step, step / 2.0)
    ]
    assert sizes[0] / sizes[1] == pytest.approx(16.0, rel=0.05)
    # Negative control: an engine whose rod is a hundred thousandth too long is out of the law.
    wrong = whole_run(engine_named("mujoco"), replace(scene, rod=1.00001 * scene.rod), settings, 1.0)
    law = engine_named("mujoco").expected_error(scene, settings)
    assert compare(wrong, scene).worst("position") > 50.0 * law.position
