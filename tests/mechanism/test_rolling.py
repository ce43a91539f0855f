"""Wheels that roll, and inputs that make one pass: exact motion, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rolling_machines import TOOTH, WHEEL, at_test_speed, gear_pair, poses_of, swinging_four_bar, wheel_on_a_track

from conrod.engines.spanning_tree import grow_spanning_tree
from conrod.errors import InvalidInput
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, Prismatic, Revolute, Rolling

SPAN = (-0.4, 0.3)  # [rad], of the crank


def test_wheel_on_endless_track_is_exact() -> None:
    machine, angle = at_test_speed(wheel_on_a_track()), np.linspace(-10.0, 40.0, 23)
    place = poses_of(machine, "wheel", angle)
    np.testing.assert_allclose(place[:, 0], 0.2 + TOOTH * angle, atol=1e-12)
    np.testing.assert_allclose(place[:, 2], -TOOTH / WHEEL * angle, atol=1e-12)


def test_span_beyond_linkage_limit_is_refused_with_angle() -> None:
    limit = math.radians(88.86) - 1.0540538523344571
    with pytest.raises(InvalidInput, match="swinging-four-bar cannot be assembled at crank angle") as told:
        _ = at_test_speed(swinging_four_bar((-0.1, limit + 0.01))).lengths
    reached = str(told.value).split(" deg")[0].split()[-1]
    assert float(reached) == pytest.approx(math.degrees(limit), abs=0.01)
    assert at_test_speed(swinging_four_bar((-0.1, limit - 0.01))).lengths["joint"] > 0.0


@pytest.mark.parametrize("span", [(0.1, 0.5), (0.3, -0.3), (0.0, 0.0), (0.0, math.nan), (-math.inf, 0.0)])
def test_empty_span_is_refused(span: tuple[float, float]) -> None:
    with pytest.raises(InvalidInput, match="driver shaft: "):
        Driver("shaft", span=span)


def test_wrong_radius_is_refused_as_wheels_do_not_touch() -> None:
    pair = gear_pair().joints[-1]
    assert isinstance(pair, Rolling)
    larger = replace(pair, radius_b=WHEEL + 0.001)
    with pytest.raises(InvalidInput, match=r"mesh: .* are 0.13 m apart, the radii ask for 0.131 m"):
        _ = at_test_speed(replace(gear_pair(), joints=(*gear_pair().joints[:2], larger))).lengths


@pytest.mark.parametrize("radii", [(0.1, -0.1), (0.1, -0.05), (-0.1, -0.2), (0.0, 0.1), (math.nan, 0.1)])
def test_radii_that_cannot_roll_are_refused(radii: tuple[float, float]) -> None:
    with pytest.raises(InvalidInput, match="mesh"):
        Rolling("mesh", "a", "b", (0.0, 0.0), (0.0, 0.0), *radii)


def test_slides_alone_cannot_close_a_loop() -> None:
    wedge = Mechanism(
        "wedge",
        (Body("crank", 1.0, 1.0), Body("wedge", 1.0, 1.0), Body("follower", 1.0, 1.0)),
        (
            Revolute("shaft", GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
            Prismatic("floor", GROUND, "wedge", (0.0, 0.0), (0.0, 0.0), 0.0),
            Prismatic("slope", "wedge", "follower", (0.0, 0.0), (0.0, 0.0), 0.5),
            Prismatic("wall", GROUND, "follower", (0.0, 0.0), (0.0, 0.0), math.pi / 2),
        ),
        Driver("shaft"),
        {"crank": (0.0, 0.0, 0.0), "wedge": (0.0, 0.0, 0.0), "follower": (0.0, 0.0, 0.0)},
        (),
    )
    with pytest.raises(InvalidInput, match="'wall' closes a loop of slides alone"):
        grow_spanning_tree(wedge, np.zeros(9))
