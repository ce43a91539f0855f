"""Planar machines that stand anywhere in space move as they do in their plane."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from placed_scenes import driven, duration, exact_points, model_text, scene

from conrod.exact.motion import Array
from conrod.exact.space.mobility import mobility
from conrod.exact.space.motion import DrivenTree

# All kinds of closures: of pins, of slides in the tree, of wheels that roll, of racks; turning and passing inputs.
SCENES = (
    "saw-40rpm", "shear-press", "crank-shaper", "double-rocker", "geneva", "inverted-slider-crank", "jansen-leg",
    "peaucellier", "planetary-gear", "rack-and-wheel", "rolling-on-flat", "six-bar", "swinging-four-bar",
    "two-slider-linkage", "watt-straight-line", "web-cutter", "whitworth",
)  # fmt: skip
BAR = 1e-10
# Pins and slides, wheels, and an input that makes one pass; the others in the slow tests.
FAST = ("six-bar", "planetary-gear", "swinging-four-bar")


def slow_but_for(fast: tuple[str, ...], names: tuple[str, ...]) -> list[object]:
    """Parameters, of which only these are fast."""
    return [pytest.param(name, marks=() if name in fast else pytest.mark.slow) for name in names]


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


@pytest.mark.parametrize("placed", [{}, {"mirrored": True}, {"moving": True}], ids=["turned", "mirrored", "moving"])
@pytest.mark.parametrize("name", slow_but_for(FAST, SCENES))
def test_a_placed_scene_moves_as_in_its_plane(name: str, placed: dict[str, bool]) -> None:
    end = duration(name)
    times = np.linspace(0.0, end, 90)
    truth = exact_points(name, times, **placed)
    found = driven(name, model_text(name, **placed), end)
    assert worst(found, truth, times, abs(scene(name).speed)) < BAR


def test_a_pin_a_hundredth_of_a_millimetre_off_is_another_machine() -> None:
    # Negative control.
    root = model_text("six-bar")
    pin = next(site for site in root.iter("site") if site.get("name") == "D.ternary")
    pin.set("pos", "0.53001 0 0")
    times = np.linspace(0.0, duration("six-bar"), 30)
    off = worst(driven("six-bar", root, times[-1]), exact_points("six-bar", times), times, scene("six-bar").speed)
    assert 1e-6 < off < 1e-1


def closed_once_more(root: ET.Element) -> ET.Element:
    """Every closure of points twice, and each pin by its other side too."""
    for number, closure in enumerate(root.find("equality").findall("connect")):
        ET.SubElement(root.find("equality"), "connect", dict(closure.attrib, name=f"again {number}"))
        swapped = dict(closure.attrib, name=f"swapped {number}", site1=closure.get("site2"), site2=closure.get("site1"))
        ET.SubElement(root.find("equality"), "connect", swapped)
    return root


@pytest.mark.parametrize("name", slow_but_for(("six-bar",), ("six-bar", "jansen-leg", "rolling-on-flat", "whitworth")))
def test_redundant_closures_change_nothing_and_are_counted(name: str) -> None:
    end = duration(name)
    times = np.linspace(0.0, end, 40)
    machine = driven(name, closed_once_more(model_text(name)), end)
    assert worst(machine, exact_points(name, times), times, abs(scene(name).speed)) < BAR
    found = mobility(machine)
    connects = sum(closure.kind == "connect" for closure in machine.tree.closures) // 3
    # The one across the plane, of each; and all of those that say it again.
    assert found.left == 1
    assert found.rank == machine.tree.freedom - 1
    assert sum(found.redundant.values()) == found.rows - found.rank == 7 * connects
    assert {name.split()[0] for name in found.redundant if " " in name} == {"again", "swapped"}
    assert found.idle == found.undetermined == ()


@pytest.mark.parametrize(
    "name", slow_but_for(("planetary-gear",), ("six-bar", "jansen-leg", "planetary-gear", "whitworth"))
)
def test_the_branch_is_kept_for_two_turns(name: str) -> None:
    end = 2.0 * duration(name)
    machine = driven(name, model_text(name), end)
    times = np.linspace(0.0, end, 60)
    assert worst(machine, exact_points(name, times), times, abs(scene(name).speed)) < BAR
