"""Exports of scenes, judged against the scenes themselves: each is its machine, or refused at a pose that is named."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conrod.comparison.trajectory import Outcome
from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.errors import InvalidInput
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.loading import load_model
from conrod.mjcf.reading import tree_of
from conrod.mjcf.request import ModelRequest, places_of
from conrod.models.check.frame import GivenFrame
from conrod.models.check.results import ModelStudy
from conrod.models.check.study import study_scene_model
from conrod.models.check.turning import prepare_turning
from conrod.scenes import SCENES, Scene, catalogue_names, dynamics_names, scene_named

# Change points at which another branch begins: no turn of theirs is followed.
CHANGES = ("parallelogram",)
# Passes from both ends; wheels that are not back after a turn; a chain that is singular beside its pass.
KINDS = (
    "double-rocker",
    "swinging-four-bar",
    "planetary-gear",
    "rolling-on-concave",
    "rack-and-wheel",
    "four-bar-chain-2",
)
REST = [name for name in (*SCENES, *catalogue_names(), *dynamics_names()) if name not in (*CHANGES, *KINDS)]


def judged(path: Path, scene: Scene, name: str, text: str | None = None) -> ModelStudy:
    path.write_text(standalone_mjcf(name, scene) if text is None else text, encoding="utf-8")
    return study_scene_model(path, (name, scene), question_of(scene), GivenFrame(), 1.0, {"position": 1e-4})


def question_of(scene: Scene, keyframe: str | None = None) -> ModelRequest:
    mechanism = scene.mechanism()
    places = places_of({point: f"site:{point}" for point in scene.lengths})
    return ModelRequest("crank", places, mechanism.mobility, len(mechanism.cam_contacts), keyframe)


def check(found: ModelStudy, scene: Scene) -> None:
    """It is the machine, in the document's frame, and all its runs come to their end; within 1e-4 without contact."""
    assert found.is_machine, found.identity
    assert found.identity.frame.unit == 1.0
    for run in (found.own_run, *found.runs.values()):
        assert run is not None
        assert run.outcome is Outcome.COMPLETED, (run.label, run.reason)
        if not scene.mechanism().cam_contacts:
            assert (run.worst("position") or 0.0) < 1e-4, run.label
    if not scene.mechanism().cam_contacts:
        assert found.passed


@pytest.mark.parametrize("name", [*KINDS, *(pytest.param(name, marks=pytest.mark.slow) for name in REST)])
def test_an_export_judged_against_its_own_scene_is_within(name: str, tmp_path: Path) -> None:
    check(judged(tmp_path / "m.xml", scene_named(name), name), scene_named(name))


@pytest.mark.parametrize(
    ("name", "speed"), [("double-rocker", -7.3), ("watt-straight-line", -2.0), ("geneva", -1.8849555921538759)]
)
def test_a_pass_at_another_speed_and_the_other_way_is_within(name: str, speed: float, tmp_path: Path) -> None:
    scene = scene_named(name).with_parameters(speed=speed)
    check(judged(tmp_path / "m.xml", scene, name), scene)


def test_pass_is_found_when_model_is_drawn_in_its_middle(tmp_path: Path) -> None:
    """Of Watt's linkage drawn 20 deg further, without its keyframe."""
    scene = scene_named("watt-straight-line")
    text = standalone_mjcf("watt-straight-line", scene)
    text = re.sub(r"<keyframe>.*</keyframe>", "", text, flags=re.DOTALL)
    (tmp_path / "m.xml").write_text(text, encoding="utf-8")
    model = load_model(tmp_path / "m.xml")
    tree = tree_of(model, model.qpos0)
    machine = DrivenTree(tree, {"crank": parse_drive_law("1rad/s", "rad", 0.0, "crank")})
    machine.track_branch(machine.close_loops(tree.start[:, None], 0.0)[0], 0.35)
    there = machine.motion(np.array([0.35]), order=1).coordinates[:, 0]
    moved = " ".join(f"{value:.17g}" for value in there)
    text = text.replace("</mujoco>", f'<keyframe><key name="middle" qpos="{moved}"/></keyframe></mujoco>')
    (tmp_path / "m.xml").write_text(text, encoding="utf-8")
    asked = question_of(scene, "middle")
    found = study_scene_model(tmp_path / "m.xml", ("watt", scene), asked, GivenFrame(), 1.0, {"position": 1e-4})
    assert found.is_machine
    assert all((run.worst("position") or 0.0) < 1e-4 for run in found.runs.values())


@pytest.mark.parametrize("machine", ["swinging-four-bar", pytest.param("watt-straight-line", marks=pytest.mark.slow)])
def test_a_wrong_link_of_a_machine_that_makes_one_pass_is_named(machine: str, tmp_path: Path) -> None:
    """Negative control: a coupler 1 % longer is not the machine."""
    scene = scene_named(machine)
    name = next(
        n for n, fact in scene.parameter_facts().items() if fact.unit == "m" and "coupler" in n and scene.parameters[n]
    )
    wrong = scene.with_parameters(**{name: 1.01 * scene.parameters[name]})
    found = judged(tmp_path / "m.xml", scene, machine, standalone_mjcf(machine, wrong))
    assert not found.is_machine
    assert found.passed is False


def test_model_is_refused_with_ends_when_it_cannot_make_the_pass(tmp_path: Path) -> None:
    scene = scene_named("double-rocker")
    begin, end = scene.parameters["driver.from"], scene.parameters["driver.to"]
    (tmp_path / "m.xml").write_text(standalone_mjcf("double-rocker", scene), encoding="utf-8")
    assert begin < 0.0 < end
    longer = replace(question_of(scene), span=(begin - 0.2, end + 0.2))
    with pytest.raises(
        InvalidInput, match=r"its crank goes from -5.\d+ deg to .* deg alone, .*: the pass of the machine"
    ):
        prepare_turning(tmp_path / "m.xml", longer)


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_point_on_the_way_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"with crank at 120 deg") as refused:
        judged(tmp_path / "m.xml", scene_named(name), name)
    assert "\n" not in str(refused.value)


def test_a_singular_pose_is_named(tmp_path: Path) -> None:
    """The chain of two four-bars lies flat at 90 deg from upright: 170 deg from where its pass begins."""
    (tmp_path / "m.xml").write_text(standalone_mjcf("chain", scene_named("four-bar-chain-2")), encoding="utf-8")
    model = load_model(tmp_path / "m.xml")
    tree = tree_of(model, model.qpos0)
    machine = DrivenTree(tree, {"crank": parse_drive_law("1rad/s", "rad", 0.0, "crank")})
    machine.track_branch(machine.close_loops(tree.start[:, None], 0.0)[0], 2.0 * np.pi)
    flat = np.radians(170.0)
    beside = machine.motion(flat + np.array([-0.01, 0.01]), order=1)
    assert np.all(np.isfinite(beside.coordinates))
    with pytest.raises(InvalidInput, match="it is singular with crank at 170 deg: a change point"):
        machine.motion(np.array([flat]))
