"""A scene from a file is a scene like those that ship: parameters, identity, engines; its format is documented."""

from __future__ import annotations

import math
import pickle
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from described import FOUR_BAR, SLIDER_CRANK, changed, shuffled, tables

import conrod
from conrod import MuJoCoSettings
from conrod.errors import InvalidInput
from conrod.scenes.described_scene import DescribedScene, read_scene, scene_of
from conrod.studies.frame.run import RunCase

DOCUMENT = Path(conrod.__file__).parents[2] / "docs" / "mechanism-files.md"


def example() -> dict[str, Any]:
    """The example of the documentation, its first block of TOML; others show a part of a file."""
    text, *_ = re.findall(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    return tomllib.loads(text)


# -- format ----------------------------------------------------------------------------------------------------------


def test_the_documented_example_is_a_mechanism() -> None:
    scene = scene_of(example())
    assert (scene.kind, scene.output, scene.mechanism().driver.span) == ("crank-rocker", "P", None)
    assert scene.speed == pytest.approx(4.0 * math.pi)
    assert scene.mechanism().body("rocker").inertia == pytest.approx(0.9 * 0.2**2 / 12.0)
    assert scene.kinematics.turns_fully


# -- scene -----------------------------------------------------------------------------------------------------------


def test_numbers_are_parameters_by_their_place() -> None:
    scene = read_scene(SLIDER_CRANK)
    assert scene.parameters["bodies.crank.points.A.x"] == 0.3
    assert scene.parameters["speed"] == 30.0
    assert scene.parameter_facts()["bodies.rod.mass"].unit == "kg"
    assert scene.parameters.keys() == scene.parameter_facts().keys()


def test_a_parameter_given_anew_moves_the_machine() -> None:
    scene = read_scene(SLIDER_CRANK).with_parameters(**{"bodies.rod.points.B.x": 0.6})
    assert scene.motion(0.0, 30.0).point("B").position[0, 0] == pytest.approx(0.9)
    assert scene.mechanism().body("rod").inertia == pytest.approx(5.0 * 0.6**2 / 12.0)
    assert scene.with_parameters(speed=-3.0).speed == -3.0
    assert scene.with_parameters(speed=-3.0).parameters["bodies.rod.points.B.x"] == 0.6


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("bodies.rod.points.B.z", 0.6, "unknown parameter 'bodies.rod.points.B.z'"),
        ("bodies.rod.mass", -1.0, "out of range"),
        ("bodies.rod.mass", math.nan, "not a finite number"),
        ("bodies.rod.points.B.x", 0.2, "cannot be assembled|cannot turn fully"),
    ],
)
def test_a_parameter_that_cannot_be_is_refused(name: str, value: float, expected: str) -> None:
    with pytest.raises(InvalidInput, match=expected):
        read_scene(SLIDER_CRANK).with_parameters(**{name: value})


def key(scene: DescribedScene) -> str:
    return RunCase("any", scene, MuJoCoSettings.stock(scene, 100)).key


def test_a_ledger_knows_a_run_by_its_mechanism() -> None:
    scene = read_scene(SLIDER_CRANK)
    same = [
        scene_of(shuffled(tables(SLIDER_CRANK), 3)),
        scene_of(changed(SLIDER_CRANK, "title", "Another title")),
        scene_of(changed(SLIDER_CRANK, "bodies.crank.points.A", [0.3, "0 mm"])),
        pickle.loads(pickle.dumps(scene)),
    ]
    assert {key(other) for other in same} == {key(scene)}
    other_machines = [
        scene.with_parameters(**{"bodies.rod.mass": 5.5}),
        scene_of(changed(SLIDER_CRANK, "start.rod.turn", "180 deg")),
        scene_of(changed(SLIDER_CRANK, "observed.G", "rod.A")),
        read_scene(FOUR_BAR),
    ]
    assert len({key(other) for other in other_machines} | {key(scene)}) == 1 + len(other_machines)


def test_braces_in_a_text_are_not_filled_in() -> None:
    scene = scene_of(changed(SLIDER_CRANK, "description", "A {crank} of {0.__class__}."))
    assert scene.description.format().startswith("A {crank} of {0.__class__}.")
