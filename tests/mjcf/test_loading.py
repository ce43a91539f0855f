"""What is read of a user's model before it is run: names, starts, controls, crank and points, and each refusal."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod.errors import InvalidInput, list_names
from conrod.mjcf.loading import (
    check_finite,
    data_at_start,
    element_id,
    find_crank,
    find_point,
    joint_kind,
    keyframe_to_start_from,
    load_model,
    name_or_number,
    names_of,
    names_or_numbers,
    start_words,
)
from conrod.mjcf.request import PointPlace

NAMES = """<mujoco><worldbody><body name="link"><joint name="crank"/><geom name="bar" size="1"/>
  <site name="tip"/></body></worldbody>{}</mujoco>"""


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ('<actuator><position name="servo" joint="crnk"/></actuator>',
         "position servo: unknown joint 'crnk': did you mean 'crank'? choose from crank"),
        ('<actuator><motor site="tpi"/></actuator>', "motor: unknown site 'tpi': did you mean 'tip'? choose from tip"),
        ('<equality><connect name="pin" body1="lnk" anchor="0 0 0"/></equality>',
         "connect pin: unknown body 'lnk': did you mean 'link'? choose from link"),
        ('<sensor><jointpos joint="crnk"/></sensor>', "jointpos: unknown joint 'crnk': did you mean 'crank'?"),
        ('<actuator><motor tendon="rope"/></actuator>', "motor: unknown tendon 'rope': there is none with a name"),
        # Controls: what is wrong otherwise is said in MuJoCo's words.
        ("<actuator>" + 2 * '<motor name="a" joint="crank"/>' + "</actuator>", "MuJoCo cannot load it"),
        ("<actuator><motor/></actuator>", "MuJoCo cannot load it"),
    ],
)  # fmt: skip
def test_unknown_name_in_a_file_is_named_with_the_nearest(section: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text(NAMES.format(section))
    with pytest.raises(InvalidInput) as refused:
        load_model(file)
    assert str(refused.value).startswith(f"{file}: {words}")
    assert "\n" not in str(refused.value)


TEXT = """
<mujoco>
  <option gravity="0 -9.81 0"/>
  <worldbody>
    <body name="arm" pos="1 2 3">
      <joint name="pin" type="hinge" axis="0 0 1"/>
      <geom name="bar" size="0.1" pos="0.5 0 0"/>
      <site name="tip" pos="1 0 0"/>
      <body pos="0 0 1">
        <joint type="slide" axis="1 0 0"/>
        <joint name="ball" type="ball"/>
        <geom size="0.1"/>
      </body>
    </body>
    <body name="free"><joint name="loose" type="free"/><geom name="stone" size="0.1"/>
      <site name="edge" pos="0 0.1 0"/></body>
  </worldbody>
  <actuator>
    <motor name="motor" joint="pin" ctrlrange="-2 3" ctrllimited="true"/>
    <motor joint="pin"/>
  </actuator>
  <keyframe>
    <key name="start" qpos="0.5 0 1 0 0 0 0 0 0 1 0 0 0" ctrl="1.5 0"/>
    <key qpos="0.25 0 1 0 0 0 0 0 0 1 0 0 0"/>
  </keyframe>
</mujoco>
"""
BARE = "<mujoco><worldbody><body><joint type='slide'/><geom size='1'/></body></worldbody></mujoco>"


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(TEXT)


@pytest.fixture(scope="module")
def bare() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(BARE)


def refusal(call: Any, *arguments: Any) -> str:
    with pytest.raises(InvalidInput) as refused:
        call(*arguments)
    return str(refused.value)


def test_elements_have_names_or_numbers(model: mujoco.MjModel) -> None:
    assert names_of(model, "joint") == ["pin", "", "ball", "loose"]
    assert names_of(model, "body") == ["world", "arm", "", "free"]
    assert names_of(model, "actuator") == ["motor", ""]
    assert names_of(model, "key") == ["start", ""]
    assert (names_of(model, "site"), names_of(model, "geom")) == (["tip", "edge"], ["bar", "", "stone"])
    assert names_of(model, "equality") == []
    assert names_or_numbers(["a", "", "c", ""]) == ["a", "1", "c", "3"]
    assert name_or_number(model, "joint", 0) == "pin"
    assert name_or_number(model, "joint", 1) == "joint 1"
    assert [element_id(model, "joint", name) for name in ("pin", "ball", "loose")] == [0, 2, 3]
    assert [joint_kind(model, joint) for joint in range(4)] == ["hinge", "slide", "ball", "free"]


def test_missing_element_is_named_with_those_that_exist(model: mujoco.MjModel) -> None:
    assert (
        refusal(element_id, model, "joint", "pim")
        == "unknown joint 'pim': did you mean 'pin'? choose from ball, loose, pin"
    )
    assert refusal(element_id, model, "joint", "") == ("unknown joint '': choose from ball, loose, pin")


def test_names_are_listed_up_to_six() -> None:
    assert list_names(["a", "b"]) == "a, b"
    assert list_names("abcdef") == "a, b, c, d, e, f"
    assert list_names("abcdefgh") == "a, b, c, d, e, f and 2 more"
    assert list_names("abc", 2) == "a, b and 1 more"


@pytest.mark.parametrize(("given", "index"), [(None, 0), ("start", 0), ("1", 1), ("0", 0), ("qpos0", None)])
def test_a_start_is_a_keyframe_by_name_or_number_or_the_own_pose(
    given: str | None, index: int | None, model: mujoco.MjModel
) -> None:
    assert keyframe_to_start_from(model, given) == index
    data, found = data_at_start(model, given)
    assert found == index
    assert data.qpos[0] == {0: 0.5, 1: 0.25, None: 0.0}[index]
    assert data.ctrl.tolist() == ([1.5, 0.0] if index == 0 else [0.0, 0.0])


def test_without_a_keyframe_a_model_starts_from_its_own_pose(bare: mujoco.MjModel) -> None:
    assert keyframe_to_start_from(bare, None) is None
    assert data_at_start(bare, None)[1] is None
    assert refusal(keyframe_to_start_from, bare, "start") == "unknown keyframe 'start': choose from qpos0"


def test_a_keyframe_that_is_not_there_is_refused(model: mujoco.MjModel) -> None:
    for given in ("2", "begin"):
        message = refusal(keyframe_to_start_from, model, given)
        assert message.startswith(f"unknown keyframe '{given}': ")
        assert message.endswith("choose from 1, qpos0, start")


def test_controls_take_the_place_of_the_keyframes(model: mujoco.MjModel) -> None:
    assert data_at_start(model, None, (("motor", 2.5), ("1", -7.0)))[0].ctrl.tolist() == [2.5, -7.0]
    assert data_at_start(model, None, (("0", 3.0),))[0].ctrl.tolist() == [3.0, 0.0]
    assert data_at_start(model, "qpos0", (("1", 4.0),))[0].ctrl.tolist() == [0.0, 4.0]


@pytest.mark.parametrize(("control", "message"), [
    (("motor", 3.5), "--ctrl motor=3.5: MuJoCo clamps it to its ctrlrange, -2 to 3"),
    (("0", -2.5), "--ctrl 0=-2.5: MuJoCo clamps it to its ctrlrange, -2 to 3"),
    (("moter", 1.0), "unknown actuator 'moter': did you mean 'motor'? choose from 1, motor"),
    (("2", 1.0), "unknown actuator '2': choose from 1, motor"),
])  # fmt: skip
def test_controls_that_cannot_be_given_are_refused(
    control: tuple[str, float], message: str, model: mujoco.MjModel
) -> None:
    assert refusal(data_at_start, model, None, (control,)).startswith(message)


def test_control_is_refused_without_actuators_and_kept_unclamped(bare: mujoco.MjModel) -> None:
    assert refusal(data_at_start, bare, None, (("motor", 1.0),)) == "--ctrl motor: the model has no actuator"
    free = mujoco.MjModel.from_xml_string(TEXT.replace("/>", "><flag clampctrl='disable'/></option>", 1))
    assert data_at_start(free, None, (("motor", 9.0),))[0].ctrl.tolist() == [9.0, 0.0]


@pytest.mark.parametrize(("keyframe", "controls", "words"), [
    (None, (), "its own pose"), (0, (), "keyframe start"), (1, (0.0, 0.0), "keyframe 1"),
    (0, (4.1887902, 0.0), "keyframe start with motor = 4.18879"), (None, (0.0, -2.0), "its own pose with 1 = -2"),
    (None, (1.0, 2.0), "its own pose with motor = 1, 1 = 2"),
])  # fmt: skip
def test_words_of_a_start(keyframe: int | None, controls: tuple[float, ...], words: str, model: mujoco.MjModel) -> None:
    assert start_words(model, keyframe, controls) == words


# -- numbers and files -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("field", "message"), [
    ("gravity", "gravity is not finite"), ("body_pos", "body_pos is not finite"),
    ("dof_damping", "dof_damping is not finite"),
])  # fmt: skip
def test_numbers_that_are_not_finite_are_refused(field: str, message: str) -> None:
    model = mujoco.MjModel.from_xml_string(TEXT)
    check_finite(model)
    values = model.opt.gravity if field == "gravity" else getattr(model, field)
    values.flat[-1] = np.inf
    assert refusal(check_finite, model) == message
    # Places come first, as others follow from them.
    model.geom_size.flat[0] = np.nan
    model.body_pos.flat[-1] = np.nan
    assert refusal(check_finite, model) == ("gravity is not finite" if field == "gravity" else "body_pos is not finite")


@pytest.mark.parametrize(("timestep", "message"), [
    (0.9e-12, "timestep = 9e-13 s is out of range: 1e-12 <= timestep <= 1e+06 s"),
    (1.1e6, "timestep = 1.1e+06 s is out of range: 1e-12 <= timestep <= 1e+06 s"),
    (np.nan, "timestep = nan is not a finite number"),
])  # fmt: skip
def test_a_timestep_that_no_clock_has_room_for_is_refused(timestep: float, message: str) -> None:
    model = mujoco.MjModel.from_xml_string(TEXT)
    model.opt.timestep = timestep
    assert refusal(check_finite, model) == message
    for fine in (1.1e-12, 0.9e6):
        model.opt.timestep = fine
        check_finite(model)


def test_files_are_loaded_as_text_or_binary(tmp_path: Path, model: mujoco.MjModel) -> None:
    (tmp_path / "a.xml").write_text(TEXT)
    mujoco.mj_saveModel(model, str(tmp_path / "a.MJB"))
    for name in ("a.xml", "a.MJB"):
        assert names_of(load_model(tmp_path / name), "joint") == ["pin", "", "ball", "loose"]
    (tmp_path / "bad.xml").write_text("<mujoco>\n  <worldbody>\n")
    message = refusal(load_model, tmp_path / "bad.xml")
    assert message == f"{tmp_path / 'bad.xml'}: it is no XML: no element found: line 3, column 0"
    # What is XML and no model is refused in MuJoCo's words.
    (tmp_path / "other.xml").write_text("<mujoco>\n  <wordbody/>\n</mujoco>\n")
    message = refusal(load_model, tmp_path / "other.xml")
    assert message.startswith(f"{tmp_path / 'other.xml'}: MuJoCo cannot load it: ")
    assert "\n" not in message
    assert "there is no such file" in refusal(load_model, tmp_path / "none.xml")
    (named := tmp_path / os.fsdecode(b"a\xff.xml")).write_text(TEXT)
    assert refusal(load_model, named) == f"{named}: its name is no UTF-8, and MuJoCo cannot open it: rename it"


# -- crank and points ------------------------------------------------------------------------------------------------


def test_a_crank_is_a_hinge(model: mujoco.MjModel) -> None:
    assert find_crank(model, "pin") == 0
    for name, kind in (("ball", "ball"), ("loose", "free")):
        assert (
            refusal(find_crank, model, name)
            == f"--crank {name}: it is a {kind} joint, a crank is a hinge; its hinges: pin"
        )
    slides = mujoco.MjModel.from_xml_string(BARE.replace("<joint ", "<joint name='slide' "))
    assert refusal(find_crank, slides, "slide") == (
        "--crank slide: it is a slide joint, a crank is a hinge; it has no hinge with a name"
    )


@pytest.mark.parametrize(("kind", "element", "body", "place"), [
    ("site", "tip", 1, (1.0, 3.0, 3.0)), ("body", "arm", 1, (1.0, 2.0, 3.0)), ("geom", "bar", 1, (1.0, 2.5, 3.0)),
    ("geom", "stone", 3, (0.0, 0.0, 0.0)), ("site", "edge", 3, (0.0, 0.1, 0.0)),
])  # fmt: skip
def test_a_point_is_the_frame_of_a_site_a_body_or_a_geom(
    kind: str, element: str, body: int, place: tuple[float, ...], model: mujoco.MjModel
) -> None:
    point = find_point(model, PointPlace("P", kind, element))
    assert (point.name, point.kind, point.body) == ("P", kind, body)
    data = mujoco.MjData(model)
    data.qpos[0] = np.pi / 2.0
    mujoco.mj_kinematics(model, data)
    assert point.position(data) == pytest.approx(place, abs=1e-12)


@pytest.mark.parametrize("gravity", [True, False])
def test_the_motion_of_a_point_is_that_of_a_circle(gravity: bool) -> None:
    text = TEXT if gravity else TEXT.replace("/>", "><flag gravity='disable'/></option>", 1)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0], data.qacc[0] = 3.0, 5.0
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    data.qacc[:] = 0.0
    data.qacc[0] = 5.0
    mujoco.mj_rnePostConstraint(model, data)
    for kind, element, radius in (("site", "tip", 1.0), ("geom", "bar", 0.5), ("body", "arm", 0.0)):
        position, velocity, acceleration = find_point(model, PointPlace("P", kind, element)).motion(model, data)
        # At rest along x: velocity w r along y, acceleration e r along y and -w^2 r along x.
        assert position == pytest.approx((1.0 + radius, 2.0, 3.0))
        assert velocity == pytest.approx((0.0, 3.0 * radius, 0.0), abs=1e-12)
        assert acceleration == pytest.approx((-9.0 * radius, 5.0 * radius, 0.0), abs=1e-12)
