"""Mechanism files on the command line, taken where scenes are, and the slips that users make in them."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from command_line import conrod, refusal
from described import FOUR_BAR, SLIDER_CRANK
from table_files import written

TEXT = SLIDER_CRANK.read_text(encoding="utf-8")


def with_first(pattern: str, replacement: str) -> str:
    text, count = re.subn(pattern, lambda found: replacement, TEXT, count=1)
    assert count == 1, pattern
    return text


def test_a_file_is_validated_in_both_engines(tmp_path: Path) -> None:
    file = str(written(tmp_path, TEXT, "own.toml"))
    done = conrod("validate", file, "--preset", "tuned", "--steps-per-rev", "100", "--json", "r.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (part,) = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))["parts"].values()
    ends = {(one["scene"], one["engine"], one["outcome"]) for one in part["findings"]["results"]}
    assert ends == {("slider-crank", engine, "completed") for engine in ("mujoco", "pymunk")}


SLIPS = {
    "a name that is taken": (with_first('name = "slider-crank"', 'name = "saw-40rpm"'), "is taken by another scene"),
    "a name of no file": (with_first('name = "slider-crank"', 'name = "a/b"'), "cannot be a name"),
    "decimal comma in a text": (with_first(r'speed = "[^"]*"', 'speed = "60,5 rpm"'), "driver.speed = '60,5 rpm': dec"),
    "start forgotten": (with_first(r"(?s)\[start\].*?(?=\n\[|\Z)", ""), "or the same of"),
    "slide as the driver": (with_first(r'joint = "[^"]*"', 'joint = "slide"'), "ground is wanted; here "),
    "two points, no output": (f'{TEXT.replace("output =", "# output =")}\n', "no 'output', which is needed with sev"),
    "lengths that do not reach": (
        re.sub(r'(B = \[)"?[\d.]+ ?m*"?', r'\1"9 m"', FOUR_BAR.read_text(encoding="utf-8"), count=1),
        "cannot be assembled at crank angle 0 deg: lengths do not reach",
    ),
}  # fmt: skip


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_told_in_one_line(slip: str, tmp_path: Path) -> None:
    text, told = SLIPS[slip]
    path = written(tmp_path, text, "own.toml")
    line = refusal("show", str(path))
    assert line.startswith(f"conrod: {path}: ")
    assert told in line


def test_show_tells_description_and_assumptions_and_takes_no_text_for_markup(tmp_path: Path) -> None:
    text = with_first(r"(?m)^source = .*$", 'source = "a [/b] source [red] <b> & -- c -->"')
    text = re.sub(r'(?ms)^description = (""".*?"""|[^\n]*)\n|^assumptions = \[.*?^\]\n', "", text)
    told = 'description = "A [bold] {speed} machine [/x]."\nassumptions = ["no friction [/y]", "stiff links"]\n'
    path = str(written(tmp_path, f"{told}{text}", "own.toml"))
    shown = conrod("show", path, "--set", "bodies.rod.points.B.x=600mm", "--set", "speed=20rpm").stdout
    assert "source: a [/b] source [red] <b> & -- c -->" in shown
    assert "A [bold] {speed} machine [/x]." in shown
    assert "assumed:\n  - no friction [/y]\n  - stiff links\n" in shown
    assert re.search(r"slider +slide +600 mm +0, 180 ", shown)
    assert "references: generic Newton solver" in shown
    # Negative control: a scene in closed form has both rulers.
    assert "references: closed form" in conrod("show", "saw-40rpm").stdout
    # Nor does a model.
    assert ET.fromstring(conrod("export", path, "--format", "mjcf").stdout).tag == "mujoco"
