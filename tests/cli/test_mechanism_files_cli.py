"""Mechanism files on the command line: taken where scenes are."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from conrod.studies.frame.resolve_arguments import select_scenes
from tests.support.command_line import conrod
from tests.support.described import FOUR_BAR, SLIDER_CRANK


def edited(folder: Path, *changes: tuple[str, str]) -> str:
    """A copy of the slider-crank with some of its text changed."""
    text = SLIDER_CRANK.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_file_is_validated_in_both_engines(tmp_path: Path) -> None:
    document = tmp_path / "results.json"
    done = conrod("validate", edited(tmp_path), "--preset", "tuned", "--steps-per-rev", "200", "--json", str(document))
    assert done.returncode == 0, done.stderr
    (part,) = json.loads(document.read_text(encoding="utf-8"))["parts"].values()
    results = part["findings"]["results"]
    assert {(r["scene"], r["engine"]) for r in results} == {("slider-crank", "mujoco"), ("slider-crank", "pymunk")}
    assert {r["outcome"] for r in results} == {"completed"}


def test_a_file_is_shown_with_its_numbers_given_anew() -> None:
    done = conrod("show", str(SLIDER_CRANK), "--set", "bodies.rod.points.B.x=600mm", "--set", "speed=20rpm")
    assert done.returncode == 0, done.stderr
    assert "dead centre of B: 0.0000 deg, at (900, 0) mm" in done.stdout
    assert "references: generic Newton solver" in done.stdout
    # Negative control: a scene in closed form has both rulers.
    assert "references: closed form" in conrod("show", "saw-40rpm").stdout


def test_a_pass_is_exported_from_its_start_to_its_end() -> None:
    rows = conrod("export", str(FOUR_BAR), "--format", "csv", "--steps-per-rev", "360").stdout.splitlines()
    first, last = (
        dict(zip(rows[0].split(","), map(float, row.split(",")), strict=True)) for row in (rows[1], rows[-1])
    )
    assert len(rows) == 1 + 71
    assert (first["crank_angle [rad]"], last["crank_angle [rad]"]) == pytest.approx((-0.1745329, 1.0471976))
    # Time 0 is that of crank angle 0, as in runs.
    assert (first["time [s]"], last["time [s]"]) == pytest.approx((-0.1745329 / 60.0, 1.0471976 / 60.0))


def test_a_model_is_exported_whatever_its_texts(tmp_path: Path) -> None:
    path = edited(tmp_path, ("course module", "a <b> & -- c -->"))
    model = ET.fromstring(conrod("export", path, "--format", "mjcf").stdout)
    assert model.tag == "mujoco"


def test_a_file_goes_by_its_own_name(tmp_path: Path) -> None:
    assert list(select_scenes([str(FOUR_BAR), "saw-40rpm"], [])) == ["swinging-four-bar", "saw-40rpm"]


@pytest.mark.parametrize(
    ("name", "expected"),
    [("saw-40rpm", "is taken by another scene"), ("a/b", "cannot be a name"), ("..", "cannot be a name")],
)
def test_a_name_that_reports_could_not_use_is_refused(tmp_path: Path, name: str, expected: str) -> None:
    done = conrod("show", edited(tmp_path, ('name = "slider-crank"', f'name = "{name}"')))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert expected in done.stderr


def test_a_file_that_cannot_be_read_is_told_in_one_line(tmp_path: Path) -> None:
    for command in (["show"], ["validate"], ["export", "--format", "csv"]):
        done = conrod(*command, str(tmp_path / "none.toml"))
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert "none.toml: it cannot be read" in done.stderr
