"""Long series come out as short ones do: nothing depends on where a chunk ends."""

from __future__ import annotations

import numpy as np
import pytest

from conrod import SCENES, PymunkSettings, run
from conrod.engines.pymunk import dynamics, stepping
from conrod.exact import GenericReference

QUANTITIES = ("position", "velocity", "acceleration", "jerk")


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("generic", [False, True])
def test_exact_motion_is_that_of_its_parts(name: str, generic: bool) -> None:
    scene = SCENES[name]
    ruler = GenericReference(scene.mechanism(), scene.speed) if generic else scene
    angle = np.linspace(-3.0, 9.0, 9001)
    speed, acceleration = scene.speed * (1.0 + 0.1 * np.sin(angle)), 0.3 * scene.speed**2 * np.cos(angle)
    whole = ruler.motion(angle, speed, acceleration)
    for rows in (slice(0, 5), slice(2040, 2060), slice(8188, 8200), slice(8995, 9001)):
        part = ruler.motion(angle[rows], speed[rows], acceleration[rows])
        for point in scene.lengths:
            for order, quantity in enumerate(QUANTITIES):
                values = getattr(whole.point(point), quantity)
                size = scene.lengths[point] * abs(scene.speed) ** order
                np.testing.assert_allclose(values[rows], getattr(part.point(point), quantity), atol=1e-12 * size)


@pytest.mark.parametrize("name", ["saw-40rpm", "cam-follower"])
def test_a_pymunk_run_is_the_same_however_it_is_cut(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = SCENES[name]
    settings = PymunkSettings.tuned(scene, 400)
    whole = run(scene, settings, revolutions=1)
    monkeypatch.setattr(stepping, "BLOCK", 7)
    monkeypatch.setattr(dynamics, "CHUNK", 11)
    cut = run(scene, settings, revolutions=1)
    for point, tracks in whole.points.items():
        for quantity in QUANTITIES[:3]:
            expected = getattr(tracks, quantity).values
            np.testing.assert_array_equal(getattr(cut.points[point], quantity).values, expected)


def test_pymunks_public_way_is_taken_where_the_memory_is_not_as_known(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = SCENES["saw-40rpm"]
    settings = PymunkSettings.tuned(scene, 100)
    known = run(scene, settings, revolutions=1)
    assert stepping.memory_is_known()
    for offset in (stepping.OFFSET - 16, stepping.OFFSET + 8):
        monkeypatch.setattr(stepping, "OFFSET", offset)
        assert not stepping.memory_is_known()
    other = run(scene, settings, revolutions=1)
    np.testing.assert_array_equal(known.points["C"].position.values, other.points["C"].position.values)
