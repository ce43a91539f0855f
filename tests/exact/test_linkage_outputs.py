"""Limits of an input, dead centres, strokes, time ratios and transmission angles, against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from described import CATALOGUE, with_entry
from linkages import assemble_mechanism, four_bar, slider_crank

from conrod import compare, run
from conrod.engines import engine_named
from conrod.exact.kinematics import GenericReference, Kinematics
from conrod.exact.linkage import OutputLink, output_links, turn_quantities
from conrod.exact.linkage.crank_range import CrankRange, SampledMotion, crank_range, sample_motion
from conrod.exact.linkage.transmission import TransmissionAngle, pushes, transmission_angles
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, ObservedPoint, Revolute, Rolling
from conrod.scenes import SCENES, catalogue_scene
from conrod.scenes.described_scene import scene_from_tables

TURN = 2.0 * math.pi
CRANK_ROCKER = (0.1, 0.3, 0.25, 0.3)


def course(mechanism: Mechanism) -> SampledMotion:
    return sample_motion(Kinematics(mechanism))


def output(mechanism: Mechanism) -> OutputLink:
    """Of a linkage with one output."""
    (only,) = output_links(course(mechanism))
    return only


def angles_of(found: OutputLink) -> list[float]:
    return [centre.angle for centre in found.dead_centres]


EXAMPLE_5_6, EXAMPLE_6_18 = (0.11, 0.21, 0.145, 0.3397241528063615), (0.3, 0.25, 0.13, 0.475)


@pytest.mark.parametrize(("lengths", "turn", "printed"), [(EXAMPLE_5_6, 1.05, 88.86), (EXAMPLE_6_18, 0.1, 53.07)])
def test_crank_limits_are_where_coupler_and_rocker_align(
    lengths: tuple[float, float, float, float], turn: float, printed: float
) -> None:
    a, b, c, d = lengths
    limit, mechanism = math.acos((a * a + d * d - (b + c) ** 2) / (2.0 * a * d)), four_bar(*lengths, turn)
    reach = crank_range(Kinematics(mechanism))
    assert (reach.start_end, reach.stop_end, reach.full) == ("limit", "limit", False)
    assert (reach.start + turn, reach.stop + turn) == pytest.approx((-limit, limit), abs=1e-12)
    assert math.degrees(limit) == pytest.approx(printed, abs=0.005)
    # There the transmission angle is lost.
    whole = replace(mechanism, driver=replace(mechanism.driver, span=(reach.start + 1e-9, reach.stop - 1e-9)))
    assert only_angle(whole).worst.value <= 1e-4
    # A driver's span does not change what the crank could do.
    spanned = replace(mechanism, driver=replace(mechanism.driver, span=(-0.5, 0.25)))
    assert crank_range(Kinematics(spanned)) == reach
    assert tuple(course(spanned).angles[[0, -1]]) == (-0.5, 0.25)


def test_crank_range_ignores_driver_span() -> None:
    turning = four_bar(*CRANK_ROCKER)
    part = replace(turning, driver=replace(turning.driver, span=(-0.5, 0.25)))
    assert crank_range(Kinematics(part)) == CrankRange(0.0, TURN, "none", "none")


def test_parallelogram_turns_fully_through_change_points() -> None:
    kinematics = Kinematics(four_bar(0.1, 0.3, 0.1, 0.3, 0.7))
    reach = crank_range(kinematics)
    assert reach.full
    assert sorted(reach.change_points) == pytest.approx([math.pi - 0.7, TURN - 0.7], abs=1e-9)
    # The rocker turns as the crank does, and nothing turns back where the equations are singular.
    (rocker,) = output_links(sample_motion(kinematics))
    assert rocker.dead_centres == ()
    assert rocker.gain == pytest.approx(TURN, rel=1e-14)


def test_crank_range_of_partial_turn_ends_at_change_points() -> None:
    turning = four_bar(0.1, 0.3, 0.1, 0.3, 0.7)
    reach = crank_range(Kinematics(replace(turning, driver=replace(turning.driver, span=(-0.2, 0.2)))))
    assert (reach.start_end, reach.stop_end) == ("change point", "change point")
    # Two branches cross there, so that the place is known to the root of rounding only.
    assert (reach.start + 0.7, reach.stop + 0.7) == pytest.approx((0.0, math.pi), abs=1e-5)


def test_in_line_slider_crank_has_dead_centres_at_0_and_180_deg() -> None:
    found = output(slider_crank(0.1, 0.3))
    assert [(c.greatest, c.angle == c.until) for c in found.dead_centres] == [(False, True), (True, True)]
    assert sorted((angle + 0.5) % TURN for angle in angles_of(found)) == pytest.approx([0.0, math.pi], abs=1e-12)
    assert found.unit == "m"
    assert found.stroke == pytest.approx(0.2, rel=1e-14)
    assert found.time_ratio == pytest.approx(1.0, rel=1e-12)


def test_offset_slider_crank_has_quick_return() -> None:
    r, rod, e = 0.1, 0.3, 0.09
    found = output(slider_crank(r, rod, e))
    out, back = math.asin(e / (rod + r)), math.asin(e / (rod - r))
    assert found.stroke == pytest.approx(math.sqrt((rod + r) ** 2 - e**2) - math.sqrt((rod - r) ** 2 - e**2), rel=1e-13)
    assert sorted((angle + 0.5) % TURN for angle in angles_of(found)) == pytest.approx([out, math.pi + back], abs=1e-11)
    slow = math.pi + (back - out)
    assert found.time_ratio == pytest.approx(slow / (TURN - slow), rel=1e-11)


def test_crank_rocker_dead_centres_align_crank_and_coupler() -> None:
    a, b, c, d = CRANK_ROCKER
    found = output(four_bar(a, b, c, d))

    def rocker(reach: float) -> float:
        return math.pi - math.acos((c * c + d * d - reach * reach) / (2.0 * c * d))

    # Stretched the rocker is farthest from the shaft, at its least angle with the ground line.
    assert [centre.value for centre in sorted(found.dead_centres, key=lambda centre: centre.greatest)] == pytest.approx(
        [rocker(b + a), rocker(b - a)], rel=1e-12
    )
    assert found.stroke == pytest.approx(rocker(b - a) - rocker(b + a), rel=1e-12)

    def crank(reach: float) -> float:
        return math.acos((reach * reach + d * d - c * c) / (2.0 * reach * d))

    ways = sorted((crank(b + a), math.pi + crank(b - a)))
    slow = max(ways[1] - ways[0], TURN - ways[1] + ways[0])
    assert found.time_ratio == pytest.approx(slow / (TURN - slow), rel=1e-11)


def test_whitworth_slotted_link_turns_without_dead_centre() -> None:
    lever, ram = output_links(sample_motion(catalogue_scene("whitworth").kinematics))
    assert (lever.link, lever.dead_centres, lever.stroke, lever.time_ratio) == ("lever", (), None, None)
    assert lever.gain == pytest.approx(TURN, rel=1e-14)
    # Its ram has the quick return: (pi + 2 a) / (pi - 2 a), sin a = offset / crank.
    lean = 2.0 * math.asin(0.05 / 0.1)
    assert ram.time_ratio == pytest.approx((math.pi + lean) / (math.pi - lean), rel=1e-11)
    other = scene_from_tables(with_entry(CATALOGUE / "whitworth.toml", "ground.points.O4", [0, -0.06])).kinematics
    assert abs((output_links(sample_motion(other))[1].time_ratio or 0.0) - (ram.time_ratio or 0.0)) > 0.05


def test_dead_centre_of_cam_dwell_has_begin_and_end() -> None:
    (found,) = output_links(sample_motion(SCENES["cam-follower"].kinematics))
    low = next(centre for centre in found.dead_centres if not centre.greatest)
    top = next(centre for centre in found.dead_centres if centre.greatest)
    assert top.angle == top.until
    # On the base circle from one flank's end to the other's, half a turn from the nose.
    breaks = SCENES["cam-follower"].break_angles()
    assert low.angle == pytest.approx(max(breaks), abs=1e-6)
    assert low.until - TURN == pytest.approx(min(breaks), abs=1e-6)


def only_angle(mechanism: Mechanism) -> TransmissionAngle:
    (found,) = transmission_angles(course(mechanism))
    return found


def test_crank_rocker_transmission_extremes_lie_along_ground() -> None:
    a, b, c, d = CRANK_ROCKER
    found = only_angle(four_bar(a, b, c, d))
    ends = [math.acos((b * b + c * c - (d + sign * a) ** 2) / (2.0 * b * c)) for sign in (-1.0, 1.0)]
    assert (found.least.value, found.greatest.value) == pytest.approx(tuple(ends), abs=1e-13)
    # At an extreme the angle is flat: where it is taken is known to the root of rounding.
    places = [(extreme.angle + 0.7) % TURN for extreme in (found.least, found.greatest)]
    assert [math.remainder(places[0], TURN), places[1]] == pytest.approx([0.0, math.pi], abs=1e-6)
    assert found.worst.value == pytest.approx(min(ends[0], math.pi - ends[1]), abs=1e-13)
    assert found.greatest_pressure_angle.value == pytest.approx(0.5 * math.pi - found.worst.value, abs=1e-15)


def test_slider_crank_pressure_angle_matches_closed_form() -> None:
    found = only_angle(slider_crank(0.1, 0.3, 0.09))
    assert math.sin(found.greatest_pressure_angle.value) == pytest.approx(0.19 / 0.3, rel=1e-13)


def test_block_pushes_slotted_link_across_its_slot() -> None:
    found = only_angle(catalogue_scene("inverted-slider-crank").mechanism())
    assert found.through == "block"
    assert (found.least.value, found.greatest.value) == pytest.approx((0.5 * math.pi, 0.5 * math.pi), abs=1e-12)
    # Beside the pivot, by e, it is off by asin(e / reach), at most where the block comes nearest.
    given = with_entry(CATALOGUE / "inverted-slider-crank.toml", "bodies.link.points.S", [0, 0.03])
    given["bodies"]["link"]["ends"] = ["O", "T"]
    given["joints"]["slide"]["guide"] = "link.S"
    beside = only_angle(scene_from_tables(given).mechanism())
    assert beside.greatest_pressure_angle.value == pytest.approx(math.asin(0.03 / 0.15), rel=1e-12)


def test_shaper_lever_drives_ram_and_not_reverse() -> None:
    shaper = sample_motion(catalogue_scene("crank-shaper").kinematics)
    assert [(a.driven, a.through) for a in transmission_angles(shaper)] == [("lever", "block"), ("ram", "link")]
    lever, ram = output_links(shaper)
    swing = 2.0 * math.asin(0.1 / 0.2)
    assert lever.stroke == pytest.approx(swing, rel=1e-12)
    # The lever swings to the same angle on both sides, so the ram goes twice as far as its pin's greatest sine.
    assert ram.stroke == pytest.approx(2.0 * 0.4 * 0.1 / 0.2, rel=1e-12)
    assert ram.time_ratio == pytest.approx((math.pi + swing) / (math.pi - swing), rel=1e-11)


@pytest.mark.parametrize("name", ["saw-40rpm", "cam-follower"])
def test_worst_transmission_angle_bounds_all_samples(name: str) -> None:
    kinematics = SCENES[name].kinematics
    (found,) = transmission_angles(sample_motion(kinematics))
    (push,) = pushes(kinematics, kinematics.poses(kinematics.angles(3600)))
    sampled = math.asin(np.sin(push.angle).min())
    assert sampled - 1e-6 <= found.worst.value <= sampled + 1e-14


# -- trains of gears whose turns differ, and dyads that are moved by what they are pinned to ---------------------------


def geared_four_bar(radius: float) -> GenericReference:
    """A four-bar, its crank driven by a pinion of a radius [m]."""
    machine = four_bar(0.07, 0.25, 0.2, 0.3, turn=0.0)
    motor = Revolute("motor", GROUND, "pinion", (-0.12, 0.0), (0.0, 0.0))
    mesh = Rolling("mesh", "pinion", "crank", (0.0, 0.0), (0.0, 0.0), radius, 0.12 - radius)
    bars = Body("coupler", 1.0, 0.25**2 / 12.0, (0.125, 0.0)), Body("rocker", 1.0, 0.2**2 / 12.0, (0.1, 0.0))
    geared_machine = replace(
        machine,
        bodies=(Body("crank", 1.5, 4.8e-3), *bars, Body("pinion", 0.5, 4e-4)),
        joints=(*machine.joints, motor, mesh),
        driver=Driver("motor"),
        poses={**machine.poses, "pinion": (-0.12, 0.0, 0.0)},
        observed=(ObservedPoint("B", "coupler", (0.25, 0.0)),),
    )
    return GenericReference(geared_machine, 10.0 * math.pi)


def test_rocker_behind_slow_wheel_has_no_gain() -> None:
    crank, rocker = turn_quantities(geared_four_bar(0.04).kinematics).outputs
    assert (crank.link, rocker.link) == ("crank", "rocker")
    # Half a turn a turn, every time: the crank goes on.
    assert crank.gain == pytest.approx(-math.pi, abs=1e-7)
    assert crank.stroke is None
    assert (rocker.gain, rocker.time_ratio) == (0.0, None)
    assert [round(centre.angle, 6) for centre in rocker.dead_centres] == [4.877361]


def test_tolerances_behind_slow_wheel_cover_all_turns() -> None:
    scene, pymunk = geared_four_bar(0.04), engine_named("pymunk")
    settings = pymunk.presets["tuned"](scene, 500)
    allowed = pymunk.expected_error(scene, settings).position
    first, both = (compare(run(scene, settings, revolutions=turns), scene).worst("position") for turns in (1.0, 2.0))
    # The second turn is the worse one, so that a law over the first alone would be exceeded.
    assert 1.3 * first < both < allowed < 1.1 * both


def test_turns_repeat_behind_wheel_of_equal_size() -> None:
    crank, rocker = turn_quantities(geared_four_bar(0.06).kinematics).outputs
    assert crank.stroke is None
    assert len(rocker.dead_centres) == 2
    assert rocker.time_ratio is not None


def test_rod_moved_by_rocker_does_not_push_it() -> None:
    shaft, a, q, b = (0.0, 0.0), (0.07, 0.0), (0.3, 0.0), (0.23, 0.19)
    c, d, e = (0.1, 0.2), (0.4, 0.1), (0.35, 0.32)
    links = {"crank": (shaft, a), "coupler": (a, b), "rocker": (q, b)}
    pins = [("shaft", GROUND, "crank", shaft), ("a", "crank", "coupler", a), ("b", "coupler", "rocker", b)]
    pins.append(("q", GROUND, "rocker", q))
    dyad = [("c", "coupler", "fifth", c), ("d", "rocker", "sixth", d), ("e", "fifth", "sixth", e)]
    six_bar = Kinematics(assemble_mechanism("six-bar", links | {"fifth": (c, e), "sixth": (d, e)}, [*pins, *dyad]))
    plain = Kinematics(assemble_mechanism("four-bar", links, pins))
    assert [push.through for push in pushes(six_bar, six_bar.start)] == []
    # Negative control: the four-bar's coupler does push it.
    assert [push.through for push in pushes(plain, plain.start)] == ["coupler"]
