"""Words and figures on a model's closures, start, limits and differences, against literals known beforehand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from four_bars import GRASHOF, driven, four_bar, start_angles

from conrod.errors import InvalidInput, list_names
from conrod.exact.motion import Array
from conrod.exact.space import SpatialTree
from conrod.exact.space.motion import NO_FURTHER, DrivenTree
from conrod.mjcf.anchors import PartsApart
from conrod.mjcf.causes import add_causes_to_errors, append_causes, describe_closures
from conrod.mjcf.differences import compare_with_machine, list_differences
from conrod.mjcf.force_watch import ForceWatch
from conrod.mjcf.loading import start_words
from conrod.mjcf.reading import tree_of
from conrod.mjcf.start import open_start, pose_words, start_rate_violation
from conrod.models.loops.load_differences import list_load_differences
from conrod.models.loops.ranges import RANDOM_POSES, closed_pose_inside, is_folded, joints_outside, outside_words

CASES = Path(__file__).parents[1] / "data" / "cases"


def bar(text: str = "") -> SpatialTree:
    model = mujoco.MjModel.from_xml_string(text or four_bar(frame=""))
    return tree_of(model, model.qpos0)


# -- forces ------------------------------------------------------------------------------------------------------------

AXLES = """<mujoco><compiler angle="radian"/><option timestep="0.001" gravity="0 0 0"/><worldbody>
  <body><joint name="h" axis="0 0 1" {h}/><geom size="0.1" mass="1"/></body>
  <body><joint type="slide" axis="1 0 0" {s}/><geom size="0.1" mass="1" contype="0" conaffinity="0"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize(("parts", "kind", "name", "largest", "unit", "exact"), [
    ({"h": 'frictionloss="0.25"'}, "dry friction", "joint h", 0.25, "N m", False),
    ({"s": 'frictionloss="0.5"'}, "dry friction", "joint 1", 0.5, "N", False),
    ({"h": 'damping="0.5"'}, "damper", "joint h", 1.0, "N m", True),
    ({"s": 'damping="0.5"'}, "damper", "joint 1", 1.5, "N", True),
    ({"h": 'stiffness="4" springref="0.5"'}, "spring", "joint h", 2.0, "N m", True),
    ({"s": 'stiffness="4" springref="-0.25"'}, "spring", "joint 1", 1.0, "N", True),
])  # fmt: skip
def test_a_force_is_watched_with_its_joint_size_and_unit(
    parts: dict[str, str], kind: str, name: str, largest: float, unit: str, exact: bool
) -> None:
    """At 2 rad/s and 3 m/s."""
    model = mujoco.MjModel.from_xml_string(AXLES.format(**{"h": "", "s": ""} | parts))
    data, watch = mujoco.MjData(model), ForceWatch(model)
    data.qvel[:] = 2.0, -3.0
    mujoco.mj_forward(model, data)
    watch.sample(data)
    (found,) = watch.found
    assert (found.kind, found.name, found.unit, found.exact) == (kind, name, unit, exact)
    assert found.largest == pytest.approx(largest, rel=1e-6)
    # The largest of all samples counts, whichever way it acts.
    data.qvel[:] *= -0.5
    mujoco.mj_forward(model, data)
    watch.sample(data)
    assert watch.found[0].largest == found.largest


def test_a_pair_that_is_part_of_the_machine_is_no_contact() -> None:
    text = """<mujoco><option gravity="0 0 0"/><worldbody><geom name="a" size="0.1"/>
      <body pos="0.15 0 0"><joint type="slide" axis="1 0 0"/><geom name="b" size="0.1"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for pair, names in ((None, ["a and b"]), ((0, 1), []), ((1, 0), []), ((0, 5), ["a and b"])):
        watch = ForceWatch(model, pair)
        watch.step(data)
        assert [one.name for one in watch.found] == names


# -- differences -------------------------------------------------------------------------------------------------------


def test_a_link_that_is_longer_or_shorter_is_said_in_millimetres() -> None:
    # The coupler's pin is on the crank, 0.1 m from its axis; the site C on the rocker.
    longer = four_bar(frame="").replace('pos="0.1 0 0"', 'pos="0.11 0 0"')
    assert list(list_differences(bar(longer), bar())) == ["crank is 10 % longer to coupler: 110 mm instead of 100 mm"]
    shorter = four_bar(frame="").replace('name="C" pos="0.3 0 0"', 'name="C" pos="0.27 0 0"')
    assert list(list_differences(bar(shorter), bar())) == ["rocker is 10 % shorter to pin: 270 mm instead of 300 mm"]
    aside = four_bar(frame="").replace('name="C" pos="0.3 0 0"', 'name="C" pos="0.3 0.004 0"')
    assert list(list_differences(bar(aside), bar())) == ["pin is 4 mm off its place on rocker"]
    placed = four_bar(frame='pos="0.002 0 0"')
    assert list(list_differences(bar(placed), bar())) == ["frame is 2 mm off its place on world"]
    assert list(list_differences(bar(), bar())) == []
    # Either end of a closure may come first.
    swapped = four_bar(frame="").replace('site1="B" site2="C"', 'site1="C" site2="B"')
    assert list(list_differences(bar(swapped), bar())) == []
    assert list(list_differences(bar(swapped.replace('name="C" pos="0.3', 'name="C" pos="0.27')), bar())) == [
        "rocker is 10 % shorter to pin: 270 mm instead of 300 mm"
    ]


def test_a_loop_that_does_not_act_is_inactive_and_not_missing() -> None:
    off = bar(four_bar(frame="", closure='active="false"'))
    assert list(list_differences(off, bar(), ("pin",))) == ["closure pin is inactive"]
    assert list(list_differences(off, bar())) == ["loop pin is missing"]
    assert list(list_differences(bar(), off)) == ["pin is a loop more"]
    machine = driven(four_bar(frame=""), {"crank": "60rpm"}, 0.1)
    motion = machine.motion(np.linspace(0.0, 0.1, 3))
    more = four_bar(frame="").replace("</equality>", '<connect name="again" site1="B" site2="C"/></equality>')
    found = compare_with_machine("bar", machine.tree, bar(more), machine.laws, (), motion, ("again",))
    assert (found.differences, found.other_branch, found.other_kinds) == (("closure again is inactive",), False, False)
    assert found.off is not None
    assert found.off < 1e-9
    renamed = bar(four_bar(frame="").replace('joint name="crank"', 'joint name="shaft"'))
    with pytest.raises(InvalidInput, match=r"^bar has no joint crank: shaft, coupler, rocker$"):
        compare_with_machine("bar", machine.tree, renamed, machine.laws, (), motion)
    bare = replace(bar(), points={"P": bar().points["A"]})
    with pytest.raises(InvalidInput, match=r"^it has no site in common with bar: P$"):
        compare_with_machine("bar", machine.tree, bare, machine.laws, (), motion)


def test_loads_differ_in_the_units_of_their_joints() -> None:
    text = AXLES.replace("<body>", '<body name="x">', 1)
    model = mujoco.MjModel.from_xml_string(text.format(h='damping="0.5"', s='damping="0.25"'))
    other = mujoco.MjModel.from_xml_string(text.format(h="", s=""))
    other.body_mass[1] = 3.0
    one, two = (tree_of(each, each.qpos0) for each in (model, other))
    assert list(list_load_differences(one, two)) == [
        "x has 1 kg instead of 3 kg",
        "the damping of h is 0.5 instead of 0 N m s/rad",
        "the damping of joint 1 is 0.25 instead of 0 N s/m",
    ]


# -- ranges ------------------------------------------------------------------------------------------------------------


def test_joints_outside_ranges_are_named_and_moved_inside() -> None:
    ranged = four_bar(frame="").replace('name="rocker" axis="0 0 1"', 'name="rocker" axis="0 0 1" range="-3 0"')
    angle = start_angles(GRASHOF, 1.0)[2]
    assert angle > 0.0
    machine = driven(ranged, {"crank": "60rpm"}, 0.01)
    degrees = math.degrees(angle)
    assert outside_words(machine.tree, "its own pose") == (
        f"its own pose has rocker at {degrees:.4g} deg, outside its range -171.9 to 0 deg"
    )
    assert [joint.name for joint in joints_outside(machine.tree, machine.tree.start)] == ["rocker"]
    for value, is_outside in ((-3.0, False), (0.0, False), (-3.0 - 2e-9, True), (2e-9, True)):
        assert bool(list(joints_outside(machine.tree, np.array([1.0, 0.0, value])))) is is_outside
    inside = closed_pose_inside(machine)
    assert inside is not None
    # The other branch, with the crank where it is.
    right = np.array(start_angles(GRASHOF, 1.0, -1.0))
    assert np.exp(1j * inside[:, 0]) == pytest.approx(np.exp(1j * right), abs=1e-9)
    assert not is_folded(machine, inside)
    plain = driven(four_bar(frame=""), {"crank": "60rpm"}, 0.01)
    assert outside_words(plain.tree, "its own pose") == ""


def test_nearest_pose_inside_moves_what_must_move_alone() -> None:
    """The leg's swing and its ankle are inside their ranges, and no length of the leg asks anything of them."""
    model = mujoco.MjModel.from_xml_path(str(CASES / "folded-leg.xml"))
    machine = DrivenTree(tree_of(model, model.qpos0), {})
    inside = closed_pose_inside(machine)
    assert inside is not None
    swing, length, ankle, femur, knee = inside[:, 0]
    assert [swing, ankle] == pytest.approx([0.0, 0.0], abs=1e-9)
    # Thigh and shin of 0.36 m form an isosceles triangle; its shape is the one nearest to the ends of the ranges.
    shapes = np.radians(np.linspace(10.0, 75.0, 200_001))
    turns = (shapes - np.radians(10.0)) ** 2 + (2.0 * shapes - np.pi + np.radians(10.0)) ** 2
    nearest = shapes[int(np.argmin((0.72 * np.cos(shapes) - 0.12) ** 2 + 0.36**2 * turns))]
    assert [femur, knee] == pytest.approx([nearest, 2.0 * nearest - np.pi], abs=1e-5)
    assert length == pytest.approx(0.72 * np.cos(femur), abs=1e-12)


SLIDER_CRANK = """<mujoco><worldbody>
  <body><joint name="crank" axis="0 0 1"/><geom size="0.01" mass="1"/><body name="rod" pos="0 0.1 0">
    <joint name="pin" axis="0 0 1"/><geom size="0.01" pos="0.1 0 0" mass="1"/></body></body>
  <body name="slider" pos="0.3 0 0"><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.01" mass="1"/></body>
</worldbody><equality><connect body1="rod" body2="slider" anchor="0.3 -0.1 0"/></equality></mujoco>"""


def test_hinges_without_a_range_are_tried_all_round(monkeypatch: pytest.MonkeyPatch) -> None:
    machine, tried = driven(SLIDER_CRANK, {"crank": "60rpm"}, 0.01), list[Array]()

    def close_loops(guess: Array, time: float) -> Any:
        tried.append(guess[:, 0])
        raise InvalidInput("open")

    monkeypatch.setattr(machine, "close_loops", close_loops)
    assert closed_pose_inside(machine) is None
    # One that leads to no closed pose stops none of the others.
    assert len(tried) == RANDOM_POSES
    hinges, slide = np.array(tried)[:, :2], np.array(tried)[:, 2]
    assert np.abs(hinges).max() <= math.pi
    assert np.ptp(hinges, axis=0).min() > math.pi
    # Nobody knows how far a slide could go.
    assert slide.tolist() == [0.0] * RANDOM_POSES


# -- starts and causes -------------------------------------------------------------------------------------------------


def test_an_open_start_has_its_gaps_and_the_nearest_closed_pose() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar(frame=""))
    data = mujoco.MjData(model)
    assert open_start(model, data, 0.35, "its own pose") is None
    data.qpos[2] += 0.01
    before = data.qpos.copy()
    found = open_start(model, data, 0.35, "keyframe k")
    assert found is not None
    assert (found.pose, found.extent, found.worst) == ("keyframe k", 0.35, "pin")
    assert found.gaps["pin"] == pytest.approx(2 * 0.3 * math.sin(0.005))
    assert len(found.closed.split()) == 3
    assert data.qpos.tolist() == before.tolist()
    assert pose_words(np.array([-1e-14, 1.0 / 3.0, -2.0])) == "0 0.3333333333 -2"


def test_open_start_has_a_closed_pose_when_model_is_in_mm() -> None:
    metres = mujoco.MjModel.from_xml_string(four_bar(frame=""))
    millimetres = mujoco.MjModel.from_xml_string(four_bar((100.0, 250.0, 300.0, 350.0), frame=""))
    poses = []
    for model, extent in ((metres, 0.35), (millimetres, 350.0)):
        data = mujoco.MjData(model)
        data.qpos[2] += 0.01
        found = open_start(model, data, extent, "its own pose")
        assert found is not None
        assert found.gaps["pin"] / extent == pytest.approx(2 * 0.3 * math.sin(0.005) / 0.35)
        poses.append([float(value) for value in found.closed.split()])
    assert len(poses[0]) == 3
    assert poses[1] == pytest.approx(poses[0], abs=1e-8)


def test_rates_that_open_a_loop_are_compared_with_required_rates() -> None:
    machine = driven(four_bar(frame=""), {"crank": "60rpm"}, 0.01)
    model = mujoco.MjModel.from_xml_string(four_bar(frame=""))
    data, right = mujoco.MjData(model), machine.motion(np.zeros(1)).rates[0, :, 0]
    data.qvel[:] = right
    assert start_rate_violation(machine, data) is None
    data.qvel[2] += 0.5
    found = start_rate_violation(machine, data)
    assert found is not None
    assert (found.joint, found.unit) == ("rocker", "rad/s")
    assert found.found == pytest.approx(right[2] + 0.5)
    assert 0.0 < found.opening <= 0.5 * 0.3


SLIDER = """<mujoco><worldbody><body><joint name="crank" axis="0 0 1"/><geom size="0.01"/>
<body pos="0 0.3 0"><joint name="rod" axis="0 0 1"/><geom size="0.01"/><site name="end" pos="0.4 -0.3 0"/></body></body>
<body pos="0.4 0 0"><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.01"/><site name="pin"/></body>
</worldbody>
<equality><connect name="pin" site1="end" site2="pin"/></equality></mujoco>"""


def test_rate_of_a_slide_that_opens_a_loop_is_a_speed() -> None:
    # The crank, upright, moves the rod's end by 0.3 w: the rod of 0.5 m does not rotate then.
    machine, model = driven(SLIDER, {"crank": "60rpm"}, 0.01), mujoco.MjModel.from_xml_string(SLIDER)
    data = mujoco.MjData(model)
    assert start_rate_violation(machine, data) is None  # at rest
    data.qvel[:] = 1.0, -1.0, 0.2
    found = start_rate_violation(machine, data)
    assert found is not None
    assert (found.joint, found.unit) == ("slide", "m/s")
    assert (found.found, found.asked) == (0.2, pytest.approx(-0.3))
    assert found.opening == pytest.approx(0.5)


def test_causes_take_the_place_of_a_guess(tmp_path: Path) -> None:
    assert append_causes("it stops") == append_causes("it stops", "", "stops") == "it stops"
    assert append_causes("it stops", "a", "", "b") == "it stops; a; b"
    assert append_causes(f"it stops: {NO_FURTHER} here", "one", "two") == "it stops: one; two here"
    path = tmp_path / "bar.xml"
    path.write_text(four_bar(closure='active="false"'), encoding="utf-8")
    words = 'closure pin is inactive (active="false")'
    assert describe_closures(mujoco.MjModel.from_xml_path(str(path))) == words
    with pytest.raises(InvalidInput) as told, add_causes_to_errors(path, lambda model: [f"{model.nv} joints"]):
        raise InvalidInput("no")
    assert str(told.value) == f"no; {words}; 3 joints"
    path.write_text("<", encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"^no$"), add_causes_to_errors(path):
        raise InvalidInput("no")


def test_closures_are_described_in_turn_when_several_are_odd() -> None:
    text = (CASES / "mocap-weld.xml").read_text(encoding="utf-8")
    handle = "hold is a handle: it drags hand after the mocap body handle"
    assert describe_closures(mujoco.MjModel.from_xml_string(text)) == handle
    off = '<connect name="loose" body1="fore" anchor="0 0 0" active="false"/></equality>'
    both = mujoco.MjModel.from_xml_string(text.replace("</equality>", off))
    assert describe_closures(both) == f'closure loose is inactive (active="false"); {handle}'


def test_parts_apart_are_said_with_their_cure() -> None:
    pin = PartsApart("pin", "connect", "b", "a", 0.3314, ("s", "t"))
    assert pin.words == "pin holds b at a point 331 mm from its nearest geom: the parts do not meet"
    assert pin.cure == 'connect sites: site1="s" site2="t"'
    weld = replace(pin, kind="weld", sites=())
    assert weld.words == "pin holds b 331 mm apart from a: the parts do not meet"
    assert weld.cure == "put a site on each of the two parts, where they meet, and connect the sites"


def test_names_are_listed_up_to_six_and_starts_with_inputs() -> None:
    assert list_names("abcdef") == "a, b, c, d, e, f"
    assert list_names("abcdefgh") == "a, b, c, d, e, f and 2 more"
    assert list_names("abc", 2) == "a, b and 1 more"
    motors = '<actuator><motor name="m" joint="crank"/><motor joint="rocker"/></actuator>'
    model = mujoco.MjModel.from_xml_string(four_bar(more=motors, keys='<key/><key name="k"/>'))
    assert start_words(model, None, (0.0, 0.0)) == "its own pose"
    assert start_words(model, 0, (4.19, -0.5)) == "keyframe 0 with m = 4.19, 1 = -0.5"
    assert start_words(model, 1, (0.0, 2.0)) == "keyframe k with 1 = 2"
    assert start_words(model, 1) == "keyframe k"
