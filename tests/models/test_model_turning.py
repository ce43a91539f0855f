"""A user's model is turned, scanned and described as closed forms have it, and refused with what is wrong."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from four_bars import GRASHOF, four_bar, key, rocker_pin, start_angles

from conrod.errors import InvalidInput
from conrod.mjcf.request import ModelRequest, PointPlace
from conrod.models.check.scanning import _shape_error, model_facts, sampled_times, scan
from conrod.models.check.turning import NUDGE_SIZE, TURN_SAMPLES, Turning, prepare_turning
from conrod.scenes.space import MACHINES

B = PointPlace("tip", "site", "B")
ASKED = ModelRequest("crank", (B,), 1, 0)
TURN = 2.0 * math.pi
# A rocker of 0.1 m in the place of the crank: it swings.
SWINGING = (0.3, 0.25, 0.1, 0.35)


def turning_of(folder: Path, text: str, asked: ModelRequest = ASKED) -> Turning:
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    return prepare_turning(path, asked)


def flat(**given: Any) -> str:
    return four_bar(frame="", **given)


# -- turning -----------------------------------------------------------------------------------------------------------


def test_crank_turns_from_assembly_as_exact_four_bar(tmp_path: Path) -> None:
    turning = turning_of(tmp_path, flat())
    assert (turning.crank.name, turning.first, turning.touching, turning.reach) == ("crank", 1.0, None, None)
    assert [(point.name, point.kind) for point in turning.points] == [("tip", "site")]
    for coordinate in (1.0, 2.5, 0.5):
        time = turning.time_at(coordinate)
        assert time == pytest.approx((coordinate - 1.0) % TURN)
        coordinates, rates = turning.state(time)
        angles = np.array(start_angles(GRASHOF, coordinate))
        assert np.exp(1j * coordinates) == pytest.approx(np.exp(1j * angles), abs=1e-9)
        ahead, behind = (np.array(start_angles(GRASHOF, coordinate + d)) for d in (1e-5, -1e-5))
        # Positive about the hinge, at 1 rad/s.
        assert rates == pytest.approx((ahead - behind) / 2e-5, abs=1e-7)
    assert turning.coordinates(np.array([0.0, 1.5]))[0] == pytest.approx([1.0, 2.5])


@pytest.mark.parametrize(("keyframe", "crank"), [(None, 1.0), ("qpos0", 1.0), ("far", 2.0), ("1", 2.0)])
def test_model_is_assembled_in_first_closed_or_requested_pose(
    keyframe: str | None, crank: float, tmp_path: Path
) -> None:
    keys = key("near", GRASHOF, 1.2, 1.0) + key("far", GRASHOF, 2.0, -1.0)
    turning = turning_of(tmp_path, flat(keys=keys), replace(ASKED, keyframe=keyframe))
    assert turning.first == crank
    branch = 1.0 if crank == 1.0 else -1.0
    assert turning.start[:, 0] == pytest.approx(start_angles(GRASHOF, crank, branch), abs=1e-9)


@pytest.mark.parametrize(("edit", "refusal"), [
    (("<equality>", "<equality><!--"), None),
    (('site2="C" ', 'site2="C" active="false" '), 'closure pin is inactive (active="false")'),
])  # fmt: skip
def test_a_model_of_more_freedoms_is_refused_with_what_can_move(
    edit: tuple[str, str], refusal: str | None, tmp_path: Path
) -> None:
    text = flat().replace(*edit).replace("</equality>", "--></equality>" if refusal is None else "</equality>")
    with pytest.raises(InvalidInput) as told:
        turning_of(tmp_path, text)
    assert str(told.value) == (
        "its mobility is 3 (3 degrees of freedom of its joints, of which its closures take 0), that of the machine "
        f"is 1: with the crank held, coupler, rocker can still move; {refusal or 'is a closure missing?'}"
    )
    with pytest.raises(InvalidInput, match=r"machine is 1, or 2 where it is closed by contact: with"):
        turning_of(tmp_path, text, replace(ASKED, contacts=1))


def test_model_is_refused_when_stuck_or_without_that_crank(tmp_path: Path) -> None:
    pinned = flat().replace("</equality>", '<connect site1="A" body2="world"/></equality>')
    pinned = pinned.replace('<body name="frame" >', '<body name="frame"><site name="W"/>')
    pinned = pinned.replace('site1="A" body2="world"', 'body1="coupler" body2="world" anchor="0 0 0"')
    with pytest.raises(InvalidInput, match="cannot move"):
        turning_of(tmp_path, pinned)
    for asked, words in {
        "shaft": "unknown joint 'shaft'",
        "": "unknown joint ''",
    }.items():
        with pytest.raises(InvalidInput, match=words):
            turning_of(tmp_path, flat(), replace(ASKED, crank=asked))
    with pytest.raises(InvalidInput, match="unknown site 'E'"):
        turning_of(tmp_path, flat(), replace(ASKED, places=(PointPlace("tip", "site", "E"),)))
    with pytest.raises(InvalidInput, match="unknown keyframe 'low'"):
        turning_of(tmp_path, flat(), replace(ASKED, keyframe="low"))


# -- one pass ----------------------------------------------------------------------------------------------------------


def test_a_pass_is_all_that_the_crank_can_travel_to_either_side(tmp_path: Path) -> None:
    asked = replace(ASKED, span=(0.0, 0.4))
    turning = turning_of(tmp_path, flat(lengths=SWINGING, crank=0.7), asked)
    assert turning.reach is not None
    back, ahead = turning.reach
    # The limits: |pin - (0.35, 0)| between 0.15 m and 0.35 m, so that cos q >= (0.3^2 + 0.35^2 - 0.35^2) / 0.21.
    low, high = (math.acos((0.3**2 + 0.35**2 - far**2) / (2 * 0.3 * 0.35)) for far in (0.15, 0.35))
    assert low < 0.7 < high
    assert ahead == pytest.approx(0.4, abs=1e-9)
    assert back == pytest.approx(0.7 - low, abs=0.01)
    assert turning.first == pytest.approx(0.7 - back, abs=1e-9)
    assert turning.time_at(0.7) == pytest.approx(back, abs=1e-9)
    assert (turning.time_at(-9.0), turning.time_at(9.0)) == (0.0, pytest.approx(back + ahead))
    # Angles are those of the file.
    assert turning.state(back)[0] == pytest.approx(start_angles(SWINGING, 0.7), abs=1e-9)
    with pytest.raises(InvalidInput) as told:
        turning_of(tmp_path, flat(lengths=SWINGING, crank=0.7), replace(ASKED, span=(0.0, 1.0)))
    words = str(told.value)
    assert words.startswith("its crank goes from ")
    assert words.endswith(" deg: the pass of the machine takes 57.296 deg")
    ends = [float(part.split()[0]) for part in words.replace(" to ", " from ").split(" from ")[1:]]
    # Kept off both ends by a hundredth of the pass.
    assert ends == pytest.approx([math.degrees(low) + 0.57, math.degrees(high) - 0.57], abs=0.6)


def test_a_pass_is_sampled_at_its_start_and_evenly(tmp_path: Path) -> None:
    asked = replace(ASKED, span=(0.0, 0.36))
    turning = turning_of(tmp_path, flat(), asked)
    assert turning.reach == (pytest.approx(0.36), pytest.approx(0.36))
    times = sampled_times(turning, asked)
    assert len(times) == 2 * TURN_SAMPLES + 1
    assert np.diff(times) == pytest.approx(0.002)
    assert times[TURN_SAMPLES] == pytest.approx(0.36)
    # Where neither side has all of it, from the beginning.
    for reach, count, first in (((0.1, 0.2), TURN_SAMPLES + 1, 0.0), ((0.0, 0.36), TURN_SAMPLES + 1, 0.0),
                                ((0.101, 0.36), 50 + TURN_SAMPLES + 1, 0.001)):  # fmt: skip
        times = sampled_times(replace(turning, reach=reach), asked)
        assert (len(times), times[0]) == (count, pytest.approx(first, abs=1e-12))
    assert times[-1] == pytest.approx(0.461)
    whole = sampled_times(replace(turning, reach=None), asked)
    assert (len(whole), whole[0], whole[-1]) == (TURN_SAMPLES + 1, 0.0, TURN)


# -- contact -----------------------------------------------------------------------------------------------------------

# A round cam of radius 0.05 m, 0.02 m off its shaft, and a round follower of 0.01 m on a slide through the shaft.
CAM = """<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody>
  <body name="cam"><joint name="crank" axis="0 0 1"/><geom name="cam" size="0.05" pos="0.02 0 0" {cam}/>
    <geom name="hub" size="0.001" contype="0" conaffinity="0"/></body>
  <body name="follower" pos="{place} 0 0"><joint name="slide" type="slide" axis="1 0 0"/><geom name="ball" size="0.01"
    {ball}/></body><geom name="wall" size="0.01" pos="1 0 0"/></worldbody>{more}</mujoco>"""
LIFT = ModelRequest("crank", (PointPlace("P", "body", "follower"),), 1, 1)


def cam(cam: str = "", ball: str = "", more: str = "", place: float = 0.085) -> str:
    return CAM.format(cam=cam, ball=ball, more=more, place=place)


def lift(angle: float) -> float:
    """Place of the follower [m]: its centre is 0.06 m from the cam's."""
    return 0.02 * math.cos(angle) + math.sqrt(0.06**2 - (0.02 * math.sin(angle)) ** 2)


def test_a_follower_is_where_it_touches_its_cam(tmp_path: Path) -> None:
    turning = turning_of(tmp_path, cam(), LIFT)
    names = [turning.model.geom(geom).name for geom in turning.touching or ()]
    assert names == ["cam", "ball"]
    times = np.linspace(0.0, 1.0, 30)
    found = turning.coordinates(times)
    assert found[0] == pytest.approx(times)
    assert 0.085 + found[1] == pytest.approx([lift(time) for time in times], abs=1e-9)
    coordinates, rates = turning.state(0.5)
    assert coordinates == pytest.approx([0.5, lift(0.5) - 0.085], abs=1e-9)
    assert rates == pytest.approx([1.0, (lift(0.5 + 1e-5) - lift(0.5 - 1e-5)) / 2e-5], abs=1e-6)


@pytest.mark.parametrize(("parts", "touching"), [
    ({"ball": 'contype="2" conaffinity="2"', "cam": 'contype="2" conaffinity="0"'}, True),
    ({"ball": 'contype="2" conaffinity="0"', "cam": 'contype="0" conaffinity="2"'}, True),
    ({"ball": 'contype="2" conaffinity="0"', "cam": 'contype="2" conaffinity="0"'}, False),
    ({"ball": 'contype="0" conaffinity="2"', "cam": 'contype="1" conaffinity="1"'}, False),
    ({"ball": 'contype="0" conaffinity="0"', "cam": 'contype="0" conaffinity="0"',
      "more": '<contact><pair geom1="ball" geom2="cam"/></contact>'}, True),
])  # fmt: skip
def test_a_cam_touches_what_it_may_collide_with(parts: dict[str, str], touching: bool, tmp_path: Path) -> None:
    if touching:
        turning = turning_of(tmp_path, cam(**parts), LIFT)
        assert [turning.model.geom(geom).name for geom in turning.touching or ()] == ["cam", "ball"]
        return
    with pytest.raises(InvalidInput, match=r"^nothing that turns with the crank may collide with what it is to move$"):
        turning_of(tmp_path, cam(**parts), LIFT)


def test_a_follower_that_its_cam_does_not_reach_is_refused(tmp_path: Path) -> None:
    aside = cam().replace('pos="0.085 0 0"', 'pos="0.085 0.5 0"')
    turning = turning_of(tmp_path, aside, LIFT)
    with pytest.raises(InvalidInput, match=r"^cam and ball cannot be brought to touch .*crank"):
        turning.coordinates(np.array([0.25]))


@pytest.mark.parametrize("share", [1.0, -1.0, 1.001])
def test_follower_touches_when_no_farther_than_a_nudge(
    share: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    turning = turning_of(tmp_path, cam(), LIFT)
    nudge = NUDGE_SIZE * float(turning.model.stat.extent)
    monkeypatch.setattr("conrod.models.check.turning.distance", lambda *_: share * nudge)
    if abs(share) > 1.0:
        with pytest.raises(InvalidInput, match=r"^cam and ball cannot be brought to touch "):
            turning.coordinates(np.array([0.25]))
        return
    assert turning.coordinates(np.array([0.25]))[0] == pytest.approx([0.25])


def test_cam_scan_names_contact_and_travel_of_follower(tmp_path: Path) -> None:
    text = cam().replace('type="slide" axis="1 0 0"', 'type="slide" axis="1 0 0" range="-0.03 9"')
    found = scan(turning_of(tmp_path, text, LIFT), LIFT)
    assert found.facts.touching == ("cam", "ball")
    assert (found.facts.coordinates, found.facts.rank, found.facts.joints) == (2, 0, {"hinge": 1, "slide": 1})
    # From 0.04 m to 0.08 m from the shaft.
    assert found.facts.stops == ("slide is held to -0.03 to 9 units of length, needs -0.045 to -0.005",)


def test_cam_scan_numbers_geoms_that_have_no_name(tmp_path: Path) -> None:
    text = cam().replace(' name="cam" size', " size").replace(' name="ball"', "").replace(' name="hub"', "")
    assert scan(turning_of(tmp_path, text, LIFT), LIFT).facts.touching == ("geom 1", "geom 3")


# -- scanning ----------------------------------------------------------------------------------------------------------


def test_a_scan_has_paths_angles_and_facts_of_one_turn(tmp_path: Path) -> None:
    text = flat(keys=key("start", GRASHOF, 1.0, 1.0).replace("/>", ' qvel="1 0 0"/>'), option='integrator="RK4"')
    motors = '<actuator><motor name="m" joint="crank"/><motor joint="rocker"/></actuator></mujoco>'
    text = text.replace("<mujoco>", '<mujoco model="my bar">').replace("</mujoco>", motors)
    asked = replace(ASKED, places=(B, PointPlace("rod", "body", "coupler")), controls=(("m", 0.5),))
    found = scan(turning_of(tmp_path, text, asked), asked)
    angles = 1.0 + np.arange(TURN_SAMPLES) * TURN / TURN_SAMPLES
    assert found.coordinate == pytest.approx(angles)
    assert found.points == ("tip", "rod")
    assert found.positions.shape == (2, TURN_SAMPLES, 3)
    pins = np.array([[*rocker_pin(GRASHOF, angle), 0.0] for angle in angles])
    assert found.positions[0] == pytest.approx(pins, abs=1e-9)
    assert found.positions[1][:, :2] == pytest.approx(0.1 * np.array([np.cos(angles), np.sin(angles)]).T, abs=1e-12)
    # Both points are on the coupler, which turns about the crank's axis by so much since the first sample.
    coupler = np.unwrap([sum(start_angles(GRASHOF, angle)[:2]) for angle in angles])
    assert found.turns == pytest.approx(np.array([coupler - coupler[0]] * 2), abs=1e-9)
    assert found.anchor == pytest.approx([0.0, 0.0, 0.0])
    assert found.axis == pytest.approx([0.0, 0.0, 1.0])
    assert found.wander < 1e-12
    assert found.shape_error == 0.0
    facts = found.facts
    assert (facts.name, facts.engine_version) == ("my bar", mujoco.__version__)
    assert (facts.joints, facts.closures) == ({"hinge": 3}, {"connect": 1})
    assert (facts.coordinates, facts.rank, facts.touching, facts.timestep) == (3, 2, None, 0.001)
    assert facts.settings == "timestep 0.001 s, integrator RK4, solver NEWTON, 100 iterations, tolerance 1e-08"
    assert facts.start == "keyframe start with m = 0.5"
    assert facts.controls == {"m": 0.5, "1": 0.0}
    assert (facts.begins, facts.about, facts.from_keyframe, facts.moves, facts.stops) == (None, "", True, True, ())
    assert facts.rates is not None  # the crank's alone opens the pin
    assert facts.rates.found in (0.0, 1.0)
    assert facts.rigid == ("rod",)  # at the crank's pin


def test_facts_of_a_start_are_those_of_the_file(tmp_path: Path) -> None:
    text = flat(keys=key("open", GRASHOF, 1.0, 1.0).replace('qpos="1.0 ', 'qpos="1.1 '))
    turning = turning_of(tmp_path, text)
    facts = model_facts(turning, ASKED)
    assert facts.begins is not None
    assert (facts.begins.pose, list(facts.begins.gaps), facts.rates) == ("keyframe open", ["pin"], None)
    own = model_facts(turning, replace(ASKED, keyframe="qpos0"))
    assert (own.begins, own.from_keyframe, own.moves, own.start, own.rates) == (
        None,
        False,
        False,
        "its own pose",
        None,
    )
    handle = '<body name="hand" mocap="true"/></worldbody>'
    grip = '<connect name="off" body1="rocker" body2="crank" anchor="0 0 0" active="false"/></equality>'
    other = flat().replace("</worldbody>", handle).replace("</equality>", grip)
    assert model_facts(turning_of(tmp_path, other), ASKED).about == 'closure off is inactive (active="false")'


def test_limits_are_named_with_needed_range_when_they_stop_turn(tmp_path: Path) -> None:
    rocker = [start_angles(GRASHOF, 1.0 + k * TURN / TURN_SAMPLES)[2] for k in range(TURN_SAMPLES)]
    low, high = min(rocker), max(rocker)
    joint = '<joint name="rocker" axis="0 0 1"'

    def stops(rocker: str = "", crank: str = "", more: str = "", flag: str = "") -> tuple[str, ...]:
        text = flat(joint=crank).replace(joint, f"{joint} {rocker}").replace("</mujoco>", f"{more}</mujoco>")
        return scan(turning_of(tmp_path, text.replace("<flag ", f"<flag {flag} ")), ASKED).facts.stops

    needs = f"needs {math.degrees(low):.6g} to {math.degrees(high):.6g}"
    held = f'range="{low + 0.01} {high + 0.01}"'
    ends = f"{math.degrees(low + 0.01):.6g} to {math.degrees(high + 0.01):.6g}"
    assert stops(held) == (f"rocker is held to {ends} deg, {needs}",)
    upper = f'range="{low - 0.01} {high - 0.01}"'
    assert len(stops(upper)) == 1
    assert stops(f'range="{low - 0.01} {high + 0.01}"') == ()
    assert stops(held, flag='limit="disable"') == ()
    assert stops(crank='range="-3 3"') == ("crank is held to -171.887 to 171.887 deg, needs a full turn",)
    assert stops(crank='range="0 6.2831853071795864"') == ()
    tendon = '<tendon><fixed name="t" range="{}"><joint joint="rocker" coef="2"/></fixed></tendon>'
    assert stops(more=tendon.format(f"{2 * low + 0.1} 9")) == (
        f"tendon t is held to {2 * low + 0.1:.6g} to 9, needs {2 * low:.6g} to {2 * high:.6g}",
    )
    assert stops(more=tendon.format("-9 9")) == ()


def test_limits_before_a_pass_do_not_stop_it(tmp_path: Path) -> None:
    asked = replace(ASKED, span=(0.0, 0.36))
    rocker = [start_angles(GRASHOF, 1.8 + 0.36 * k / TURN_SAMPLES)[2] for k in range(TURN_SAMPLES + 1)]
    joint = '<joint name="rocker" axis="0 0 1"'

    def stops(low: float, high: float) -> tuple[str, ...]:
        text = flat(crank=1.8).replace(joint, f'{joint} range="{low!r} {high!r}"')
        turning = turning_of(tmp_path, text, asked)
        assert turning.reach == (pytest.approx(0.36), pytest.approx(0.36))  # it can go as far back
        return scan(turning, asked).facts.stops

    least, most = min(rocker) - 1e-6, max(rocker) + 1e-6
    before = start_angles(GRASHOF, 1.8 - 0.36)[2]
    assert not least <= before <= most
    assert stops(least, most) == ()
    assert len(stops(least, most - 0.01)) == len(stops(least + 0.01, most)) == 1


@pytest.mark.parametrize("corners", [12, 40])
def test_a_shape_is_off_by_the_depth_of_its_facets(corners: int) -> None:
    angles = np.arange(corners) * TURN / corners
    places = " ".join(f"{0.1 * math.cos(a):.9g} {0.1 * math.sin(a):.9g} {z}" for a in angles for z in (-0.01, 0.01))
    text = f"""<mujoco><asset><mesh name="m" vertex="{places}"/></asset><worldbody><geom type="mesh" mesh="m"/>
      <geom size="0.1"/></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    # R (1 - cos(pi / n)), and what single precision leaves of R.
    depth = 0.1 * (1.0 - math.cos(math.pi / corners))
    assert _shape_error(model, 0, np.array([0.0, 0.0, 1.0])) == pytest.approx(depth + 1.19e-8, rel=1e-4)
    assert _shape_error(model, 1, np.array([0.0, 0.0, 1.0])) == 0.0


def test_undeclared_point_is_refused_when_it_does_not_return(tmp_path: Path) -> None:
    assert "rssr" in MACHINES
    # A wheel on a rack: after a turn it is 2 pi 0.1 m away.
    text = """<mujoco><compiler angle="radian"/><worldbody><body name="w"><joint name="x" type="slide" axis="1 0 0"/>
      <joint name="crank" axis="0 0 1"/><geom size="0.1"/></body></worldbody>
      <equality><joint joint1="x" joint2="crank" polycoef="0 -0.1 0 0 0"/></equality></mujoco>"""
    asked = ModelRequest("crank", (PointPlace("W", "body", "w"),), 1, 0)
    turning = turning_of(tmp_path, text, asked)
    with pytest.raises(InvalidInput, match=r"^after one turn of its crank a point is 0\.628 away from where it was$"):
        scan(turning, asked)
    found = scan(turning, replace(asked, returns=False))
    assert found.positions[0, :, 0] == pytest.approx(-0.1 * found.coordinate)
    # The hinge goes along with the wheel.
    assert found.wander == pytest.approx(0.1 * TURN * (TURN_SAMPLES - 1) / TURN_SAMPLES)
