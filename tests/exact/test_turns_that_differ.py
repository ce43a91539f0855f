"""Trains of gears whose turns differ, and dyads that are moved by what they are pinned to."""

from __future__ import annotations

from typing import Any

import pytest

from conrod import compare, run
from conrod.engines import engine_named
from conrod.exact.linkage import TurnQuantities, turn_quantities
from conrod.exact.linkage.transmission import pushes
from conrod.scenes.described_scene import scene_of


def four_bar() -> dict[str, Any]:
    pins = {"shaft": ["ground.O", "crank"], "a": ["crank.A", "coupler.A"], "b": ["coupler.B", "rocker.B"]}
    pins["q"] = ["ground.Q", "rocker.Q"]
    return {
        "name": "four-bar", "title": "A four-bar", "source": "made for this test",
        "driver": {"joint": "shaft", "speed": "300 rpm"},
        "ground": {"points": {"O": [0, 0], "Q": ["300 mm", 0]}},
        "bodies": {
            "crank": {"points": {"A": ["70 mm", 0]}, "uniform": "disc", "radius": "80 mm", "mass": 1.5},
            "coupler": {"points": {"A": [0, 0], "B": ["250 mm", 0]}, "uniform": "bar", "mass": 1},
            "rocker": {"points": {"Q": [0, 0], "B": ["200 mm", 0]}, "uniform": "bar", "ends": ["Q", "B"], "mass": 1},
        },
        "joints": {name: {"kind": "revolute", "connects": pair} for name, pair in pins.items()},
        "start": {"coupler": {"turn": "50 deg"}},
        "observed": {"B": "coupler.B"},
    }  # fmt: skip


def geared(radius: str) -> TurnQuantities:
    return turn_quantities(scene_of(geared_tables(radius)).kinematics)


def geared_tables(radius: str) -> dict[str, Any]:
    """The four-bar, its crank driven by a pinion of a radius."""
    given = four_bar()
    given["ground"]["points"]["M"] = ["-120 mm", 0]
    given["bodies"]["pinion"] = {"uniform": "disc", "radius": radius, "mass": 0.5}
    given["joints"]["motor"] = {"kind": "revolute", "connects": ["ground.M", "pinion"]}
    other = f"{120 - int(radius.split(maxsplit=1)[0])} mm"
    given["joints"]["mesh"] = {"kind": "gear", "wheels": ["pinion", "crank"], "radii": [radius, other]}
    given["driver"]["joint"] = "motor"
    return given


def test_a_rocker_behind_a_slow_wheel_does_not_go_on_turning() -> None:
    crank, rocker = geared("40 mm").outputs
    assert (crank.link, rocker.link) == ("crank", "rocker")
    # Half a turn a turn, every time: the crank goes on.
    assert crank.gain == pytest.approx(-3.14159265, abs=1e-7)
    assert crank.stroke is None
    assert (rocker.gain, rocker.time_ratio) == (0.0, None)
    assert [round(centre.angle, 6) for centre in rocker.dead_centres] == [4.877361]


def test_tolerances_behind_a_slow_wheel_are_those_of_all_turns_of_a_run() -> None:
    scene, pymunk = scene_of(geared_tables("40 mm")), engine_named("pymunk")
    settings = pymunk.presets["tuned"](scene, 500)
    allowed = pymunk.expected_error(scene, settings).position
    assert allowed is not None
    first, both = (compare(run(scene, settings, revolutions=turns), scene).worst("position") for turns in (1.0, 2.0))
    # The second turn is the worse one, so that a law over the first alone would be exceeded.
    assert 1.3 * first < both < allowed < 1.1 * both


def test_behind_an_equal_wheel_every_turn_is_alike() -> None:
    crank, rocker = geared("60 mm").outputs
    assert crank.stroke is None
    assert len(rocker.dead_centres) == 2
    assert rocker.time_ratio is not None


def test_a_rod_that_a_rocker_moves_does_not_push_it() -> None:
    given = four_bar()
    given["bodies"]["coupler"]["points"]["C"] = ["150 mm", "120 mm"]
    given["bodies"]["coupler"]["ends"] = ["A", "B"]
    given["bodies"]["rocker"]["points"]["D"] = ["150 mm", "-90 mm"]
    for name, start in (("fifth", "C"), ("sixth", "D")):
        points = {start: [0, 0], "E": ["260 mm", 0]}
        given["bodies"][name] = {"points": points, "uniform": "bar", "mass": 0.8}
    pairs = {"c": ["coupler.C", "fifth.C"], "d": ["rocker.D", "sixth.D"], "e": ["fifth.E", "sixth.E"]}
    given["joints"] |= {name: {"kind": "revolute", "connects": pair} for name, pair in pairs.items()}
    given["start"]["sixth"] = {"turn": "100 deg"}
    six_bar, plain = scene_of(given).kinematics, scene_of(four_bar()).kinematics
    assert [push.through for push in pushes(six_bar, six_bar.start)] == []
    # Negative control: the four-bar's coupler does push it.
    assert [push.through for push in pushes(plain, plain.start)] == ["coupler"]
