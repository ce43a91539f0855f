"""The crank and the observed points of a model, found by their names where a user gives none."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import conrod

from conrod.errors import InvalidInput
from conrod.execution.resolve_arguments import select_scene
from conrod.mechanism.mechanism import Mechanism
from conrod.models.check.guessing import find_names

CASES = Path(__file__).parents[1] / "data" / "cases"
MODELS = Path(__file__).parents[2] / "mjcf"
FOUR_BAR = (CASES / "four-bar-open.xml").read_text(encoding="utf-8")


def meant() -> Mechanism:
    mechanism: Mechanism = select_scene(str(CASES / "anchor-apart-meant.toml"), ())[1].mechanism()
    return mechanism


def test_names_of_the_scene_tell_crank_and_points() -> None:
    found = find_names(CASES / "four-bar-short.xml", meant(), None, {})
    assert found == ("crank", {"P": "site:P"})
    saw = select_scene("saw-500rpm", ())[1].mechanism()
    found = find_names(MODELS / "saw-500rpm.xml", saw, None, {})
    assert found == ("crank", {"C": "site:C", "M": "site:M"})


def test_the_only_site_of_a_link_is_its_point() -> None:
    assert find_names(CASES / "anchor-apart.xml", meant(), None, {})[1] == {"P": "site:coupler_end"}


def test_what_is_given_is_not_found_again() -> None:
    found = find_names(CASES / "four-bar-short.xml", meant(), "rocker", {"P": "body:coupler"})
    assert found == ("rocker", {"P": "body:coupler"})


def test_hinges_that_no_name_tells_apart_are_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "bar.xml"
    file.write_text(FOUR_BAR.replace('name="crank"', 'name="left"'), encoding="utf-8")
    with pytest.raises(InvalidInput, match="--crank JOINT, one of left, rocker"):
        find_names(file, meant(), None, {})
    # A motor tells which one.
    motor = '<actuator><motor joint="left"/></actuator></mujoco>'
    file.write_text(FOUR_BAR.replace('name="crank"', 'name="left"').replace("</mujoco>", motor), encoding="utf-8")
    assert find_names(file, meant(), None, {})[0] == "left"


def test_an_unknown_place_of_a_point_is_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "bar.xml"
    text = FOUR_BAR.replace('"P"', '"end"').replace('name="coupler"', 'name="rod"')
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"--point P=site:NAME, for one of end, R"):
        find_names(file, meant(), None, {})


@pytest.mark.parametrize(("joint", "asked"), [
    ('<joint name="slide" type="slide"/>', "say which joint of the model is driven: --crank JOINT; it has no hinge on "
     "the ground"),
    ('<joint name="turn"/>', "say where an observed point of the scene is: --point P=body:NAME, for one of arm, hand"),
])  # fmt: skip
def test_what_a_model_lacks_is_said_where_names_tell_nothing(joint: str, asked: str, tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(
        f'<mujoco><worldbody><body name="arm">{joint}<geom size="0.1" mass="1"/><body name="hand"><geom size="0.1" '
        'mass="1"/></body></body></worldbody></mujoco>',
        encoding="utf-8",
    )
    with pytest.raises(InvalidInput) as refused:
        find_names(file, meant(), None, {})
    assert str(refused.value) == asked


@pytest.mark.usefixtures("at_once")
def test_a_short_coupler_is_named_without_more_options() -> None:
    done = conrod("check", str(CASES / "four-bar-short.xml"), "--scene", str(CASES / "anchor-apart-meant.toml"))
    assert done.returncode == 1
    words = " ".join(done.stdout.split())
    assert "coupler is 42.3 % shorter from pin a to pin b: 150 mm instead of 260 mm" in words
    assert "a dead centre" not in words
    assert "(taken as --crank crank --point P=site:P)" in words
