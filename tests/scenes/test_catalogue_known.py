"""Machines that users know: the catalogue's motions against what theory says of each."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from described import CATALOGUE, tables, with_entry

from conrod.comparison.compare import compare
from conrod.engines import engine_named
from conrod.engines.run import run_in_one_piece
from conrod.exact.motion import Array
from conrod.scenes.described_scene import DescribedScene, scene_from_tables

TURN = np.linspace(0.0, 2.0 * math.pi, 721)


@cache
def scene(name: str) -> DescribedScene:
    return scene_from_tables(tables(CATALOGUE / f"{name}.toml"))


def altered_scene(name: str, place: str, value: Any) -> DescribedScene:
    """A planted defect."""
    return scene_from_tables(with_entry(CATALOGUE / f"{name}.toml", place, value))


def turn_of(of: DescribedScene, body: str, angle: Array) -> Array:
    """Turn [rad] of a body."""
    return np.asarray(of.kinematics.poses(angle)[:, 3 * of.mechanism().body_index[body] + 2])


def x_positions(of: DescribedScene, point: str, angle: Array) -> Array:
    """x [m] of a point that goes up and down."""
    return np.asarray(of.motion(angle, 1.0).point(point).position[:, 0])


def test_peaucellier_point_moves_on_a_line() -> None:
    of = scene("peaucellier")
    angle = of.kinematics.angles(721)
    assert np.abs(x_positions(of, "C", angle) - 0.14).max() < 1e-12 * 0.14
    assert of.lengths["C"] == pytest.approx(2.0 * 0.14 * math.tan(math.radians(30.0)), rel=1e-6)


def test_peaucellier_line_bends_when_circle_misses_pivot() -> None:
    of = altered_scene("peaucellier", "ground.points.Q", ["121 mm", 0])
    assert np.ptp(x_positions(of, "C", of.kinematics.angles(721))) > 1e-4


def test_watt_point_leaves_its_line_at_fifth_order() -> None:
    """x = L^2 a^5 / (8 c) for arms L and a coupler 2 c, to leading order in the arms' turn a."""
    of, arm, half = scene("watt-straight-line"), 0.2, 0.06
    angle = np.radians([16.0, 8.0, 4.0])
    left = np.abs(x_positions(of, "P", angle))
    assert np.log2(left[:-1] / left[1:]) == pytest.approx(5.0, abs=0.1)
    assert left[-1] == pytest.approx(arm**2 * angle[-1] ** 5 / (8.0 * half), rel=0.02)
    assert np.ptp(x_positions(of, "P", of.kinematics.angles(721))) < 0.02 * of.lengths["P"]


def test_watt_point_off_the_middle_leaves_its_line_at_once() -> None:
    beside = altered_scene("watt-straight-line", "bodies.coupler.points.P", [0, "6 mm"])
    angle = np.radians([0.0, 4.0])
    middle, off = (np.ptp(x_positions(of, "P", angle)) for of in (scene("watt-straight-line"), beside))
    assert off > 10.0 * middle


def ground_phase(of: DescribedScene) -> tuple[float, float, float]:
    """Of the foot: part of a turn that it is within 3 % of its width of the ground, the step's length, its height."""
    foot = of.motion(TURN[:-1], 1.0).point("foot").position
    low = foot[:, 1] - foot[:, 1].min() < 0.03 * np.ptp(foot[:, 0])
    return float(low.mean()), float(np.ptp(foot[low, 0])), float(np.ptp(foot[:, 1]))


def test_jansen_foot_stays_down_for_half_a_turn() -> None:
    share, step, height = ground_phase(scene("jansen-leg"))
    assert share > 0.5
    assert step > 0.55
    assert height < 0.5 * step


def test_jansen_leg_with_one_wrong_rod_does_not_walk() -> None:
    share, step, _ = ground_phase(altered_scene("jansen-leg", "bodies.k.points.V", ["55 cm", 0]))
    assert share < 0.45 or step < 0.5


def test_geneva_wheel_turns_a_quarter_without_velocity_jump() -> None:
    """Its turn is -atan(m sin a / (1 - m cos a)), m = pin radius / centre distance = 1 / sqrt 2."""
    of, m = scene("geneva"), math.sqrt(0.5)
    angle = of.kinematics.angles(181)
    wheel = turn_of(of, "wheel", angle) - math.pi
    assert np.abs(wheel + np.arctan2(m * np.sin(angle), 1.0 - m * np.cos(angle))).max() < 1e-12
    assert np.ptp(wheel) == pytest.approx(math.radians(90.0))
    speed = np.linalg.norm(of.motion(angle, 1.0).point("rim").velocity, axis=1)
    assert speed[[0, -1]].max() < 1e-9 * speed.max()
    # Largest ratio m / (1 - m), between the shafts.
    assert speed.max() / 0.06 == pytest.approx(m / (1.0 - m))


def test_geneva_wheel_at_wrong_distance_starts_with_jump() -> None:
    of = altered_scene("geneva", "ground.points.O4", ["86 mm", 0])
    speed = np.linalg.norm(of.motion(of.kinematics.angles(181), 1.0).point("rim").velocity, axis=1)
    assert speed[0] > 1e-3 * speed.max()


def test_planetary_gear_turns_by_willis_formula() -> None:
    """Carrier: 1 / (1 + ring / sun) of the sun; against it the ring turns the planet by -ring / planet (1 - ...)."""
    of = scene("planetary-gear")
    carrier, planet = (turn_of(of, body, TURN) for body in ("carrier", "planet"))
    assert np.abs(carrier - TURN / 3.5).max() < 1e-12
    assert np.abs(planet - carrier * (1.0 - 50.0 / 15.0)).max() < 1e-12


def test_planetary_ratio_follows_teeth() -> None:
    whole = with_entry(CATALOGUE / "planetary-gear.toml", "joints.sun-mesh.radii", ["18 mm", "17 mm"])
    whole["joints"]["ring-mesh"]["radii"] = ["17 mm", "52 mm"]
    assert turn_of(scene_from_tables(whole), "carrier", TURN)[-1] == pytest.approx(2.0 * math.pi / (1.0 + 52.0 / 18.0))


def test_mujoco_error_bound_covers_fast_reactions_of_leg() -> None:
    """Its foot's reactions peak within a tenth of a radian: what gives way to them moves faster than it opened."""
    of, engine = scene("jansen-leg"), engine_named("mujoco")
    settings = engine.presets["tuned"](of, 1000)
    found = compare(run_in_one_piece(engine, of, settings, 1.0, 0.0), of).worst("velocity")
    allowed = engine.expected_error(of, settings).velocity
    assert allowed is not None
    assert found < allowed < 1.1 * found
