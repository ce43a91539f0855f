"""`conrod check MODEL.xml` without any option: what is said of small models, each wrong in one way or sound."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from four_bars import four_bar, in_millimetres
from handmade_studies import loop_study

from conrod.comparison.other_forces import LIMIT, SPRING, OtherForce
from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.mjcf.crank_speed import CrankSpeed
from conrod.mjcf.loop_results import LABELS, JointSpeed, LawComparison, LoopRequest, LoopRun
from conrod.models.inspection.drive_choice import choose_drives
from conrod.models.inspection.report import (
    INSPECTION_REPORT,
    finding,
    next_step,
    parts_to_paste,
    sections,
    settings_to_paste,
)
from conrod.models.inspection.results import Inspection, InspectionRequest
from conrod.models.inspection.study import inspect, judge_motion, largest_step
from conrod.models.lint.findings import Finding, Severity
from conrod.models.loops import study as loops_study
from conrod.report.findings import Findings

CASES = Path(__file__).parents[1] / "data" / "cases"
FOUR_BAR = (CASES / "four-bar-open.xml").read_text(encoding="utf-8")
CLOSED = FOUR_BAR.replace("1.98391805810863", "1.80941805810863")  # the rocker where the coupler's end is
MESHES = """<mujoco><compiler meshdir="parts"/>
  <asset><mesh name="base" file="base.stl"/><mesh name="arm" file="arm.stl"/>
  <texture name="wood" type="2d" file="wood.png"/><material name="wood" texture="wood"/></asset>
  <worldbody><geom type="mesh" mesh="base" material="wood"/><body name="upper"><joint name="shoulder" axis="0 1 0"/>
    <inertial pos="0 0 0.1" mass="1" diaginertia="1e-2 1e-2 1e-3"/><geom name="skin" type="mesh" mesh="arm"/>
    <body name="fore" pos="0 0 0.3"><joint name="elbow" axis="0 1 0"/>{geom}<geom type="mesh" mesh="arm"/></body></body>
  </worldbody><sensor><framepos objtype="geom" objname="skin"/></sensor></mujoco>"""


@contextmanager
def cheap_runs() -> Iterator[None]:
    """Motion is judged with few runs and settings, which are timed coarsely."""
    with pytest.MonkeyPatch.context() as patch:
        cheaper = {"COARSER": (2,), "FINER": (), "SEARCHED": LABELS, "MAX_SAMPLES": 100, "CHECKED_INSTANTS": 25}
        for name, cheap in cheaper.items():
            patch.setattr(f"conrod.models.loops.study.{name}", cheap)
        patch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
        yield


@pytest.fixture(autouse=True)
def unjudged(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """No drive is chosen and no motion judged but in the fixtures below; and lint looks at short runs."""
    monkeypatch.setattr("conrod.models.lint.linting.DEFAULT_STEPS", 200)
    if "judged" not in request.fixturenames:
        chosen = f"{inspect.__module__}.choose_drives"
        monkeypatch.setattr(chosen, lambda *_: ({}, "not judged in this test"))


@pytest.fixture
def judged() -> Iterator[None]:
    """A drive is chosen and the motion is judged."""
    with cheap_runs():
        yield


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> Inspection:
    """The closed four-bar, its motion judged: for all tests that look at it, or change some of what was found."""
    with cheap_runs():
        return inspected(CLOSED, tmp_path_factory.mktemp("closed"))


def inspected(text: str, folder: Path, name: str = "model.xml", **question: object) -> Inspection:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return inspect(file, InspectionRequest(**question), file.stem)  # type: ignore[arg-type]


def said(study: Inspection, section: str) -> str:
    return "\n".join(line for question, lines in sections(study) for line in lines if section in question)


# -- does it load? -----------------------------------------------------------------------------------------------------


def test_missing_files_that_no_motion_needs_are_left_out(tmp_path: Path) -> None:
    found = inspected(MESHES.format(geom='<geom size="0.05"/>'), tmp_path)
    assert found.passed
    words = said(found, "load")
    assert "2 meshes (base.stl, arm.stl) and 1 texture image (wood.png) are not there and left out" in words
    assert "fore lacks the mass of arm.stl" in words
    assert "upper lacks" not in words
    assert not any("does not take it" in one for one in found.lint_notes)


def test_a_missing_mesh_with_the_only_mass_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"model.xml: arm.stl gives fore its only mass, and is not there"):
        inspected(MESHES.format(geom=""), tmp_path)


def test_an_unknown_plugin_is_left_out_with_its_parts(tmp_path: Path) -> None:
    text = CLOSED.replace(
        "</mujoco>",
        '<extension><plugin plugin="my.spring"><instance name="soft"/></plugin></extension>'
        '<actuator><plugin plugin="my.spring" instance="soft" joint="crank"/></actuator></mujoco>',
    )
    found = inspected(text, tmp_path)
    assert "plugin my.spring is not known to MuJoCo" in said(found, "load")
    assert "left out, with its actuator" in said(found, "load")
    assert found.closing.passed


def test_a_binary_model_is_said_not_to_be_linted(tmp_path: Path) -> None:
    model = mujoco.MjModel.from_xml_string(CLOSED)
    mujoco.mj_saveModel(model, str(tmp_path / "model.mjb"), None)
    found = inspect(tmp_path / "model.mjb", InspectionRequest(), "model")
    note = "lint does not take it: a binary model cannot be taken apart; give the MJCF that it was made from"
    assert said(found, "what else").splitlines() == [note]
    assert found.passed
    assert note not in said(inspected(CLOSED, tmp_path), "what else")


@pytest.mark.parametrize("given", [{}, {"crank": "60rpm"}])
def test_own_run_is_judged_by_a_law_that_was_given_alone(
    given: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that runs at 500 rpm from its keyframe does not follow the 60 rpm that an inspection chose."""
    strayed = LawComparison((JointSpeed("crank", CrankSpeed(52.4, 52.4, 52.4), 6.28),))
    study = loop_study()
    judged_study = replace(study, shipped=replace(study.shipped, laws=strayed))
    assert judged_study.shipped_failed
    monkeypatch.setattr(f"{inspect.__module__}.study_loops", lambda *_, **__: judged_study)
    asked = InspectionRequest(drives=given)
    found = judge_motion(Path("saw.xml"), asked, {"crank": "60rpm"}, "saw", None)
    assert found.shipped_failed is bool(given)


def test_a_file_that_is_no_model_is_refused_as_before(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="MuJoCo cannot load it: XML Error"):
        inspected("<mujoco><worldbody><bodi/></worldbody></mujoco>", tmp_path)


URDF = """<robot name="arm"><link name="base"/><link name="upper">
  <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><mesh filename="package://arm/upper.stl"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="3" velocity="2"/></joint>
  <transmission name="drive"/></robot>"""


def test_urdf_is_read_and_what_it_loses_is_said(tmp_path: Path) -> None:
    words = said(inspected(URDF, tmp_path, "arm.urdf"), "load")
    assert "1 mesh (upper.stl) is not there and left out" in words
    assert "velocity limits of shoulder are lost" in words
    assert "1 <transmission>: no actuator is made of it" in words


@pytest.mark.parametrize("encoding", ["shift-jis", "klingon"])
def test_urdf_in_an_encoding_that_python_lacks_is_inspected(encoding: str, tmp_path: Path) -> None:
    """MuJoCo reads the file as bytes; what needs Python's parser is left out."""
    found = inspected(f'<?xml version="1.0" encoding="{encoding}"?>{URDF}', tmp_path, "arm.urdf")
    assert "1 body, 1 joint" in said(found, "load")
    assert "from URDF" not in said(found, "load")


def test_a_velocity_limit_that_is_a_macro_is_lost_too(tmp_path: Path) -> None:
    for velocity, lost in (("${fast}", True), ("", False), ("0", False)):
        found = inspected(URDF.replace('velocity="2"', f'velocity="{velocity}"'), tmp_path, "arm.urdf")
        assert ("velocity limits of shoulder are lost" in said(found, "load")) is lost


def test_a_model_in_millimetres_is_asked_about_and_converted(tmp_path: Path, closed: Inspection) -> None:
    text = in_millimetres(CLOSED)
    typed = inspected(text, tmp_path)
    assert "m long: is the model in millimetres? --unit mm says so" in said(typed, "load")
    found = inspected(text, tmp_path, unit=1e-3)
    assert found.loading.remarks == closed.loading.remarks == ()
    assert found.loading.across == pytest.approx(closed.loading.across, rel=1e-9)
    assert found.loading.mass == pytest.approx(closed.loading.mass, rel=1e-9)
    # The unit comes before all else, as no size is right without it; asked once, and not of a model in metres.
    assert next_step(typed).startswith("if it is in mm: conrod check")
    assert "model.xml --unit mm; otherwise: conrod " in next_step(typed)
    assert "if it is in mm" not in next_step(found) + next_step(closed)
    assert ". Its sizes are those of a model in mm: --unit mm says so." in finding(typed)
    assert "--unit" not in finding(found) + finding(closed)


# -- does it close? ----------------------------------------------------------------------------------------------------


def test_a_closed_four_bar_has_nothing_in_its_way(closed: Inspection) -> None:
    assert closed.passed
    assert closed.closing.start.largest < 1e-9
    assert finding(closed).startswith("It loads and closes. Driven by crank it is 0.12 mm off its exact motion")
    assert "no actuator drives it" in said(closed, "moves")
    assert dict(closed.drives) == {"crank": "60rpm"}
    assert "--drive crank=60rpm --tolerance position=0.2mm" in next_step(closed)
    settings = said(closed, "what to set")
    assert settings.startswith("nothing: its own settings are within 0.20 mm, a thousandth of its range of motion")
    assert "The cheapest that holds position 0.20 mm (0.0010 L): " in settings
    assert not [*settings_to_paste(closed)]
    # Control: where its own do not hold, the lines of those that do are there to paste.
    motion = closed.motion
    assert motion is not None
    off = replace(motion.driven_run, errors={**motion.driven_run.errors, "position": 3e-4})
    titles = [title for title, _ in settings_to_paste(replace(closed, motion=replace(motion, runs=(off,))))]
    assert titles[0] == "the cheapest settings within tolerance, to paste before </mujoco>"
    # The limit of lint's error is another one, and both say of what theirs is.
    play = "a ten-thousandth of its size"
    assert play not in settings
    opens = Finding(rule="soft-closure", what="pin2 opens by 0.1 mm", severity=Severity.ERROR,
                    evidence={}, why="", fix="harden")  # fmt: skip
    with_soft = replace(closed, findings=(opens,))
    assert f"6 asks more of closures, a bearing's play, which is {play}" in said(with_soft, "what to set")
    assert f"pin2 opens by 0.1 mm, more than a bearing's play, {play}: harden" in said(with_soft, "what else")
    # Lines that lint's error is mended by too are the next thing to do, where MJCF can say all of them.
    soft = Finding(rule="soft-closure", what="pin2 opens", severity=Severity.ERROR, evidence={}, why="", fix="harden")
    given = replace(closed, findings=(soft,))
    assert motion.search is not None
    for compiled, words in (("", "paste the lines above before </mujoco>, then conrod check"), ("x", "conrod harden")):
        search = replace(motion.search, after_compiling=compiled)
        edited = replace(given, motion=replace(motion, runs=(off,), paste="<option/>", search=search))
        assert next_step(edited).startswith(words)
        # They are so without an error of lint: the file is out of tolerance until they are in it.
        assert next_step(replace(edited, findings=())).startswith(words)
    assert next_step(replace(closed, findings=(soft,))).startswith("conrod harden")  # its own do: no line is printed
    in_mm = replace(closed, findings=(soft,), question=replace(closed.question, unit=1e-3))
    assert next_step(in_mm).endswith("model.xml --unit mm")
    assert next_step(in_mm).startswith("conrod harden ")


def test_page_draws_judged_runs_over_the_exact_motion(closed: Inspection, tmp_path: Path) -> None:
    drawn, motion = closed.picture, closed.motion
    assert drawn is not None
    assert motion is not None
    assert (drawn.view, drawn.reference) == ("In the xy plane", "exact")
    assert [run.name for run in drawn.runs] == list(LABELS)
    assert {shape.link for shape in drawn.shapes if shape.kind == "bar"} == {"crank", "coupler", "rocker"}
    for run in motion.runs:
        off = next(one.off for one in drawn.runs if one.name == run.label)
        assert max(off) == pytest.approx(1e3 * run.errors["position"], rel=0.05)
    page = page_of(closed, tmp_path)
    assert '<div class="links"' in page
    assert "magnified 100 times" in page
    # Control: a model that is judged by nothing has no grey machine.
    assert 'class="ghost"' in page
    assert 'class="ghost"' not in page_of(inspected(SERVO, tmp_path), tmp_path)


SERVO = """<mujoco><worldbody><body name="<b>arm" gravcomp="1"><joint name="j" axis="0 1 0" range="-1 1"/>
  <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/></body></worldbody><compiler angle="radian"/>
  <actuator><position name="servo" joint="j" kp="50" kv="5"/></actuator></mujoco>""".replace("<b>", "&lt;b>")


def page_of(study: Inspection, folder: Path) -> str:
    """The HTML page of an inspection."""
    file = folder / "page.html"
    Findings(INSPECTION_REPORT, {study.name: study}, "inspect_model(...)", typed={study.name: study.file}).write(file)
    return file.read_text(encoding="utf-8")


def test_page_of_an_actuated_model_has_the_trial_that_was_made(tmp_path: Path) -> None:
    found = inspected(SERVO, tmp_path)
    assert found.picture is not None
    assert [run.name for run in found.picture.runs] == ["servo, as it was tried"]
    # It goes to where it was commanded: to 0.8 rad, one way and the other.
    rows = found.picture.runs[0].rows.reshape(-1, found.picture.runs[0].rows.shape[1] // 2, 2)
    arm = rows[:, 1] - rows[:, 0]
    angles = np.degrees(np.unwrap(np.arctan2(arm[:, 1], arm[:, 0])))
    angles = np.abs(angles - angles[0])
    assert angles.max() == pytest.approx(np.degrees(0.8), rel=0.02)
    page = page_of(found, tmp_path)
    assert "servo, as it was tried" in page
    assert "<b>arm" not in page
    followed = inspect(tmp_path / "model.xml", InspectionRequest(drives={"servo": "sine:20deg,1Hz"}), "model")
    assert followed.picture is not None
    assert [run.name for run in followed.picture.runs] == ["servo = sine:20deg,1Hz"]
    # In grey is what was commanded, which the servo lags behind: as far as is said.
    assert followed.picture.reference == "as commanded"
    (response,) = followed.moving.followed
    tip = 0.3 * 1e3  # [mm], by which an angle moves it
    assert max(followed.picture.runs[0].off) == pytest.approx(tip * response.error, rel=0.1)
    assert response.error > 0.01


def test_settings_stay_at_steps_that_actuators_bear() -> None:
    def bound(*largest: float | None, faster: float | None = None) -> float | None:
        steps = [SimpleNamespace(steps=SimpleNamespace(largest=one, implicitfast=faster)) for one in largest]
        moving: Any = SimpleNamespace(actuators=(*steps, SimpleNamespace(steps=None)))
        return largest_step(mujoco.MjModel.from_xml_string(CLOSED), moving)

    assert bound() is None
    assert bound(0.016, 0.004) == 0.004
    # What bears no step that was tried, or less than the model's own of 1 ms, leaves that.
    assert bound(0.016, None) == bound(0.0005) == 0.001
    # What RK4 does not bear, implicitfast may: settings are tried under both.
    assert bound(None, faster=0.008) == 0.008


def test_an_open_loop_is_named_with_its_nearest_closed_pose(tmp_path: Path) -> None:
    found = inspect(CASES / "four-bar-open.xml", InspectionRequest(), "open")
    assert not found.passed
    assert finding(found).startswith("It loads but does not close: pin2 is open by 38 mm in its own pose.")
    pose = found.closing.start.closed
    assert f'qpos="{pose}"' in next_step(found)
    mended = FOUR_BAR.replace("</mujoco>", f'<keyframe><key name="closed" qpos="{pose}"/></keyframe></mujoco>')
    assert inspected(mended, tmp_path, keyframe="closed").closing.passed


def test_a_pose_too_long_for_a_sentence_is_there_to_paste(closed: Inspection) -> None:
    pose = " ".join(["0.5"] * 21)
    start = replace(closed.closing.start, gaps={"pin2": 0.3}, closed=pose)
    found = replace(closed, closing=replace(closed.closing, poses=(start,)))
    assert "the nearest closed pose is below" in said(found, "close")
    title, lines = next(parts_to_paste(found))
    assert title == "the nearest closed pose, to paste before </mujoco>"
    assert lines == f'<keyframe><key name="closed" qpos="{pose}"/></keyframe>'
    assert next_step(found).startswith("paste keyframe closed above before </mujoco>, then conrod check")
    # Control: a short pose stands in the sentence alone.
    short = replace(closed, closing=replace(closed.closing, poses=(replace(start, closed="0 0 0"),)))
    assert 'the nearest closed pose is qpos="0 0 0"' in said(short, "close")
    assert not [one for one in parts_to_paste(short) if "pose" in one[0]]


def test_a_loop_open_by_a_millimetre_is_said(tmp_path: Path) -> None:
    found = inspected(CLOSED.replace('name="R" pos="0.22 0 0"', 'name="R" pos="0.221 0 0"'), tmp_path)
    assert not found.closing.passed
    assert "pin2 is open by 1.0 mm" in said(found, "close")


def test_a_loop_that_an_axis_blocks_names_the_axis(tmp_path: Path, closed: Inspection) -> None:
    tilted = CLOSED.replace('joint name="rocker" axis="0 0 1"', 'joint name="rocker" axis="0 0.1 1"')
    assert tilted != CLOSED
    found = inspected(tilted, tmp_path)
    assert "Nothing of it can move." in finding(found)
    model = mujoco.MjModel.from_xml_string(tilted)
    drives, reason = choose_drives(model, model.qpos0)
    assert not drives
    assert reason.endswith("each alone would explain it")
    assert next_step(found).startswith("mend what leaves it no freedom, as 4 says, then conrod check")
    # Control: with parallel axes nothing is blocked.
    assert "Nothing of it can move." not in finding(closed)


def test_a_closure_too_many_is_named_where_no_axis_explains(tmp_path: Path, judged: None) -> None:
    # A body that a weld holds to the world: nothing in it is off, and nothing can move.
    found = inspected(
        """<mujoco><worldbody><body name="box"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body></worldbody>
        <equality><weld name="glue" body1="box"/></equality></mujoco>""", tmp_path,
    )  # fmt: skip
    assert "mend what leaves it no freedom: one of glue is too many, then conrod check" in next_step(found)


def test_an_anchor_that_is_off_its_parts_is_named() -> None:
    found = inspect(CASES / "anchor-apart.xml", InspectionRequest(), "apart")
    assert not found.passed
    assert "pin holds rocker at a point 331 mm from its nearest geom: the parts do not meet" in finding(found)
    assert next_step(found).startswith("connect sites where the parts meet, then conrod check")
    assert "not judged: its parts do not meet" in said(found, "exact")


@pytest.mark.slow
def test_a_start_outside_ranges_has_a_pose_inside(tmp_path: Path, judged: None) -> None:
    found = inspect(CASES / "folded-leg.xml", InspectionRequest(), "folded")
    words = said(found, "close")
    assert "its own pose has length at 0 m, outside its range 0.12 to 0.68 m" in words
    assert found.closing.start.inside in next_step(found)
    # The drive begins in the pose inside, too.
    assert found.drives["length"].startswith("move:192.8mm")
    assert "its start is folded: the motion starts from the nearest closed pose" in said(found, "exact")
    assert found.motion is not None
    assert "femur at 0 deg" in found.motion.moved_start


def test_a_weld_to_a_mocap_body_is_a_handle_and_no_error() -> None:
    found = inspect(CASES / "mocap-weld.xml", InspectionRequest(), "mocap")
    assert found.passed
    assert "hold is a handle: it drags hand after the mocap body handle" in said(found, "close")
    assert found.findings == ()


FOLDED_ARM = """<mujoco>
  <default><geom contype="0" type="capsule" size="0.02"/><joint axis="0 1 0"/></default><worldbody>
  <body name="handle" mocap="true" pos="1 0 0"/>
  <body name="upper"><joint name="shoulder"/><geom fromto="0 0 0 1 0 0"/>
    <body name="fore" pos="1 0 0"><joint name="elbow"/><geom fromto="0 0 0 -1 0 0"/>
      <body name="hand" pos="-1 0 0"><joint name="wrist"/><geom fromto="0 0 0 1 0 0"/>
        <body name="tip" pos="1 0 0"/></body></body></body>
  </worldbody><equality>EQUALITY</equality></mujoco>"""


def test_a_folded_arm_on_a_handle_has_no_loop_that_is_singular(tmp_path: Path) -> None:
    handle = '<weld name="hold" body1="handle" body2="tip"/>'
    words = said(inspected(FOLDED_ARM.replace("EQUALITY", handle), tmp_path), "close")
    assert "it has no closed loop that acts" in words
    assert "singular" not in words
    # Negative control: a pin in the place of the handle is a loop, and singular where the links lie in one line.
    pin = '<connect name="hold" body1="tip" body2="world" anchor="0 0 0"/>'
    assert "singular" in said(inspected(FOLDED_ARM.replace("EQUALITY", pin), tmp_path), "close")


def test_a_model_without_loop_and_actuator_says_so_first(tmp_path: Path) -> None:
    arm = FOLDED_ARM.replace("<equality>EQUALITY</equality>", "")
    words = "It has no closed loop and no actuator that was tried: no motion of it is judged."
    assert words in finding(inspected(arm, tmp_path))
    # A motor is tried, and reaches no position.
    motor = '<actuator><motor name="push" joint="wrist"/></actuator></mujoco>'
    words_of_force = "It has no closed loop, and push is a force: no motion of it is judged."
    assert words_of_force in finding(inspected(arm.replace("</mujoco>", motor), tmp_path))
    # Control: an actuator that was tried is the first thing to say.
    servo = '<actuator><position name="servo" joint="wrist" kp="50" kv="5"/></actuator></mujoco>'
    assert words not in finding(inspected(arm.replace("</mujoco>", servo), tmp_path))


@pytest.mark.slow
def test_a_model_that_stands_still_is_no_model_without_findings() -> None:
    found = inspect(CASES / "steering.xml", InspectionRequest(), "steering")
    assert "Nothing moves in its own run." in finding(found)
    assert "note nothing-moves" in said(found, "else")


# -- how exact? --------------------------------------------------------------------------------------------------------


# Cardan's joint: the output's axis is bent by 30 deg. All points of its axes stand still, and all of it turns.
CARDAN = """<mujoco><option gravity="0 0 0"/><default><geom contype="0" conaffinity="0" size="0.01"/></default>
  <worldbody><body name="input"><joint name="input" axis="1 0 0"/><geom type="capsule" fromto="-0.3 0 0 0 0 0"/>
    <body name="cross"><joint name="c1" axis="0 0 1"/><geom type="box" size="0.01 0.02 0.02"/>
      <body name="output"><joint name="c2" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.26 0 0.15"/>
        <site name="tip" pos="0.26 0 0.15"/></body></body></body>
  <body name="bearing" pos="0.26 0 0.15"><joint name="roll" axis="0.26 0 0.15"/><geom type="sphere"/>
    <site name="seat"/></body></worldbody>
  <equality><weld name="shaft" site1="tip" site2="seat"/></equality></mujoco>"""


def test_a_loop_that_turns_on_the_spot_is_driven() -> None:
    model = mujoco.MjModel.from_xml_string(CARDAN)
    assert choose_drives(model, model.qpos0) == ({"input": "60rpm"}, "")
    request = LoopRequest({"input": "60rpm"}, seconds=1.0)
    judged = [point.name for point in loops_study._LoopBench.from_request(model, request).points]
    assert judged
    assert all(name.endswith("mm off its axis") for name in judged)


def test_two_floating_bodies_on_a_pin_have_nothing_to_drive() -> None:
    body = '<body name="{0}" pos="{1} 0 0"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{body.format('a', 0)}{body.format('b', 0.2)}</worldbody>"
        '<equality><connect body1="a" body2="b" anchor="0.1 0 0"/></equality></mujoco>'
    )
    reason = "its loops move, but no hinge or slide of them that a law could drive does"
    assert choose_drives(model, model.qpos0) == ({}, reason)


def chosen(name: str) -> tuple[dict[str, str], str]:
    model = mujoco.MjModel.from_xml_path(str(CASES / name))
    return choose_drives(model, model.qpos0)


def test_a_crank_that_cannot_turn_swings_and_says_why() -> None:
    drives, reason = chosen("four-bar-short.xml")
    assert drives == {"crank": "sine:20deg,1Hz"}
    assert reason.startswith("driven by crank=60rpm: it goes no further than with crank at 127.95 deg")


def test_a_chosen_drive_keeps_limits_of_joints_and_tendons() -> None:
    rope = '<tendon><spatial name="rope" limited="true" range="0 {}"><site site="P"/><site site="post"/></spatial>'
    post = CLOSED.replace("<worldbody>", '<worldbody><site name="post" pos="0.35 0.25 0"/>')
    rocker = '<joint name="rocker" axis="0 0 1"'
    for text, left in (
        (post.replace("<equality>", f"{rope.format(0.25)}</tendon><equality>"), "tendon rope"),
        (CLOSED.replace(rocker, f'{rocker} limited="true" range="-0.5 0.5"'), "rocker"),
        (post.replace("<equality>", f"{rope.format(2.5)}</tendon><equality>"), ""),
    ):
        model = mujoco.MjModel.from_xml_string(text)
        drives, reason = choose_drives(model, model.qpos0)
        assert drives == {"crank": "sine:20deg,1Hz" if left else "60rpm"}
        assert reason == (f"driven by crank=60rpm: {left} would leave its limits" if left else "")


def test_a_limit_that_acts_in_a_driven_run_is_named(closed: Inspection) -> None:
    assert closed.motion is not None
    limit = OtherForce(LIMIT, "tendon rope", 1600.0, "N")
    own, *others = closed.motion.runs
    met = replace(closed, motion=replace(closed.motion, runs=(replace(own, acting=(limit,)), *others)))
    assert "at its own settings, with the limit of tendon rope in its way." in finding(met)
    assert "what acts besides its loops: the limit of tendon rope (up to 1.6e+03 N); the exact" in said(met, "exact")
    # Negative control: a spring is no obstacle.
    spring = replace(limit, kind=SPRING)
    sprung = replace(closed, motion=replace(closed.motion, runs=(replace(own, acting=(spring,)), *others)))
    assert finding(sprung) == finding(closed)


def test_a_model_whose_only_closure_is_inactive_says_so_first(tmp_path: Path) -> None:
    found = inspected(CLOSED.replace('name="pin2"', 'name="pin2" active="false"'), tmp_path)
    assert finding(found).startswith('It loads. Closure pin2 is inactive (active="false"): it has no other closed loop')


def test_a_joint_with_an_actuator_is_driven_first() -> None:
    drives, reason = chosen("strut-leg.xml")
    assert (drives, reason) == ({"leg_length": "sine:60mm,1Hz"}, "")


@pytest.mark.slow
def test_a_start_beside_a_dead_centre_is_left_one_way() -> None:
    servo = '<actuator><position joint="rocker" kp="10"/></actuator>'
    model = mujoco.MjModel.from_xml_string(four_bar(more=servo))
    drives, reason = choose_drives(model, model.qpos0)
    assert drives == {"rocker": "move:115.565deg,135.565deg,1s"}
    assert "a dead centre" in reason


def test_a_model_without_a_loop_has_no_drive() -> None:
    drives, reason = chosen("mocap-weld.xml")
    assert not drives
    assert reason == "it has no closed loop, which alone could open"


# -- what is next? -----------------------------------------------------------------------------------------------------


def test_a_model_without_joints_cannot_move(tmp_path: Path) -> None:
    found = inspected("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>", tmp_path)
    assert not found.passed
    assert finding(found) == "It loads. Nothing of it can move."
    assert next_step(found).startswith("give it a joint, then conrod check")


def test_the_next_command_goes_on_with_the_options_given(tmp_path: Path) -> None:
    text = """<mujoco><worldbody><body><joint name="j" type="slide"/><geom size="9"/></body></worldbody>
      <actuator><position name="servo" joint="j" kp="900" kv="90"/></actuator>
      <keyframe><key name="up" qpos="3"/></keyframe></mujoco>"""
    found = inspected(text, tmp_path, unit=1e-2, keyframe="up")
    assert next_step(found).endswith("model.xml --unit cm --keyframe up --drive servo=sine:20mm,1Hz")
    assert found.loading.across == pytest.approx(0.18 * 3**0.5)


@pytest.mark.parametrize(
    ("actuator", "words"),
    [
        ("<motor name='push' joint='j' ctrlrange='-1 1'/>", "conrod invariances"),
        ("<velocity name='servo' joint='j' kv='90' ctrlrange='-0.01 0.01'/>", "--drive servo=sine:1.3mm,1Hz"),
        ("<position name='servo' joint='j' kp='900' kv='90' ctrlrange='0 0.1'/>", "--drive servo=move:0mm,"),
    ],
)
def test_the_next_command_is_one_that_the_model_takes(tmp_path: Path, actuator: str, words: str) -> None:
    body = "<body gravcomp='1'><joint name='j' type='slide' range='0 0.1'/><geom size='0.05'/></body>"
    text = f"<mujoco><worldbody>{body}</worldbody><actuator>{actuator}</actuator></mujoco>"
    found = inspected(text, tmp_path)
    assert words in next_step(found)
    if found.moving.actuators[0].kind != "motor":
        _, law = next_step(found).rsplit("=", 1)
        driven = inspect(tmp_path / "model.xml", InspectionRequest(drives={"servo": law}), "model")
        assert driven.passed
        assert finding(driven).startswith(f"It loads. With servo = {law}: joint j follows within ")


def test_joints_that_are_held_are_named_as_held(closed: Inspection) -> None:
    run = LoopRun("as it is", 1e-3, Outcome.DIVERGED, "not finite at 0.1 s", gap=1.0)
    motion = loop_study(runs=(run,))
    failed = replace(closed, motion=motion, drives={"crank": "60rpm", "pin": "hold"})
    # What ends with status 1 says why in its first line.
    assert not failed.passed
    assert "Driven by crank it ends as diverged: not finite at 0.1 s." in finding(failed)
    lines = said(failed, "exact")
    assert lines.splitlines()[0] == "driven by crank=60rpm (held: pin) it ends as diverged: not finite at 0.1 s"
