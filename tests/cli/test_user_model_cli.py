"""`conrod validate MODEL.xml`: what a user types, sees and gets, and what is said of models that cannot be used."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import conrod
from own_model_edits import HACKSAW, ROD_END, TEXTS, replaced

ASKED = ("--scene", "saw-40rpm", "--crank", "motor", "--point", "C=body:bow", "--point", "M=geom:rod")


def validate(*arguments: object) -> tuple[int, str]:
    done = conrod("validate", *map(str, arguments))
    return done.returncode, done.stdout


def test_a_users_model_is_judged_reported_and_left_as_it_is(tmp_path: Path) -> None:
    file = tmp_path / "my saw.xml"
    file.write_text(HACKSAW.read_text())
    out, document = tmp_path / "report", tmp_path / "result.json"
    status, told = validate(file, *ASKED, "--revolutions", 1, "--out", out, "--json", document)
    assert status == 0, told
    assert "It is saw-40rpm" in told
    assert "plane xz, turned by 0 deg, crank zero at 90 deg, unit m" in told
    assert file.read_text() == HACKSAW.read_text()
    part = json.loads(document.read_text())["parts"]["my saw"]
    assert part["summary"]["passed"]
    assert part["findings"]["identity"]["frame"]["zero"] == pytest.approx(1.5707963267948966)
    assert set(part["findings"]["runs"]) == {"as it is", "tuned", "hardened"}
    assert json.loads((out / "data/my saw.json").read_text()) == part["findings"]
    assert "crank zero at 90 deg" in (out / "README.md").read_text()  # with all digits, as on the console


@pytest.mark.usefixtures("at_once")
def test_a_model_that_is_not_the_machine_has_exit_status_1_and_its_length_named(tmp_path: Path) -> None:
    file = tmp_path / "saw.xml"
    file.write_text(replaced(TEXTS["saw"], ROD_END, 'name="slider-pin.rod" pos="0.30003 0 0"'))
    asked = ("--scene", "saw-40rpm", "--crank", "crank", "--point", "C=C", "--revolutions", 1)
    status, told = validate(file, *asked)
    assert status == 1
    assert "It is not saw-40rpm as it stands: rod is 0.01 % too long: 300.03 mm instead of 300 mm." in told
    assert "not given, so not judged: M" in told
    # Negative control: a machine with such a rod is what it is.
    status, told = validate(file, *asked, "--set", "rod=300.03mm")
    assert status == 0, told
