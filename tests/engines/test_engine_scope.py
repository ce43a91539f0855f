"""What users' files may ask of the engines: slides anywhere on moving links, and cams within the laws of contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kinematic_mode import kinematic_errors

from conrod.engines import numerics as approach
from conrod.engines.pymunk import engine as pymunk_kinematic
from conrod.engines.pymunk import space
from conrod.exact.kinematics import GenericReference
from conrod.mechanism.mechanism import Prismatic, to_world
from conrod.scenes import catalogue_scene

ANGLES = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


def offset_slide(turned: bool = False) -> GenericReference:
    """A crank's block, its frame turned by 0.4 rad, slides beside a link's middle line; nothing lies on that line.

    Args:
        turned: whether the guide is on the block.
    """
    plain, turn = catalogue_scene("inverted-slider-crank").mechanism(), 0.4
    centres = {"crank": (0.0, 0.0), "block": (0.002, -0.004), "link": (0.22, 0.01)}
    on_block = to_world((0.0, 0.0, -turn), (0.003, 0.02))
    slide = Prismatic("slide", "link", "block", (0.05, 0.02), on_block, 0.0, turn)
    if turned:
        slide = Prismatic("slide", "block", "link", on_block, (0.05, 0.02), -turn, -turn)
    described = replace(
        plain,
        bodies=tuple(replace(body, centre_of_gravity=centres[body.name]) for body in plain.bodies),
        joints=tuple(slide if joint.name == "slide" else joint for joint in plain.joints),
        poses={**plain.poses, "block": (*plain.poses["block"][:2], turn)},
    )
    return GenericReference(described, 10.0)


# -- slides ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turned", [False, True], ids=["guide on the lever", "guide on the block"])
@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_kinematic_mode_proves_a_slide_off_centres_of_gravity(engine: str, turned: bool) -> None:
    position, velocity = kinematic_errors(engine, offset_slide(turned), ANGLES)
    assert position < 1e-12
    assert velocity < 1e-9


def test_a_groove_off_the_centres_of_gravity_leaks_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(space, "_move_line_to_centres", lambda joint, anchor, point: (anchor, point))
    position, velocity = kinematic_errors("pymunk", offset_slide(), ANGLES)
    assert position < 1e-12
    assert velocity > 1e-3


# -- kinematic mode far from the start, and near the limits of an input ------------------------------------------------

# At -60 deg slider C has two places on its line that the rod BC reaches.
FAR = np.radians([-60.0])
SLIDERS = catalogue_scene("two-slider-linkage").with_parameters(**{"driver.to": float(np.radians(60.0))})


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_kinematic_mode_keeps_the_branch_at_distant_angles(engine: str) -> None:
    position, velocity = kinematic_errors(engine, SLIDERS, FAR)
    assert position < 1e-12
    assert velocity < 1e-9


def test_newton_from_the_start_alone_finds_another_branch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(approach, "MAX_ANGLE_STEP", 10.0)
    assert kinematic_errors("mujoco", SLIDERS, FAR)[0] > 0.1


def test_rates_are_solved_again_for_badly_conditioned_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    # Where rod BC stands nearly across the slide of C.
    angle = np.radians(np.linspace(25.0, 45.0, 5))
    assert kinematic_errors("pymunk", SLIDERS, angle)[1] < 1e-11
    monkeypatch.setattr(pymunk_kinematic, "MAX_RATE_SOLVES", 1)
    assert kinematic_errors("pymunk", SLIDERS, angle)[1] > 1e-9
