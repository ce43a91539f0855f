"""Numbers of a mechanism file that can hardly be meant are refused, with what is likely; healthy files are not."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from described import FOUR_BAR, SHIPPED, SLIDER_CRANK, with_entry

from conrod.errors import InvalidInput
from conrod.execution.resolve_arguments import mechanism_file_bytes, scene
from conrod.mechanism.files import read_description, read_tables
from conrod.mechanism.units import parse_quantity
from conrod.scenes.described_scene import read_scene, scene_from_tables


def refusal(given: dict[str, Any]) -> str:
    with pytest.raises(InvalidInput) as told:
        scene_from_tables(given)
    assert "\n" not in str(told.value)
    return str(told.value)


# What is changed of the slider-crank, and what is said.
ANGLES: dict[str, tuple[str, Any, str]] = {
    "start of the crank": ("driver.start", 60, "60 has no unit and would be radians, 3438 deg: write 60deg"),
    "text without unit": ("driver.start", "60", "write 60deg if degrees are meant, 60rad if not"),
    "negative": ("driver.start", -45.5, "write -45.5deg"),
    "just over a turn": ("driver.start", 6.3, "write 6.3deg"),
    "direction of a slide": ("joints.slide.direction", 180, "joints.slide.direction = 180 has no unit"),
    "turn of a slider": ("joints.slide.angle", 90, "joints.slide.angle = 90 has no unit"),
    "turn at the start": ("start.rod.turn", 30, "start.rod.turn = 30 has no unit"),
    "end of a pass": ("driver.to", 20, "driver.to = 20 has no unit"),
    "rest of a spring": ("springs.s", {"turns": ["ground", "crank"], "stiffness": 1, "rest": 90}, "rest = 90"),
    "direction of a force": (
        "forces.f", {"point": "slider", "direction": 270, "law": "constant", "force": 1}, "forces.f.direction = 270",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", ANGLES)
def test_bare_angle_of_more_than_a_turn_is_refused(case: str) -> None:
    place, value, said = ANGLES[case]
    given = with_entry(SLIDER_CRANK, place, value)
    if case == "end of a pass":
        given["driver"]["from"] = -0.5
    assert said in refusal(given)


def test_bare_angle_in_parameter_or_option_is_refused() -> None:
    given = with_entry(SLIDER_CRANK, "driver.start", "zero")
    given.setdefault("parameters", {})["zero"] = 60
    assert "driver.start = 60 has no unit" in refusal(given)
    given["parameters"]["zero"] = "60 deg"
    scene_from_tables(given)
    with pytest.raises(InvalidInput, match="--rotation = 90 has no unit"):
        parse_quantity("--rotation", "90", "rad")
    assert parse_quantity("--rotation", "6.28", "rad") == 6.28


def test_angle_with_unit_or_below_a_turn_is_accepted() -> None:
    for value in ("60 deg", "60deg", "-6.2", 6.28, "7 rad", 0):
        scene_from_tables(with_entry(SLIDER_CRANK, "driver.start", value))


PROPORTIONS: dict[str, tuple[str, Any, str]] = {
    "centre of gravity in mm": ("bodies.rod.centre_of_gravity", [50, 0], "is mm meant"),
    "centre of gravity in mm, across": ("bodies.rod.centre_of_gravity", ["0.2 m", -80], "from the points of rod"),
    "centre of gravity with a wrong unit": (
        "bodies.rod.centre_of_gravity",
        ["50 m", 0],
        "49.4 m from the points of rod",
    ),
    "length in mm": ("bodies.rod.points.B", [560, 0], 'write "560 mm" if mm is meant, "560 m" if not'),
    "length with a wrong unit": ("bodies.rod.points.B", ["560 m", 0], "times the largest other length"),
    "place on the ground in mm": ("ground.points.O", [0, 300], 'write "300 mm" if mm is meant'),
    "mass in g": ("bodies.slider.mass", 2500, 'write "2500 g" if g is meant, "2500 kg" if not'),
    "mass with a wrong unit": ("bodies.slider.mass", "2500 t", "is g meant?"),
    "inertia in kg mm^2": ("bodies.rod.inertia", 130000, "is kg*mm^2 or kg*cm^2 meant?"),
    "inertia in kg cm^2": ("bodies.rod.inertia", 1300, "is a radius of gyration of 16.1 m, in a machine of 0.56 m"),
    "inertia with a wrong unit": ("bodies.rod.inertia", "13000 kg*m^2", "is kg*mm^2 or kg*cm^2 meant?"),
}


@pytest.mark.parametrize("case", PROPORTIONS)
def test_number_out_of_proportion_is_refused_with_likely_unit(case: str) -> None:
    place, value, said = PROPORTIONS[case]
    given = with_entry(SLIDER_CRANK, place, value)
    rod = given["bodies"]["rod"]
    if "gravity" in place or "inertia" in place:
        del rod["uniform"], rod["ends"]
        rod.setdefault("inertia", "0.13 kg*m^2")
    assert place in refusal(given)
    assert said in refusal(given)


def test_machine_in_bare_mm_is_refused_as_metres() -> None:
    given = with_entry(FOUR_BAR, "name", "four-bar-in-mm")

    def in_mm(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: in_mm(one) for key, one in value.items()}
        if isinstance(value, list) and len(value) == 2 and all(isinstance(one, (int, float, str)) for one in value):
            return [1e3 * parse_quantity("x", str(one), "m") if _is_length(one) else one for one in value]
        return value

    def _is_length(one: Any) -> bool:
        return isinstance(one, (int, float)) or one.endswith("m")

    for table in ("bodies", "ground"):
        given[table] = in_mm(given[table])
    assert "if mm is meant" in refusal(given)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_files_are_in_proportion(path: Path) -> None:
    assert read_description(read_tables(path), {}).values


@pytest.mark.parametrize("count", [2, 21, 40])
def test_ground_points_as_far_as_all_links_are_accepted(count: int) -> None:
    assert len(scene(f"four-bar-chain-{count}").mechanism().bodies) == 2 * count + 1


def test_ground_points_beyond_all_links_are_refused() -> None:
    written = mechanism_file_bytes("four-bar-chain-40")
    assert written is not None
    machine = tomllib.loads(written.decode().replace("O40 = [40, 0]", "O40 = [82, 0]"))
    assert 'O40.x = 82 m is 82 times the largest other length, 1 m: write "82 mm"' in refusal(machine)


def test_flywheels_and_light_links_are_in_proportion() -> None:
    for place, value in (("bodies.slider.mass", 300), ("bodies.slider.mass", 1e-6), ("bodies.rod.mass", "1 g")):
        scene_from_tables(with_entry(SLIDER_CRANK, place, value))
    # What is given anew is the user's own variant of a file in proportion.
    assert (
        read_scene(SLIDER_CRANK).with_parameters(**{"bodies.slider.mass": 1e4}).mechanism().body("slider").mass == 1e4
    )
