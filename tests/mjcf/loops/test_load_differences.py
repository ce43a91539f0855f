"""Masses, damping and gravity of a model are compared with the machine's by name, and differences are said."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from conrod.exact.space import SpatialTree
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.reading import machine_tree, tree_of
from conrod.models.loops import study as study_module
from conrod.models.loops.load_differences import list_load_differences
from conrod.models.loops.report import exactness_facts, finding
from conrod.scenes.space import MACHINES

MACHINE = "rssr"


def tree(edit: Callable[[mujoco.MjModel], None] = lambda _: None) -> SpatialTree:
    model = mujoco.MjModel.from_xml_string(MACHINES[MACHINE]().mjcf)
    edit(model)
    return tree_of(model, model.qpos0)


def heavier(model: mujoco.MjModel) -> None:
    model.body("rod").mass[:] *= 2.0


def off_centre(model: mujoco.MjModel) -> None:
    model.body("rod").ipos[0] += 0.01


def rounder(model: mujoco.MjModel) -> None:
    model.body("rod").inertia[:] *= 1.5


def damped(model: mujoco.MjModel) -> None:
    model.dof_damping[model.joint("output").dofadr[0]] = 0.1


def on_the_moon(model: mujoco.MjModel) -> None:
    model.opt.gravity[:] = 0.0, 0.0, -1.62


@pytest.mark.parametrize(("edit", "said"), [
    (heavier, "rod has "), (off_centre, "the centre of gravity of rod is 10 mm off"),
    (rounder, "rod has another inertia"), (damped, "the damping of output is 0.1 instead of 0 N m s/rad"),
    (on_the_moon, "gravity is (0 0 -1.62) instead of "),
])  # fmt: skip
def test_a_load_that_differs_is_named_alone(edit: Callable[[mujoco.MjModel], None], said: str) -> None:
    (words,) = list_load_differences(tree(edit), machine_tree(MACHINE))
    assert words.startswith(said)


def test_loads_of_the_machine_itself_to_six_digits_do_not_differ() -> None:
    def rounded(model: mujoco.MjModel) -> None:
        for field in ("body_mass", "body_inertia", "body_ipos"):
            values = getattr(model, field)
            values[:] = np.vectorize(lambda x: float(f"{x:.6g}"))(values)

    assert not list(list_load_differences(tree(), machine_tree(MACHINE)))
    assert not list(list_load_differences(tree(rounded), machine_tree(MACHINE)))


def test_a_finding_names_loads_that_differ_of_the_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, cheap in {"COARSER": (2,), "FINER": (), "CHECKED_INSTANTS": 9}.items():
        monkeypatch.setattr(study_module, name, cheap)
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
    text, file = MACHINES[MACHINE]().mjcf, tmp_path / "damped.xml"
    assert text.count('name="output"') == 1
    file.write_text(text.replace('name="output"', 'name="output" damping="0.1"'), encoding="utf-8")
    found = study_module.study_loops(file, LoopRequest(dict(MACHINES[MACHINE]().drives), machine=MACHINE), "damped")
    assert found.is_machine
    said = "Loads are not judged, and differ: the damping of output is 0.1 instead of 0 N m s/rad."
    assert said in finding(found)
    assert not any(line.startswith("masses, damping") for line in exactness_facts(found))
    assert found.compared is not None
    same = replace(found, compared=replace(found.compared, loads=()))
    assert "Loads" not in finding(same)
    assert any(line.startswith("masses, damping and gravity are those of rssr") for line in exactness_facts(same))
