"""A mesh whose convex hull MuJoCo kept compiles to the same model, to the last bit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from catalogue import CAM, CAMS

from conrod import MuJoCoSettings
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.model import compiled
from conrod.engines.tree import tree_of
from conrod.mjcf.lint.bench import differing


def text_of(scene: Any, steps: int = 1000, **changes: Any) -> str:
    settings = replace(MuJoCoSettings.tuned(scene, steps), **changes)
    return mjcf(tree_of(scene), settings, "model")


def test_a_mesh_that_was_met_before_makes_the_same_model_to_the_last_bit() -> None:
    cam = {"cam_vertices": 400}
    for steps in (1000, 2000):  # the second time the hull is at hand, for another step
        text = text_of(CAM, steps, **cam)
        plain = mujoco.MjModel.from_xml_string(text)
        assert plain.nmeshgraph > 0
        assert differing(compiled(text), plain) == ""
    # Negative control: another step, and one vertex off by a bit.
    assert differing(compiled(text_of(CAM, 1000, **cam)), plain) == "pair_solref"  # which follows the step
    first = text.split('vertex="')[1].split()[0]
    off = text.replace(first, f"{np.nextafter(np.float32(first), np.float32(1.0)):.9g}", 1)
    assert differing(compiled(off), plain) != ""


def test_cams_of_one_name_are_not_taken_for_each_other() -> None:
    made = [compiled(text_of(CAMS[name], cam_vertices=400)) for name in ("cam-36-118", "cam-66-88", "cam-36-118")]
    assert made[0].mesh_vert.tobytes() == made[2].mesh_vert.tobytes() != made[1].mesh_vert.tobytes()
