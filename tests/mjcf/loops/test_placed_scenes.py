"""Planar machines that stand anywhere in space move as they do in their plane."""

from __future__ import annotations

import numpy as np
import pytest
from placed_scenes import driven, duration, exact_points, model_text, scene

from conrod.exact.motion import Array
from conrod.exact.space.motion import DrivenTree

# Pins and slides, wheels, and an input that makes one pass; a pin in a slot, a rack and a wheel on a line.
SCENES = (
    "six-bar",
    "planetary-gear",
    "swinging-four-bar",
    *(pytest.param(name, marks=pytest.mark.slow) for name in ("geneva", "rack-and-wheel", "rolling-on-flat")),
)
BAR = 1e-10


def worst(found: DrivenTree, truth: dict[str, Array], times: Array, rate: float) -> float:
    """Largest deviation of position, velocity, acceleration and jerk, over the travel and its rates."""
    motion = found.motion(times)
    travel = max(np.ptp(points[0], axis=0).max() for points in truth.values())
    off = 0.0
    for name, points in truth.items():
        one = motion.points[name]
        for order, values in enumerate((one.position, one.velocity, one.acceleration, one.jerk)):
            size = max(travel * rate**order, np.abs(points[order]).max() if order else 0.0)
            off = max(off, np.abs(values - points[order]).max() / size)
    return off


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("name", SCENES)
def test_a_placed_scene_moves_as_in_its_plane(name: str, moving: bool) -> None:
    end = duration(name)
    times = np.linspace(0.0, end, 90)
    truth = exact_points(name, times, moving)
    found = driven(name, model_text(name, moving), end)
    assert worst(found, truth, times, abs(scene(name).speed)) < BAR


def test_a_pin_a_hundredth_of_a_millimetre_off_is_another_machine() -> None:
    # Negative control.
    root = model_text("six-bar")
    pin = next(site for site in root.iter("site") if site.get("name") == "D.ternary")
    pin.set("pos", "0.53001 0 0")
    times = np.linspace(0.0, duration("six-bar"), 30)
    off = worst(driven("six-bar", root, times[-1]), exact_points("six-bar", times), times, scene("six-bar").speed)
    assert 1e-6 < off < 1e-1
