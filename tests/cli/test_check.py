"""`conrod.check` and names that are not there: what the command line answers, in Python."""

from __future__ import annotations

import doctest
import json
import re
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pyarrow
import pytest
from command_line import conrod, kept_worker
from table_files import csv_text, exact_table

from conrod import SCENES, InvalidInput, check, scene
from conrod.models.tables.study import TableStudy

pytestmark = pytest.mark.usefixtures("at_once")
ROOT = Path(__file__).parents[2]
MODEL = ROOT / "mjcf" / "saw-500rpm.xml"
SAW = SCENES["saw-500rpm"]
ASKED: dict[str, Any] = {"crank": "crank", "points": {"C": "site:C"}, "tolerance": {"position": 1e-6}}
TYPED = ("--scene", "saw-500rpm", "--crank", "crank", "--point", "C=site:C", "--tolerance", "position=1e-6")
TIMES = np.linspace(0.0, 0.24, 200)
EXACT = SAW.motion(SAW.speed * TIMES, SAW.speed).point("C")
TABLE = {"time": TIMES, "C": EXACT.position}


def test_a_model_is_judged_as_the_command_judges_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    checked = check(MODEL, "saw-500rpm", **ASKED)
    assert capsys.readouterr() == ("", "")
    done = conrod("check", str(MODEL), *TYPED, "--json", str(tmp_path / "found.json"))
    assert (checked.passed, done.returncode) == (True, 0)
    assert checked.text == done.stdout
    assert checked.json == (tmp_path / "found.json").read_text(encoding="utf-8")
    assert checked.verdict in checked.text
    # The model in memory, against the scene itself, with a tolerance that it does not hold.
    failed = check(mujoco.MjSpec.from_file(str(MODEL)), SAW, **ASKED | {"tolerance": {"position": 1e-9}})
    assert failed.passed is False
    assert "out of tolerance: position" in failed.verdict
    assert json.loads(failed.json)["parts"]["the model"]["findings"]["file"] == "the model"


def test_table_is_judged_from_a_file_arrays_or_a_data_frame(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text(csv_text(exact_table(SAW)), encoding="utf-8")
    measured = check(file, SAW)
    assert (measured.passed, type(measured.study)) == (None, TableStudy)
    assert check(TABLE, SAW, tolerance={"position": 1e-9}).passed is True
    # A defect that is planted is caught, and named.
    off = check(TABLE | {"C": EXACT.position + np.array([1e-4, 0.0])}, "saw-500rpm", tolerance={"position": 1e-4})
    assert off.passed is False
    assert "offset by (0.1, 0) mm" in off.text
    assert repr(off).startswith("<Findings passed=False: OUT OF TOLERANCE: position")
    frame = pyarrow.table({"time": TIMES, "C.x": EXACT.position[:, 0], "C.y": EXACT.position[:, 1]})
    assert check(frame, SAW, tolerance={"position": 1e-9}).passed is True
    estimated = check(TABLE, scene("saw-500rpm", crank=0.1), estimate=["time"], units=["s"])
    assert "what is left is" in estimated.text


@pytest.mark.slow
def test_a_scene_is_judged_in_an_engine_and_held_to_its_baseline(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conrod.execution.local.WorkerProcess", kept_worker)
    file, asked = tmp_path / "saw.json", {"engines": "mujoco", "preset": "hardened", "steps_per_rev": 50}
    typed = ("validate", "saw-500rpm", "--engine=mujoco", "--preset=hardened", "--steps-per-rev=50")
    done = conrod(*typed, "--baseline", str(file))
    assert (done.returncode, "no baseline yet: " in done.stdout) == (1, True)
    assert set(json.loads(file.read_text(encoding="utf-8"))["results"]) == {"mujoco kinematic", "mujoco hardened"}
    checked = check("saw-500rpm", **asked, baseline=file)
    assert (checked.passed, checked.baseline and checked.baseline.text) == (True, "")
    said = r"saw-500rpm: MuJoCo kinematic mode < 2e-10 mm and hardened \S+ mm are within tolerance"
    assert re.fullmatch(f"<Findings passed=True: {said}>", repr(checked)), repr(checked)
    # A drift that is planted, and what is out of tolerance, are told apart; the second is not accepted.
    kept = json.loads(file.read_text(encoding="utf-8"))
    kept["results"]["mujoco hardened"]["numbers"]["position"]["value"] *= 1.001
    file.write_text(json.dumps(kept), encoding="utf-8")
    drifted = conrod(*typed, "--baseline", str(file))
    assert drifted.returncode == 1
    assert re.search(r"  mujoco hardened: position .*, was .*: better, drifted by \d+\.\d digits\n", drifted.stdout)
    accept = drifted.stdout.splitlines()[-1]
    assert accept == f"accept it: conrod {' '.join(typed)} --baseline {file} --accept"
    failed = check("saw-500rpm", **asked, baseline=file, accept=True, tolerance={"position": 1e-12})
    assert (failed.passed, failed.within_tolerance, failed.baseline and failed.baseline.written) == (False, False, True)
    assert failed.verdict.startswith("saw-500rpm: MuJoCo hardened: OUT OF TOLERANCE: position")
    assert conrod(*typed, "--baseline", str(file)).returncode == 0


HINGES = mujoco.MjSpec.from_string(
    "<mujoco><worldbody>"
    "<body><joint name='left'/><geom size='1'/><site name='end'/></body>"
    "<body><joint name='right'/><geom size='1'/></body>"
    "</worldbody></mujoco>"
)
REFUSED: dict[str, tuple[Any, dict[str, Any], str]] = {
    "no model": (3, {}, "a int cannot be judged: give a scene, a file, a mujoco.MjModel or MjSpec, a data frame or"),
    "no scene": (TABLE, {"scene": None}, "a dict: say with scene=... what machine it is"),
    "no numbers": (TABLE | {"C": ["a"] * 200}, {}, "the table: 'C': an array of numbers is wanted"),
    "a misspelt keyword": (TABLE, {"unitz": ["s"]}, "unknown keyword 'unitz': did you mean 'units'?"),
    "a keyword of models": (TABLE, {"crank": "hinge"}, "crank does not go with a table: it is for models"),
    "a scene's scene": ("saw-500rpm", {}, "is for a file: a scene is judged as it is"),
    "a scene's crank": (SAW, {"scene": None, "crank": "crank"}, "crank does not go with a scene: it is for models"),
    "no crank": (HINGES, {"points": {"C": "site:end"}}, "is driven: --crank JOINT, one of left, right"),
    "no point": (HINGES, {"crank": "left"}, "--point C=site:NAME, for one of end"),
    "no file": ("none.xml", {}, "none.xml: there is no such file"),
    "no FMU": ("none.fmu", {}, "none.fmu: there is no such file"),
    "option text": (TABLE, {"tolerance": "position=1e-9"}, "give numbers by quantity"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_unusable_subject_or_keyword_raises_invalid_input(case: str) -> None:
    subject, keywords, message = REFUSED[case]
    with pytest.raises(InvalidInput) as refused:
        check(subject, **{"scene": SAW} | keywords)
    assert message in str(refused.value)
    assert not {"model.mjb", "table.npz"} & set(re.split(r"[/: ]", str(refused.value)))


def test_examples_of_the_python_page_print_what_they_show(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    examples = doctest.DocTestParser().get_doctest(page, {}, "python.md", "docs/python.md", 0)
    assert len(examples.examples) > 8
    assert doctest.DocTestRunner().run(examples).failed == 0
