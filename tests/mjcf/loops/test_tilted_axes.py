"""A machine that an axis or an anchor keeps from moving: which one it is, or that several would explain it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import mujoco
import numpy as np
import pytest
from four_bars import four_bar
from own_model_edits import TEXTS, question, replace_once

from conrod.errors import InvalidInput
from conrod.exact.space.immobility import JointCorrection, describe_corrections, explain_immobility
from conrod.exact.space.mobility import TooManyDrivesError, check_drives
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.differences import NUMBER_TOLERANCE
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.reading import laws_of, tree_of
from conrod.models.check.frame import GivenFrame
from conrod.models.check.study import study_scene_model
from conrod.models.loops import tracking
from conrod.models.loops.study import _LoopBench, study_loops
from conrod.scenes import SCENES
from conrod.scenes.space import MACHINES

TILT = 0.05  # [deg]


def tilted(text: str, joint: str, seed: int = 0, tilt: float = TILT) -> str:
    """A model with the axis of a joint turned about a random direction across it."""
    root = ET.fromstring(text)
    one = next(e for e in root.iter("joint") if e.get("name") == joint and e.get("type") != "ball")
    axis = np.array([float(value) for value in one.get("axis", "0 0 1").split()])
    axis /= np.linalg.norm(axis)
    across = np.cross(axis, np.random.default_rng(seed).normal(size=3))
    across *= np.tan(np.radians(tilt)) / np.linalg.norm(across)
    one.set("axis", " ".join(f"{value:.12g}" for value in axis + across))
    return ET.tostring(root, encoding="unicode")


def found(text: str, drives: dict[str, str]) -> list[JointCorrection]:
    """What would let the drives move a model that they do not; none where they do."""
    tree = tree_of(model := mujoco.MjModel.from_xml_string(text), model.qpos0)
    laws, held = laws_of(model, tree, LoopRequest(drives))
    machine = DrivenTree(tree, laws, held)
    start = machine.assemble_start()
    try:
        check_drives(machine, start)
    except TooManyDrivesError:
        return explain_immobility(tree, laws, held, start)
    return []


@pytest.mark.parametrize("joint", ["crank", "coupler", "rocker"])
@pytest.mark.parametrize("tilt", [0.05, 3.0])
def test_axis_is_named_when_it_locks_a_planar_four_bar(joint: str, tilt: float) -> None:
    (one,) = found(tilted(four_bar(), joint, tilt=tilt), {"crank": "60rpm"})
    assert (one.joint, one.kind) == (joint, "axis")
    assert np.degrees(one.size) == pytest.approx(tilt, rel=1e-3)
    assert not found(four_bar(), {"crank": "60rpm"})  # negative control


@pytest.mark.parametrize(("machine", "joint", "seed"), [
    ("tilted-slider-crank", "input", 0), ("tilted-slider-crank", "rod", 1), ("tilted-slider-crank", "wrist", 2),
    ("bennett", "input", 0), ("bennett", "coupler", 1), ("bennett", "output", 2),
    ("sarrus", "knee", 3),
])  # fmt: skip
def test_axis_is_named_when_it_locks_a_machine_in_space(machine: str, joint: str, seed: int) -> None:
    made = MACHINES[machine]()
    text = tilted(made.mjcf, joint, seed)
    if seen := found(text, dict(made.drives)):
        assert [one.words for one in seen if one.joint == joint and one.kind == "axis"] == [
            f"the axis of {joint} is 0.05 deg off"
        ]
    else:  # it moves, as far as its closures contradict each other
        assert (
            "the axis of"
            in _LoopBench.from_request(
                mujoco.MjModel.from_xml_string(text), LoopRequest(dict(made.drives))
            )._closure_words()
        )
    assert not found(made.mjcf, dict(made.drives))


def test_spherical_four_bar_has_two_explanations_both_named() -> None:
    """Its coupler's axis misses the centre: by a tilt, or by an anchor that is aside."""
    made = MACHINES["spherical-four-bar"]()
    text = tilted(made.mjcf, "coupler")
    seen = found(text, dict(made.drives))
    assert [(one.joint, one.kind) for one in seen] == [("coupler", "axis"), ("coupler", "anchor")]
    # 0.2 m from the centre.
    assert seen[1].size == pytest.approx(0.2 * np.radians(TILT), rel=0.01)
    with pytest.raises(
        InvalidInput, match=r"it cannot move; either the axis of coupler is 0.05 deg off or coupler is anc"
    ):
        _LoopBench.from_request(mujoco.MjModel.from_xml_string(text), LoopRequest(dict(made.drives)))


def test_a_machine_that_no_axis_or_anchor_explains_is_said_so() -> None:
    made = MACHINES["rssr"]()
    welded = made.mjcf.replace("<connect", "<weld")
    with pytest.raises(InvalidInput, match=r"it cannot move; no single axis or anchor explains it$"):
        _LoopBench.from_request(mujoco.MjModel.from_xml_string(welded), LoopRequest(dict(made.drives)))


@pytest.mark.parametrize("spare", [
    '<joint name="spare" joint1="rocker"/>', '<joint name="spare" joint1="rocker" joint2="crank"/>',
    '<connect name="spare" body1="rocker" body2="frame" anchor="0.1 0 0"/>',
])  # fmt: skip
def test_a_closure_that_is_one_too_many_is_named(spare: str) -> None:
    text = four_bar().replace("</equality>", f"{spare}</equality>")
    with pytest.raises(InvalidInput, match=r"it cannot move; without spare it moves$"):
        _LoopBench.from_request(mujoco.MjModel.from_xml_string(text), LoopRequest({"crank": "60rpm"}))


SAW_CLOSURE = "</equality>"
BRAKE = '<joint name="brake" joint1="slide" polycoef="0 0 0 0 0"/>'
BENT = '<joint name="bent" joint1="slide" joint2="crank" polycoef="0 -0.03 -0.02 0 0"/>'
AGAIN = '<connect name="again" site1="slider-pin.rod" site2="slider-pin.slider"/>'
STUCK_PIN = ('<joint name="crank-pin" type="hinge" axis="0 0 1" />', "")


def refused(text: str, folder: Path) -> str:
    """What is said of a saw that cannot be turned as the scene is."""
    text = replace_once(text, re.findall(r"<key name=.*/>", text)[0], "")
    path = folder / "saw.xml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput) as refusal:
        study_scene_model(path, ("saw-40rpm", SCENES["saw-40rpm"]), question("saw"), GivenFrame(), 1.0, None)
    return str(refusal.value)


@pytest.mark.parametrize(("spare", "name"), [(BRAKE, "brake"), (BENT, "bent"), (BRAKE + AGAIN, "brake")])
def test_closure_is_named_when_it_stops_a_scenes_model(spare: str, name: str, tmp_path: Path) -> None:
    said = refused(replace_once(TEXTS["saw"], SAW_CLOSURE, f"{spare}{SAW_CLOSURE}"), tmp_path)
    assert f"it cannot move; without {name} it moves" in said


@pytest.mark.parametrize("spare", ["", AGAIN])
def test_closure_is_not_named_when_a_stuck_pin_is_the_cause(spare: str, tmp_path: Path) -> None:
    said = refused(replace_once(replace_once(TEXTS["saw"], SAW_CLOSURE, f"{spare}{SAW_CLOSURE}"), *STUCK_PIN), tmp_path)
    assert "it cannot move" in said
    assert "without" not in said


def test_what_is_known_to_differ_is_laid_to_no_axis(tmp_path: Path) -> None:
    """An axis 4 deg off would let it move; it is a slide in the place of a hinge."""
    made, path = MACHINES["rssr"](), tmp_path / "model.xml"
    path.write_text(made.mjcf.replace('name="rod_pitch" type="hinge"', 'name="rod_pitch" type="slide"'))
    with pytest.raises(
        InvalidInput, match=r"it cannot move; against rssr: joint rod_pitch is a slide, the machine has"
    ):
        study_loops(path, LoopRequest(dict(made.drives), machine="rssr"), "model")


def test_drives_that_are_too_many_are_laid_to_no_axis() -> None:
    with pytest.raises(InvalidInput, match=r"give 1 of crank, rocker$"):
        _LoopBench.from_request(
            mujoco.MjModel.from_xml_string(four_bar()), LoopRequest({"crank": "60rpm", "rocker": "sine:5deg,1Hz"})
        )


TILTED = JointCorrection("rocker", "axis", np.radians(0.05))
AXIS_WORDS = "; the axis of rocker is 0.05 deg off, which alone explains it"
UNKNOWN_WORDS = "; no single axis or anchor explains it"


@pytest.mark.parametrize(("joints", "stuck", "spare", "found", "words"), [
    (14, True, "", [TILTED], AXIS_WORDS),
    (14, False, "", [TILTED], AXIS_WORDS),
    (14, True, "", [], UNKNOWN_WORDS),
    (14, False, "", [], ""),  # some of the drives can stay: they are too many
    (15, True, "", [TILTED], ""),  # more than it is tried for
    (15, False, "", [TILTED], ""),
    (14, True, "; without brake it moves", [TILTED], "; without brake it moves"),
])  # fmt: skip
def test_blocked_drives_are_laid_to_what_was_looked_for(
    joints: int, stuck: bool, spare: str, found: list[JointCorrection], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any) -> None:
        error = TooManyDrivesError("they are too many")
        error.stuck = stuck
        raise error

    monkeypatch.setattr(tracking, "check_drives", refuse)
    monkeypatch.setattr(tracking, "removable_words", lambda *_: spare)
    monkeypatch.setattr(tracking, "explain_immobility", lambda *_: found)
    machine: Any = SimpleNamespace(tree=SimpleNamespace(loop_joints=("",) * joints), laws={}, held=())
    with pytest.raises(InvalidInput) as refused:
        tracking._check_drives(machine, np.zeros((1, 1)), explained=False)
    assert str(refused.value) == f"they are too many{words}"


@pytest.mark.parametrize("extent", [0.01, 100.0])
@pytest.mark.parametrize(("share", "contradict"), [(0.9, False), (1.1, True)])
def test_closures_contradict_beyond_a_share_of_the_extent(
    extent: float, share: float, contradict: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conrod.models.loops.study.explain_immobility", lambda *_: [])
    machine: Any = SimpleNamespace(
        misfit=share * NUMBER_TOLERANCE * extent, tree=SimpleNamespace(extent=extent, loop_joints=()), laws={},
        held=(), knots=[SimpleNamespace(coordinates=None)],
    )  # fmt: skip
    model, unused = mujoco.MjModel.from_xml_string(four_bar()), cast(Any, None)
    bench = _LoopBench(model, LoopRequest({"crank": "60rpm"}), machine, unused, 1.0, unused, ())
    assert ("its closures contradict each other: " in bench._closure_words()) is contradict


def test_corrections_are_described_alone_together_or_as_unknown() -> None:
    some = [
        JointCorrection("a", "axis", np.radians(0.1)),
        JointCorrection("b", "anchor", 1e-4),
        JointCorrection("c", "axis", 0.01),
        JointCorrection("d", "axis", 0.02),
    ]
    assert describe_corrections(some[:1]) == "the axis of a is 0.1 deg off, which alone explains it"
    both = "either the axis of a is 0.1 deg off or b is anchored 0.1 mm off: each alone would explain it"
    assert describe_corrections(some[:2]) == both
    assert "or another of 1 more: each" in describe_corrections(some)
    assert describe_corrections([]) == "no single axis or anchor explains it"
