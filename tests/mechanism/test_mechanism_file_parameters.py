"""A scene from a file: its numbers by name and place, changed and refused by them, and what a ledger knows it by."""

from __future__ import annotations

import json
import math
import pickle
import re
import tomllib
from pathlib import Path

import pytest
from described import FOUR_BAR, SLIDER_CRANK, shuffle_declarations, tables, with_entry

from conrod import MuJoCoSettings, Saw
from conrod.errors import InvalidInput
from conrod.execution.run import RunCase
from conrod.execution.tolerances import EXAMPLES
from conrod.mechanism.units import FACTORS, _unit_registry, parse_quantity
from conrod.scenes.described_scene import DescribedScene, read_scene, scene_from_tables

DOCS = Path(__file__).parents[2] / "docs" / "mechanism-files.md"
EXAMPLE = re.findall(r"```toml\n(name = .*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)[0]
PARAMETERS = '[parameters]\ncrank = "80 mm"\ncoupler = "250 mm"\n\n'
PLAIN = EXAMPLE.replace(PARAMETERS, "").replace('"crank", 0]', '"80 mm", 0]').replace('"coupler", 0]', '"250 mm", 0]')


def test_text_for_a_number_of_a_class_is_answered_with_scene() -> None:
    said = "crank = '80 mm' is not a finite number of m; conrod.scene(NAME, ..) takes text with units"
    with pytest.raises(InvalidInput, match=re.escape(said)):
        Saw(crank="80 mm")  # type: ignore[arg-type]
    # Negative control: a number that is none has no unit to blame.
    with pytest.raises(InvalidInput, match=r"crank = nan is not a finite number$"):
        Saw(crank=math.nan)


@pytest.fixture
def write(tmp_path: Path) -> Path:
    return tmp_path / "machine.toml"


def scene_of_text(text: str, file: Path) -> DescribedScene:
    file.write_text(text, encoding="utf-8")
    return read_scene(file)


def test_named_number_makes_same_machine_with_same_key(write: Path) -> None:
    named, plain = scene_of_text(EXAMPLE, write), scene_of_text(PLAIN, write)
    assert "[parameters]" not in PLAIN
    assert named.parameters_text == plain.parameters_text
    assert list(named.parameters)[:2] == ["coupler", "crank"]
    # Its place is no parameter beside it, and all others are as before.
    assert set(plain.parameters) - set(named.parameters) == {"bodies.crank.points.A.x", "bodies.coupler.points.B.x"}
    longer = named.with_parameters(crank=0.085)
    assert longer.parameters_text == plain.with_parameters(**{"bodies.crank.points.A.x": 0.085}).parameters_text
    assert longer.parameters_text != plain.parameters_text
    assert named.parameter_facts()["crank"].unit == "m"


def test_parameter_in_several_places_changes_all_of_them(write: Path) -> None:
    text = EXAMPLE.replace('["300 mm", 0]', '["base", "-lift"]').replace(
        PARAMETERS, PARAMETERS[:-1] + 'base = "frame"\nframe = "300 mm"\nlift = "10 mm"\n\n'
    )
    text = text.replace('speed = "120 rpm"', 'speed = "rate"').replace("lift = ", 'rate = "120 rpm"\nlift = ')
    text = text.replace('P = ["150 mm", "100 mm"]', 'P = ["150 mm", "lift"]')
    scene = scene_of_text(text, write).with_parameters(lift=0.02, base=0.31, rate=13.0)
    assert scene.mechanism().joints[-1].name == "pivot"
    points = json.loads(scene.parameters_text)["mechanism"]
    assert [0.31, -0.02] in [joint.get("point_a") for joint in points["joints"]]
    assert [0.15, 0.02] in [one["point"] for one in points["observed"]]
    assert scene.speed == 13.0
    # Studies change the speed of every scene by this name.
    assert scene.with_parameters(speed=12.0).speed == 12.0


REFUSED = {
    "an unknown name": ('["crank", 0]', '["crnk", 0]', "bodies.crank.points.A.x 'crnk': did you mean 'crank'?"),
    "a cycle": ('"250 mm"\n', '"-coupler"\n', "parameters.coupler: it leads back to itself"),
    "another unit": ('crank = "80 mm"', 'crank = "80 deg"', "'deg' is not a unit of m"),
    "two units": ('mass = "3 kg"', 'mass = "crank"', "it is in kg, but parameters.crank is in m elsewhere"),
    "out of range": ('mass = "3 kg"', 'mass = "m"', "bodies.crank.mass = -3 kg is out of range"),
    "no use": ('["coupler", 0]', '["250 mm", 0]', "parameters.coupler: nothing in the file uses it"),
    "the speed": ('coupler = "250', 'speed = "250', "parameters.speed: all machines call"),
    "no number": ('"80 mm"\n', "true\n", "parameters.crank = true is not a number"),
    "an unknown field": ('radius = "90 mm"', 'radios = "90 mm"', "is 'radios' meant for it"),
    "a field too many": ('mass = "3 kg"', 'mass = "3 kg"\nmas = 3', "in bodies.crank 'mas'"),
}


@pytest.mark.parametrize("defect", REFUSED)
def test_parameter_error_names_the_place(defect: str, write: Path) -> None:
    old, new, message = REFUSED[defect]
    assert EXAMPLE.count(old) == 1
    text = EXAMPLE.replace(old, new)
    if defect == "out of range":
        text = text.replace("[parameters]\n", '[parameters]\nm = "-3 kg"\n')
    with pytest.raises(InvalidInput, match=re.escape(message)):
        scene_of_text(text, write)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.02 kg m2", "kg*m^2", 0.02),
        ("20 g*m2", "kg*m^2", 0.02),
        ("9.81 m/s2", "m/s^2", 9.81),
        ("9.81 m*s**-2", "m/s^2", 9.81),
        ("0.5 kg m²", "kg*m^2", 0.5),
        ("180°", "rad", math.pi),
        ("5 µs", "s", 5e-6),
        ("5 us", "s", 5e-6),
        ("3 N m s/rad", "N*m*s/rad", 3.0),
        ("2 N s/mm", "N*s/m", 2000.0),
        ("60 r/min", "rad/s", 2.0 * math.pi),
        ("60RPM", "rad/s", 2.0 * math.pi),
        ("5Nm", "N*m", 5.0),
        ("1.2 kNm", "N*m", 1200.0),
        ("200 Ncm", "N*m", 2.0),
        ("7 Nmm", "N*m", 0.007),
        ("4 Nm/rad", "N*m/rad", 4.0),
        ("0.3 Nms/rad", "N*m*s/rad", 0.3),
    ],
)
def test_unit_spellings_are_equal(text: str, unit: str, value: float) -> None:
    assert parse_quantity("it", text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["8.3 Hz", "500 min-1", "500 1/min", "52 s^-1", "52 1/s", "5 s^-2"])
def test_rate_of_turns_or_radians_is_refused(text: str) -> None:
    unit = "rad/s^2" if text.endswith("-2") else "rad/s"
    with pytest.raises(InvalidInput, match="may mean turns or radians; give rpm"):
        parse_quantity("speed", text, unit)


@pytest.mark.parametrize("unit", EXAMPLES)
def test_examples_of_tolerances_are_quantities(unit: str) -> None:
    assert parse_quantity("it", EXAMPLES[unit], unit) > 0.0


def test_common_factors_are_those_of_pint() -> None:
    registry = _unit_registry()
    for (written, unit), factor in FACTORS.items():
        of_pint = registry.parse_units(written)
        for value in (*range(1, 400), *(k / 100 for k in range(-400, 400))):
            assert registry.Quantity(float(value), of_pint).to(unit).magnitude == value * factor


@pytest.mark.parametrize(("text", "unit"), [("1 kg m3", "kg*m^2"), ("1 m2", "m"), ("1 m23", "m"), ("1 m-", "m")])
def test_unit_of_another_power_is_refused(text: str, unit: str) -> None:
    with pytest.raises(InvalidInput):
        parse_quantity("it", text, unit)


def test_the_documented_example_is_a_mechanism() -> None:
    scene = scene_from_tables(tomllib.loads(EXAMPLE))
    assert (scene.kind, scene.output, scene.mechanism().driver.span) == ("crank-rocker", "P", None)
    assert scene.speed == pytest.approx(4.0 * math.pi)
    assert scene.mechanism().body("rocker").inertia == pytest.approx(0.9 * 0.2**2 / 12.0)
    assert scene.kinematics.turns_fully


def test_numbers_are_parameters_by_their_place() -> None:
    scene = read_scene(SLIDER_CRANK)
    assert scene.parameters["bodies.crank.points.A.x"] == 0.3
    assert scene.parameters["speed"] == 30.0
    assert scene.parameter_facts()["bodies.rod.mass"].unit == "kg"
    assert scene.parameters.keys() == scene.parameter_facts().keys()


def test_replaced_parameter_changes_motion() -> None:
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
def test_invalid_parameter_is_refused(name: str, value: float, expected: str) -> None:
    with pytest.raises(InvalidInput, match=expected):
        read_scene(SLIDER_CRANK).with_parameters(**{name: value})


def key(scene: DescribedScene) -> str:
    return RunCase("any", scene, MuJoCoSettings.stock(scene, 100)).key


def test_run_key_follows_mechanism_not_names() -> None:
    scene = read_scene(SLIDER_CRANK)
    same = [
        scene_from_tables(shuffle_declarations(tables(SLIDER_CRANK), 3)),
        scene_from_tables(with_entry(SLIDER_CRANK, "title", "Another title")),
        scene_from_tables(with_entry(SLIDER_CRANK, "bodies.crank.points.A", [0.3, "0 mm"])),
        pickle.loads(pickle.dumps(scene)),
    ]
    assert {key(other) for other in same} == {key(scene)}
    other_machines = [
        scene.with_parameters(**{"bodies.rod.mass": 5.5}),
        scene_from_tables(with_entry(SLIDER_CRANK, "start.rod.turn", "180 deg")),
        scene_from_tables(with_entry(SLIDER_CRANK, "observed.G", "rod.A")),
        read_scene(FOUR_BAR),
    ]
    assert len({key(other) for other in other_machines} | {key(scene)}) == 1 + len(other_machines)


def test_braces_in_a_text_stay_literal() -> None:
    scene = scene_from_tables(with_entry(SLIDER_CRANK, "description", "A {crank} of {0.__class__}."))
    assert scene.description.format().startswith("A {crank} of {0.__class__}.")
