"""A cam by its equivalent linkage: exact geometry, full order in both engines, and what it cannot show."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, CAMS, CAMS_WITH_JOINTS, PRESS

from conrod import Comparison, InvalidInput, Outcome, Trajectory, compare, run
from conrod.engines import ENGINES, engine_named
from conrod.engines.linkage_legs import legs, shared_steps
from conrod.engines.mujoco import linkage_run as mujoco_run
from conrod.engines.pymunk import linkage_run as pymunk_run
from conrod.exact.equivalent_linkage import EQUIVALENT_LINKAGE, ArcLinkage, EquivalentLinkage, equivalent_linkage
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.mechanism import Mechanism, Prismatic, Revolute
from conrod.runs.trajectory import joined
from conrod.scenes import CamFollower
from conrod.studies.frame.cell import Cell

TURN = 2.0 * math.pi
DEGREE = math.pi / 180.0
QUANTITIES = ("position", "velocity", "acceleration")
ANGLES = np.linspace(-7.0, 14.0, 2101)


def lift_error(linkage: EquivalentLinkage, cam: Any) -> float:
    """Largest error of the roller's way [m]; the scene's closed form knows nothing of linkages."""
    exact = cam.motion(ANGLES, 1.0).point("roller").position[:, 1]
    return float(np.abs(linkage.travel(ANGLES) - exact).max())


# -- geometry --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CAMS)
def test_the_roller_moves_as_the_linkages_move_it(name: str) -> None:
    assert lift_error(equivalent_linkage(CAMS[name].mechanism()), CAMS[name]) < 1e-15


@pytest.mark.parametrize("name", CAMS_WITH_JOINTS)
def test_linkages_take_turns_at_the_joints_of_the_arcs(name: str) -> None:
    linkage = equivalent_linkage(CAMS[name].mechanism())
    np.testing.assert_allclose([arc.start for arc in linkage.arcs], CAMS[name].break_angles(), rtol=0.0, atol=1e-14)
    assert sum(arc.extent for arc in linkage.arcs) == pytest.approx(TURN, rel=1e-15)
    assert [arc.dwells for arc in linkage.arcs] == [False, False, False, True]
    assert linkage.arcs[3].crank == 0.0


def test_a_cam_that_is_one_circle_is_one_slider_crank() -> None:
    (arc,) = equivalent_linkage(CAMS["cam-36-72.5"].mechanism()).arcs
    assert (arc.start, arc.stop) == (0.0, TURN)
    assert arc.crank == pytest.approx(0.0365, rel=1e-14)


@pytest.mark.parametrize("index", range(4))
def test_each_linkage_has_the_cams_velocity_and_acceleration(index: int) -> None:
    arc = equivalent_linkage(CAM.mechanism()).arcs[index]
    angles = np.linspace(arc.start, arc.stop, 9)[1:-1]
    linkage = Kinematics(arc.mechanism)
    _, velocity, acceleration = linkage.derivatives(angles - arc.middle, 2)
    exact = CAM.motion(angles, 1.0).point("roller")
    follower = 3 * arc.mechanism.body_index["follower"] + 1
    np.testing.assert_allclose(velocity[:, follower], exact.velocity[:, 1], rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(acceleration[:, follower], exact.acceleration[:, 1], rtol=0.0, atol=1e-13)


def turned(mechanism: Mechanism, sense: int, offset: float, direction: float) -> Mechanism:
    """The same cam elsewhere, its slide beside the shaft and in another direction, turning the other way."""
    shaft, start = (0.3, -0.2), 0.7
    dx, dy = math.cos(direction), math.sin(direction)
    foot = shaft[0] - offset * dy, shaft[1] + offset * dx
    reach = math.sqrt(0.045**2 - offset**2)
    guide = Prismatic("guide", "ground", "follower", foot, (0.0, 0.0), direction)
    joints = (Revolute("shaft", "ground", "cam", shaft, (0.0, 0.0)), guide, mechanism.joints[2])
    # At crank angle 0 the roller is on the base circle: the middle of the dwell is turned to it.
    turn = math.atan2(offset, reach) + direction + math.pi
    return replace(
        mechanism,
        joints=joints,
        driver=replace(mechanism.driver, sense=sense, start=turn + start),
        poses={"cam": (*shaft, turn + start), "follower": (foot[0] + reach * dx, foot[1] + reach * dy, 0.0)},
    )


@pytest.mark.parametrize(("sense", "offset", "direction"), [(1, 0.01, math.pi / 2), (-1, -0.008, 0.4), (-1, 0.0, 3.0)])
def test_an_offset_slide_and_the_other_sense_are_no_matter(sense: int, offset: float, direction: float) -> None:
    mechanism = turned(CAM.mechanism(), sense, offset, direction)
    linkage, kinematics = equivalent_linkage(mechanism), Kinematics(mechanism)
    poses = kinematics.poses(ANGLES)[:, 3:5]
    foot = np.array([0.3 - offset * math.sin(direction), -0.2 + offset * math.cos(direction)])
    along = (poses - foot) @ np.array([math.cos(direction), math.sin(direction)])
    np.testing.assert_allclose(linkage.travel(ANGLES), along, rtol=0.0, atol=1e-14)
    for arc in linkage.arcs:
        start = np.array([arc.mechanism.poses[body.name] for body in arc.mechanism.bodies]).ravel()
        np.testing.assert_allclose(Kinematics(arc.mechanism).start[0], start, rtol=0.0, atol=1e-14)


def in_wrong_order(linkage: EquivalentLinkage) -> EquivalentLinkage:
    """The flanks change places: each where the other one should be."""
    rising, nose, falling, dwell = linkage.arcs
    swapped = (between(falling, rising.start, rising.stop), nose, between(rising, falling.start, falling.stop), dwell)
    return replace(linkage, arcs=swapped)


def between(arc: ArcLinkage, start: float, stop: float) -> ArcLinkage:
    turn = 0.5 * (start + stop) - arc.middle
    driver = arc.mechanism.driver
    mechanism = replace(arc.mechanism, driver=replace(driver, start=driver.start + driver.sense * turn))
    return replace(arc, start=start, stop=stop, mechanism=mechanism)


def switched_late(linkage: EquivalentLinkage) -> EquivalentLinkage:
    """The flank hands over to the nose a degree late."""
    first, second, *others = linkage.arcs
    late = first.stop + DEGREE
    return replace(linkage, arcs=(between(first, first.start, late), between(second, late, second.stop), *others))


@pytest.mark.parametrize(("plant", "least"), [(in_wrong_order, 1e-2), (switched_late, 1e-6)])
def test_a_wrong_order_and_a_late_switch_are_seen(plant: Callable[..., EquivalentLinkage], least: float) -> None:
    linkage = equivalent_linkage(CAM.mechanism())
    assert lift_error(linkage, CAM) < 1e-15
    assert not lift_error(plant(linkage), CAM) < least


def test_a_mechanism_without_such_a_cam_is_refused() -> None:
    with pytest.raises(InvalidInput, match="it has 0 cams"):
        equivalent_linkage(PRESS.mechanism())
    cam = CAM.mechanism()
    pivot = Revolute("pivot", "ground", "follower", (0.0, 0.0), (0.0, 0.0))
    rocking = replace(cam, joints=(cam.joints[0], pivot, cam.joints[2]))
    with pytest.raises(InvalidInput, match="'follower' does not slide in the ground"):
        equivalent_linkage(rocking)


# -- steps -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", [16, 17, 100, 1001, 62832])
@pytest.mark.parametrize("name", CAMS_WITH_JOINTS)
def test_the_steps_of_a_turn_are_shared_among_the_arcs(name: str, turn: int) -> None:
    linkage = equivalent_linkage(CAMS[name].mechanism())
    shared = shared_steps(linkage, turn)
    assert sum(shared) == turn
    assert min(shared) >= 4
    for arc, steps in zip(linkage.arcs, shared, strict=True):
        if steps > 4:
            assert abs(steps - turn * arc.extent / TURN) <= (16 if turn < 100 else 4)


def test_too_few_steps_are_refused() -> None:
    with pytest.raises(InvalidInput, match=r"steps_per_revolution = 15 is too few.* of 4 arcs: at least 16"):
        shared_steps(equivalent_linkage(CAM.mechanism()), 15)


@pytest.mark.parametrize("speed", [1.0, -1.0])
@pytest.mark.parametrize("start", [0.0, 1.3, -9.0])
def test_a_step_ends_at_every_switch(start: float, speed: float) -> None:
    cam: Any = CAM.with_parameters(speed=speed)
    told = list(legs(equivalent_linkage(cam.mechanism()), cam, 100, 350, start))
    assert sum(leg.steps for leg in told) == 350
    for leg, following in pairwise(told):
        end = leg.begin + speed * leg.step * leg.steps
        assert end == pytest.approx(following.begin, abs=1e-12)
        assert min(abs(math.remainder(end - joint, TURN)) for joint in cam.break_angles()) < 1e-12
        assert abs(leg.step / cam.period * 100 - 1.0) < 0.2


# -- engines ---------------------------------------------------------------------------------------------------------


def linkage_settings(engine: str, cam: Any, steps: int) -> Any:
    """As the ingredient of the cam has it: the minimal model without the contact."""
    made = engine_named(engine)
    minimal = made.minimal(cam, steps)
    (ingredient,) = (one for one in made.ingredients(cam, minimal) if one.name == "cam-by-contact")
    return ingredient.removed(minimal)


@cache
def ran(engine: str, cam: Any, steps: int, revolutions: float = 1.0, start: float = 0.0) -> Trajectory:
    return run(cam, linkage_settings(engine, cam, steps), revolutions, start)


@cache
def measured(engine: str, cam: Any, steps: int) -> Comparison:
    trajectory = ran(engine, cam, steps)
    assert trajectory.outcome is Outcome.COMPLETED, trajectory.reason
    return compare(trajectory, cam)


# MuJoCo has the order of its integrator in all three; pymunk's is two, and an acceleration just after a switch comes to
# it from below.
PATHS = {"mujoco": ((100, 200, 400, 800), (3.8, 3.8, 3.8)), "pymunk": ((800, 1600, 3200, 6400), (1.95, 1.85, 1.85))}


@pytest.mark.parametrize("engine", ENGINES)
def test_every_quantity_converges_at_the_order_of_a_linkage(engine: str) -> None:
    path, least = PATHS[engine]
    for quantity, order in zip(QUANTITIES, least, strict=True):
        errors = [measured(engine, CAM, steps).worst(quantity) for steps in path]
        slope = -np.polyfit(np.log(path), np.log(errors), 1)[0]
        assert order < slope < order + 0.5, (quantity, errors)


@pytest.mark.parametrize(("engine", "steps"), [("mujoco", 200), ("pymunk", 12800)])
def test_what_contact_reaches_takes_far_fewer_steps(engine: str, steps: int) -> None:
    # By contact 62832 steps a turn reach 1.2e-6 (MuJoCo) and 1.4e-6 (pymunk) in lift, and no acceleration at all.
    assert measured(engine, CAM, steps).worst("position") < 1.16e-6
    assert measured(engine, CAM, steps).worst("acceleration") < 1e-4


@pytest.mark.parametrize("plant", [in_wrong_order, switched_late])
@pytest.mark.parametrize(("engine", "module"), [("mujoco", mujoco_run), ("pymunk", pymunk_run)])
def test_a_wrong_linkage_is_seen_in_a_run(
    engine: str, module: Any, plant: Callable[..., EquivalentLinkage], monkeypatch: pytest.MonkeyPatch
) -> None:
    right = measured(engine, CAM, 800)
    monkeypatch.setattr(module, "equivalent_linkage", lambda mechanism: plant(equivalent_linkage(mechanism)))
    wrong = run(CAM, linkage_settings(engine, CAM, 800), 1.0)
    # The rods pull the roller through the cam, off it, or in jumps.
    if wrong.outcome is Outcome.COMPLETED:
        found = compare(wrong, CAM)
        for quantity in QUANTITIES:
            assert found.worst(quantity) > 10.0 * right.worst(quantity)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_other_way_round_it_is_as_accurate(engine: str) -> None:
    back: Any = CAM.with_parameters(speed=-CAM.speed)
    for quantity in QUANTITIES:
        there, again = (measured(engine, cam, 800).worst(quantity) for cam in (CAM, back))
        assert again == pytest.approx(there, rel=0.05)


@pytest.mark.parametrize("engine", ENGINES)
def test_one_circle_needs_no_switch(engine: str) -> None:
    cam: Any = CAMS["cam-36-72.5"]
    assert measured(engine, cam, 800).worst("position") < {"mujoco": 1e-9, "pymunk": 1e-4}[engine]
    assert len(ran(engine, cam, 800).points["roller"].velocity.values) in (800, 801)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_in_pieces_is_the_same_run(engine: str) -> None:
    made, settings = engine_named(engine), linkage_settings(engine, CAM, 200)
    whole = ran(engine, CAM, 200, 1.3, 1.0)
    parts = joined(list(made.pieces(CAM, settings, 1.3, 1.0, 7)))
    assert len(parts.clock) == 261
    assert parts.clock[-1] - parts.clock[0] == pytest.approx(1.3 * CAM.period, rel=0.01)
    for quantity in QUANTITIES:
        one, other = (getattr(t.points["roller"], quantity) for t in (whole, parts.trajectory))
        assert np.array_equal(one.values, other.values)
        assert np.array_equal(one.instants.times, other.instants.times)
        assert np.all(np.diff(one.instants.times) > 0.0)


@pytest.mark.parametrize("engine", ENGINES)
def test_bare_steps_are_those_of_the_recorded_run(engine: str) -> None:
    advance: Any = engine_named(engine).stepper(CAM, linkage_settings(engine, CAM, 200))
    for steps in (130, 70, 200):
        advance(steps)
    states = ran(engine, CAM, 200, 2.0).bodies
    assert states is not None
    np.testing.assert_allclose(advance.state()[0], states.position.poses[-1], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
def test_no_acceleration_is_told_at_a_switch(engine: str) -> None:
    tracks, joints = ran(engine, CAM, 800).points["roller"], CAM.break_angles()
    for joint in joints:
        assert np.abs(tracks.position.instants.angle - joint).min() < 1e-9
        assert np.abs(tracks.acceleration.instants.angle - joint).min() > 1e-3
    # Beside it both sides are there, and right: the acceleration jumps by thousands of times its error.
    nose = joints[1]
    left, right = (np.argmin(np.abs(tracks.acceleration.instants.angle - nose - side * 0.02)) for side in (-1.0, 1.0))
    jump = tracks.acceleration.values[right, 1] - tracks.acceleration.values[left, 1]
    exact = CAM.motion([nose - 0.02, nose + 0.02], 1.0).point("roller").acceleration[:, 1]
    assert jump == pytest.approx(exact[1] - exact[0], rel=0.1)
    assert abs(jump) > 0.1 * CAM.lengths["roller"]


@pytest.mark.parametrize("engine", ENGINES)
def test_it_cannot_tell_that_a_follower_would_leave_its_cam(engine: str) -> None:
    # Half the force that holds the follower down: by contact it must fly. A rod pulls, so that nothing is seen of it.
    loose: Any = CamFollower(preload=0.5)
    made = engine_named(engine)
    assert run(loose, made.minimal(loose, 2000), 0.6).outcome is Outcome.LOST_CONTACT
    assert measured(engine, loose, 800).worst("position") == pytest.approx(
        measured(engine, CAM, 800).worst("position"), rel=0.01
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_settings_say_that_it_is_no_contact(engine: str) -> None:
    made, settings = engine_named(engine), linkage_settings(engine, CAM, 200)
    assert settings.cam == EQUIVALENT_LINKAGE
    assert settings.as_dict()["cam"] == "equivalent-linkage"
    by_contact = replace(settings, cam="contact")
    assert "cam" not in by_contact.as_dict()  # keys of results from before stay what they were
    assert Cell("cam", CAM, settings).key != Cell("cam", CAM, by_contact).key
    assert made.refusal(CAM, settings) is None
    assert "it has 0 cams" in (made.refusal(PRESS, replace(made.presets["tuned"](PRESS, 100), cam=settings.cam)) or "")
    assert made.expected_error(CAM, settings).position is None
    with pytest.raises(InvalidInput, match="switched as it runs"):
        made.paste(CAM, settings)
    with pytest.raises(InvalidInput, match=r"unknown cam 'linkage'.*did you mean 'equivalent-linkage'"):
        replace(settings, cam="linkage")


@pytest.mark.parametrize("engine", ENGINES)
def test_the_linkages_have_one_freedom_all_around(engine: str) -> None:
    made, settings = engine_named(engine), linkage_settings(engine, CAM, 200)
    count = made.mobility(CAM, settings, np.linspace(0.01, TURN, 12))
    assert (count.freedom, count.most_freedom, count.missing) == (1, 1, 0)
    assert not count.redundant


@pytest.mark.parametrize("engine", sorted(ENGINES))
def test_a_linkage_carries_whatever_a_cam_may_carry(engine: str) -> None:
    # The crank of an arc about the cam's own axis has both its pins in one place: no bar can be drawn between them.
    assert any(arc.crank == 0.0 for arc in equivalent_linkage(CAM.mechanism()).arcs)
    plain = linkage_settings(engine, CAM, 800)
    refused = engine_named(engine).refusal
    for one in engine_named(engine).ingredients(CAM, engine_named(engine).minimal(CAM, 800)):
        dressed = plain if one.minimal else one.added(plain)
        if dressed.dressing != plain.dressing and not refused(CAM, dressed):
            assert run(CAM, dressed, 1.0).outcome is Outcome.COMPLETED, one.name
