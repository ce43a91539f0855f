"""Mechanism files on the command line, taken where scenes are, and the slips that users make in them."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from command_line import conrod
from described import FOUR_BAR, SLIDER_CRANK

from conrod.errors import InvalidInput
from conrod.scenes.described_scene import read_scene

TEXT = SLIDER_CRANK.read_text(encoding="utf-8")


def written(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "own.toml"
    path.write_bytes(text.encode(encoding))
    return path


def with_first(pattern: str, replacement: str) -> str:
    text, count = re.subn(pattern, lambda found: replacement, TEXT, count=1)
    assert count == 1, pattern
    return text


def test_a_file_is_validated_in_both_engines(tmp_path: Path) -> None:
    document = tmp_path / "results.json"
    done = conrod(
        "validate", str(written(tmp_path, TEXT)), "--preset", "tuned", "--steps-per-rev", "100", "--json", str(document)
    )
    assert done.returncode == 0, done.stderr
    (part,) = json.loads(document.read_text(encoding="utf-8"))["parts"].values()
    results = part["findings"]["results"]
    assert {(r["scene"], r["engine"]) for r in results} == {("slider-crank", "mujoco"), ("slider-crank", "pymunk")}
    assert {r["outcome"] for r in results} == {"completed"}


def test_a_file_is_shown_with_its_numbers_given_anew() -> None:
    done = conrod("show", str(SLIDER_CRANK), "--set", "bodies.rod.points.B.x=600mm", "--set", "speed=20rpm")
    assert done.returncode == 0, done.stderr
    assert re.search(r"slider +slide +600 mm +0, 180 ", done.stdout)
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
    path = str(written(tmp_path, with_first("course module", "a <b> & -- c -->")))
    model = ET.fromstring(conrod("export", path, "--format", "mjcf").stdout)
    assert model.tag == "mujoco"


@pytest.mark.parametrize(
    ("name", "expected"),
    [("saw-40rpm", "is taken by another scene"), ("a/b", "cannot be a name")],
)
def test_a_name_that_reports_could_not_use_is_refused(tmp_path: Path, name: str, expected: str) -> None:
    done = conrod("show", str(written(tmp_path, with_first('name = "slider-crank"', f'name = "{name}"'))))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert expected in done.stderr


# -- slips ------------------------------------------------------------------------------------------------------------


SLIPS = {
    "decimal comma in a text": (with_first(r'speed = "[^"]*"', 'speed = "60,5 rpm"'), "driver.speed = '60,5 rpm': dec"),
    "start forgotten": (with_first(r"(?s)\[start\].*?(?=\n\[|\Z)", ""), "or the same of"),
    "slide as the driver": (with_first(r'joint = "[^"]*"', 'joint = "slide"'), "ground is wanted; here "),
    "two points, no output": (f'{TEXT.replace("output =", "# output =")}\n', "no 'output', which is needed with sev"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "told"), SLIPS.values(), ids=SLIPS.keys())
def test_a_slip_is_told_in_one_line(tmp_path: Path, text: str, told: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InvalidInput) as refusal:
        read_scene(path)
    message = str(refusal.value)
    assert message.startswith(f"{path}: ")
    assert told in message
    assert "\n" not in message


def test_lengths_that_do_not_reach_are_told_at_the_start(tmp_path: Path) -> None:
    text = re.sub(r'(B = \[)"?[\d.]+ ?m*"?', r'\1"9 m"', FOUR_BAR.read_text(encoding="utf-8"), count=1)
    with pytest.raises(InvalidInput, match="cannot be assembled at crank angle 0 deg: lengths do not reach"):
        read_scene(written(tmp_path, text))


# -- show ------------------------------------------------------------------------------------------------------------


def test_show_tells_description_and_assumptions_and_takes_no_text_for_markup(tmp_path: Path) -> None:
    text = with_first(r"(?m)^source = .*$", 'source = "a [/b] source [red]"')
    text = re.sub(r'(?ms)^description = (""".*?"""|[^\n]*)\n|^assumptions = \[.*?^\]\n', "", text)
    told = 'description = "A [bold] {speed} machine [/x]."\nassumptions = ["no friction [/y]", "stiff links"]\n'
    path = written(tmp_path, f"{told}{text}")
    done = conrod("show", str(path))
    assert done.returncode == 0, done.stderr
    assert "source: a [/b] source [red]" in done.stdout
    assert "A [bold] {speed} machine [/x]." in done.stdout
    assert "assumed:\n  - no friction [/y]\n  - stiff links\n" in done.stdout
    assert done.stdout.index("frame: ") < done.stdout.index("assumed:") < done.stdout.index("parameter ")
