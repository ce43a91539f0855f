"""`conrod validate MODEL.xml`: what a user types, sees and gets, and what is said of models that cannot be used."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

import pytest
from command_line import conrod
from own_model_edits import HACKSAW, ROD_END, TEXTS, question, replaced

from conrod.cli.validate_file import question_of
from conrod.cli.validate_request import Request
from conrod.errors import InvalidInput
from conrod.mjcf.loops.scene_study import study
from conrod.own.models.frame import GivenFrame
from conrod.own.models.request import Question
from conrod.scenes import SCENES
from conrod.studies.execution.local import confined

SAW, SCENE = TEXTS["saw"], SCENES["saw-40rpm"]
NO_NUMBER = 'name="slider-pin.rod" pos="nan 0 0"'
ASKED = ("--scene", "saw-40rpm", "--crank", "motor", "--point", "C=body:bow", "--point", "M=geom:rod")


def validate(*arguments: object) -> tuple[int, str]:
    """Exit status and output."""
    done = conrod("validate", *map(str, arguments))
    return done.returncode, done.stdout


def as_saw(put: Question) -> tuple[object, ...]:
    """All that is asked of a model that is to be the saw."""
    return ("saw-40rpm", SCENE), put, GivenFrame(), 0.02, None


def digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def test_a_users_model_is_judged_reported_and_left_as_it_is(tmp_path: Path) -> None:
    file = tmp_path / "my saw.xml"
    file.write_text(HACKSAW.read_text())
    before = digest(file)
    out, document = tmp_path / "report", tmp_path / "result.json"
    status, told = validate(file, *ASKED, "--revolutions", 1, "--out", out, "--json", document)
    assert status == 0, told
    assert "It is saw-40rpm" in told
    assert "plane xz, turned by 0 deg, crank zero at 90 deg, unit m" in told
    assert digest(file) == before
    part = json.loads(document.read_text())["parts"]["my saw"]
    assert part["summary"]["passed"]
    assert part["findings"]["identity"]["frame"]["zero"] == pytest.approx(1.5707963267948966)
    assert set(part["findings"]["runs"]) == {"as it is", "tuned", "hardened"}
    assert json.loads((out / "data/my saw.json").read_text()) == part["findings"]
    page = (out / "README.md").read_text()
    assert "It is saw-40rpm" in page
    assert "crank zero at 90 deg" in page  # with all digits, as on the console
    assert "conrod validate" in page


@pytest.mark.usefixtures("at_once")
def test_a_model_that_is_not_the_machine_has_exit_status_1_and_its_length_named(tmp_path: Path) -> None:
    file = tmp_path / "saw.xml"
    file.write_text(replaced(SAW, ROD_END, 'name="slider-pin.rod" pos="0.30003 0 0"'))
    status, told = validate(file, "--scene", "saw-40rpm", "--crank", "crank", "--point", "C=C", "--revolutions", 1)
    assert status == 1
    assert "It is not saw-40rpm as it stands: rod is 0.01 % too long: 300.03 mm instead of 300 mm." in told
    assert "not given, so not judged: M" in told
    # Negative control: a machine with such a rod is what it is.
    same = ("--scene", "saw-40rpm", "--set", "rod=300.03mm", "--crank", "crank", "--point", "C=C", "--revolutions", 1)
    status, told = validate(file, *same)
    assert status == 0, told


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"crank": "moter"}, "unknown joint 'moter': did you mean 'motor'? choose from bed slide, motor, wrist"),
        ({"points": ("C=crank pin",)}, "unknown site 'crank pin': did you mean 'crankpin'?"),
        ({"keyframe": "start"}, "unknown keyframe 'start': choose from qpos0"),
    ],
)
def test_names_that_a_model_has_not_are_told_with_the_nearest(asked: dict[str, object], words: str) -> None:
    options = {"crank": "motor", "points": ("C=body:bow",)} | asked
    put = question_of(Request(**options), SCENE)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match=f"{HACKSAW}: .*{re.escape(words)}"):
        study(HACKSAW, *as_saw(put))


def test_a_model_that_cannot_be_read_is_told_in_a_line(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    for text, words in ((SAW[:4000], "XML parse error"), (replaced(SAW, ROD_END, NO_NUMBER), "site_pos is not finite")):
        file.write_text(text)
        with pytest.raises(InvalidInput, match=f"{words}[^\n]*$"):
            study(file, *as_saw(question("saw")))


def test_a_model_that_never_ends_costs_its_own_process_alone(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    many = '<worldbody><replicate count="1000000000" offset="0 0 1"><geom size="1"/></replicate>'
    file.write_text(replaced(SAW, "<worldbody>", many))
    with pytest.raises(InvalidInput, match="it cannot be used: the run took longer than its limit"):
        confined(study, file, *as_saw(question("saw")), timeout=1.0)
    file.write_text(SAW)
    assert confined(study, file, *as_saw(question("saw")), timeout=60.0).model.name == "conrod-saw-40rpm"
