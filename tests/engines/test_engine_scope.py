"""What users' files may ask of the engines: slides anywhere on moving links, and cams within the laws of contact."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.engines import numerics as approach
from conrod.engines.pymunk import engine as pymunk_kinematic
from conrod.engines.pymunk import space
from conrod.exact.motion import Array
from conrod.scenes import catalogue_scene
from conrod.scenes.described_scene import DescribedScene, scene_of
from conrod.studies.validation import study
from conrod.studies.validation.study import validate_kinematic

# A crank's block slides beside a lever's middle line; block and lever have turned frames and centres of gravity
# away from both line and points.
OFFSET_SLIDE = """
name = "offset-slide"
title = "Quick return with an offset slide"
source = "made for this test"
[driver]
joint = "shaft"
speed = "100 rpm"
start = "90 deg"
[ground.points]
O = [0, 0]
Q = [0, "-250 mm"]
[bodies.crank]
points = { A = ["70 mm", 0] }
uniform = "disc"
radius = "80 mm"
mass = 1.5
[bodies.block]
points = { G = ["3 mm", "15 mm"] }
mass = 0.3
inertia = 2e-4
centre_of_gravity = ["2 mm", "-4 mm"]
[bodies.lever]
points = { Q = [0, 0], T = ["450 mm", 0], S = ["20 mm", "20 mm"] }
mass = 2
inertia = 0.05
centre_of_gravity = ["220 mm", "10 mm"]
[joints.shaft]
kind = "revolute"
connects = ["ground.O", "crank"]
[joints.pin]
kind = "revolute"
connects = ["crank.A", "block"]
[joints.slide]
kind = "prismatic"
guide = "lever.S"
direction = "4 deg"
slider = "block.G"
angle = "25 deg"
[joints.pivot]
kind = "revolute"
connects = ["ground.Q", "lever.Q"]
[start]
lever = { turn = "90 deg" }
[observed]
T = "lever.T"
"""


@pytest.fixture(autouse=True)
def few_angles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "KINEMATIC_ANGLES", 24)


def offset_slide(*changes: tuple[str, str]) -> DescribedScene:
    text = OFFSET_SLIDE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return scene_of(tomllib.loads(text))


# -- slides ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turned", [False, True], ids=["guide on the lever", "guide on the block"])
@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_a_slide_beside_the_centres_of_gravity_is_proved_in_kinematic_mode(engine: str, turned: bool) -> None:
    other = ('guide = "lever.S"', 'guide = "block.G"'), ('slider = "block.G"', 'slider = "lever.S"')
    result = validate_kinematic("offset", offset_slide(*(other if turned else ())), engine_named(engine))
    assert result.passed, result.exceeded()


def test_a_groove_where_the_file_has_it_would_leak_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(space, "_through_centres", lambda joint, anchor, point: (anchor, point))
    result = validate_kinematic("offset", offset_slide(), engine_named("pymunk"))
    position, velocity = result.largest("position"), result.largest("velocity")
    assert position is not None
    assert velocity is not None
    assert position < 1e-12
    assert velocity > 1e-3


# -- kinematic mode far from the start, and near the limits of an input ------------------------------------------------

# At -60 deg slider C has two places on its line that the rod BC reaches.
FAR = np.radians([-60.0])
LINKAGE = "two-slider-linkage"


def off(engine: str, angle: Array, rate: bool = False) -> float:
    """Largest error of a point's position over L, or of its velocity over L times the crank's speed."""
    scene = catalogue_scene(LINKAGE).with_parameters(**{"driver.to": float(np.radians(60.0))})
    solved, exact = engine_named(engine).solve_kinematics(scene, angle), scene.motion(angle, scene.speed)
    worst = 0.0
    for name, (position, velocity) in solved.points.items():
        assert velocity is not None
        error = (velocity - exact.point(name).velocity) / scene.speed if rate else position - exact.point(name).position
        worst = max(worst, float(np.linalg.norm(error, axis=1).max()) / scene.lengths[name])
    return worst


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_an_angle_far_from_the_start_is_solved_on_the_branch_of_the_start(engine: str) -> None:
    assert off(engine, FAR) < 1e-12
    assert off(engine, FAR, rate=True) < 1e-9


def test_newton_iteration_from_the_start_alone_finds_another_assembly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(approach, "LONGEST_STEP", 10.0)
    assert off("mujoco", FAR) > 0.1


def test_rates_of_badly_conditioned_joints_are_solved_until_they_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    # Where rod BC stands nearly across the slide of C.
    angle = np.radians(np.linspace(25.0, 45.0, 5))
    assert off("pymunk", angle, rate=True) < 1e-11
    monkeypatch.setattr(pymunk_kinematic, "RATE_SOLVES", 1)
    assert off("pymunk", angle, rate=True) > 1e-9
