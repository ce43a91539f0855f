"""Each function of the API on the smallest case: values in, findings out, that are shown, written, kept and judged."""

from __future__ import annotations

import ast
import html
import inspect
import json
import pickle
import shutil
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from command_line import conrod as typed
from command_line import kept_worker
from four_bars import four_bar
from table_files import exact_table

import conrod
from conrod import SCENES, Findings, InvalidInput, Runs
from conrod.slices import SLICES

ROOT = Path(__file__).parents[2]
MODEL = ROOT / "mjcf" / "saw-500rpm.xml"
SAW = SCENES["saw-500rpm"]
ON_MODEL: dict[str, Any] = {"crank": "crank", "points": {"C": "site:C"}, "revolutions": 1}
QUICK: dict[str, Any] = {"engines": "pymunk", "preset": "tuned", "steps_per_rev": 60, "revolutions": 1}
TABLE = exact_table(SAW)
HOSTILE = "saw <script>alert(1)</script>"

CALLS: dict[str, Callable[[Path, Runs], Findings[Any]]] = {
    "validate": lambda folder, runs: conrod.validate("saw-40rpm", **QUICK, runs=runs),
    "forces": lambda folder, runs: conrod.forces("saw-40rpm", quantities=["torque"], **QUICK, runs=runs),
    "free_motion": lambda folder, runs: conrod.free_motion(
        "pendulum", seconds=0.05, engines="pymunk", preset="tuned", runs=runs
    ),
    "check_model": lambda folder, runs: conrod.check_model(MODEL, SAW, tolerance={"position": 1e-6}, **ON_MODEL),
    "check_table": lambda folder, runs: conrod.check_table(TABLE, SAW, tolerance={"position": 1e-9}),
    "check_loops": lambda folder, runs: conrod.check_loops(
        mujoco.MjSpec.from_string(four_bar()), drives={"crank": "60rpm"}, seconds=0.05, tolerance={"position": 1e-3}
    ),
    "inspect_model": lambda folder, runs: conrod.inspect_model(
        mujoco.MjSpec.from_string(four_bar()), keyframe="qpos0", unit="m"
    ),
    "invariances": lambda folder, runs: conrod.invariances(MODEL, seconds=0.01),
    "sweep": lambda folder, runs: conrod.sweep("saw-40rpm", grid="coarse", engines="pymunk", runs=runs),
    "recommend": lambda folder, runs: conrod.recommend("saw-40rpm", {"position": 1e-2}, engines="pymunk", runs=runs),
    "limits": lambda folder, runs: conrod.limits(
        "saw-40rpm", axes=["steps"], engines="pymunk", preset="stock", runs=runs
    ),
    "ablate": lambda folder, runs: conrod.ablate("saw-40rpm", steps_per_rev=40, rounds=2, engines="mujoco", runs=runs),
    "audit": lambda folder, runs: conrod.audit(_printed_values(folder)),
}
SLOW = {"ablate"}
# Those that hold something to a tolerance.
VERDICTS = {
    **dict.fromkeys(("validate", "forces", "check_model", "check_table", "check_loops", "inspect_model"), True),
    "invariances": True,
    "recommend": True,
}
GIVEN = {
    "validate": {*QUICK}, "forces": {*QUICK, "quantities"}, "free_motion": {"seconds", "engines", "preset"},
    "check_model": {*ON_MODEL, "tolerance"}, "check_table": {"tolerance"}, "invariances": {"seconds"},
    "inspect_model": {"keyframe", "unit"},
    "check_loops": {"drives", "seconds", "tolerance"}, "sweep": {"grid", "engines"}, "recommend": {"engines"},
    "limits": {"axes", "engines", "preset"}, "ablate": {"steps_per_rev", "rounds", "engines"},
}  # fmt: skip
NAMES = [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in CALLS]


def _printed_values(folder: Path) -> Path:
    file = folder / "printed.csv"
    file.write_text("scene,quantity,angle_deg,printed,unit\nsaw-40rpm,C position x,90,9.9999,m\n", encoding="utf-8")
    return file


@pytest.fixture(autouse=True)
def quickly(at_once: None, undrawn: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers that are kept, steps that are timed coarsely."""
    monkeypatch.setattr("conrod.execution.local.WorkerProcess", kept_worker)
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("api")


@pytest.fixture(scope="module")
def found(folder: Path) -> Callable[[str], Findings[Any]]:
    """What a function finds, once for all tests."""

    @cache
    def find(name: str) -> Findings[Any]:
        return CALLS[name](folder, Runs(ledger=folder / "ledger.sqlite", jobs=1))

    return find


@pytest.mark.parametrize("name", NAMES)
def test_findings_say_a_verdict_and_hold_their_parts_by_name(name: str, found: Any) -> None:
    answer = found(name)
    assert isinstance(answer, Findings)
    assert answer.passed is VERDICTS.get(name)
    assert answer.within_tolerance is answer.passed
    assert answer.verdict
    assert repr(answer).startswith(f"<Findings passed={answer.passed}: {answer.verdict[:8].rstrip(chr(46))}")
    (part,) = answer
    assert answer[part] is answer.study
    assert part in json.loads(answer.json)["parts"]
    words = answer.text.split()
    assert all(heading in words for one in answer.tables() for heading in " ".join(one.headings).split())


@pytest.mark.parametrize("name", NAMES)
def test_findings_are_frozen(name: str, found: Any) -> None:
    answer = found(name)
    with pytest.raises(FrozenInstanceError):
        answer.call = ""
    with pytest.raises(TypeError):
        answer["another"] = None


@pytest.mark.parametrize("name", NAMES)
def test_findings_are_pickled(name: str, found: Any) -> None:
    answer = found(name)
    again = pickle.loads(pickle.dumps(answer))
    assert (again.text, again.json, again.passed, again.kind) == (answer.text, answer.json, answer.passed, answer.kind)


@pytest.mark.parametrize("name", NAMES)
def test_findings_in_a_notebook_escape_hostile_names(name: str, found: Any) -> None:
    answer = found(name)
    assert html.escape(answer.verdict.split()[0]) in answer._repr_html_()
    hostile = replace(
        answer, kind=_with_verdict(answer.kind, HOSTILE), parts={HOSTILE: answer.study}, typed={HOSTILE: HOSTILE}
    )
    shown = hostile._repr_html_()
    assert "<script>" not in shown
    assert "saw &lt;script&gt;alert(1)&lt;/script&gt;" in shown


def _with_verdict(kind: Any, verdict: str) -> Any:
    return replace(kind, verdict=lambda study: verdict)


@pytest.mark.parametrize("name", NAMES)
def test_findings_are_written_as_page_or_rerenderable_folder(name: str, found: Any, tmp_path: Path) -> None:
    answer = found(name)
    page = answer.write(tmp_path / "report")
    assert page.parent == tmp_path / "report"
    assert page.is_file()
    before = {path: path.read_bytes() for path in (tmp_path / "report").rglob("*.md")}
    assert typed("report", str(tmp_path / "report")).returncode == 0
    assert {path: path.read_bytes() for path in before} == before
    assert answer.write(str(tmp_path / "page.html")) == tmp_path / "page.html"
    assert "<html" in (tmp_path / "page.html").read_text(encoding="utf-8")
    # Negative control: what is somebody's is not written over.
    shutil.rmtree(tmp_path / "report")
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / page.name).write_text("mine")
    with pytest.raises(InvalidInput, match="not of this report"):
        answer.write(tmp_path / "report")


@pytest.mark.parametrize("name", NAMES)
def test_call_in_a_report_is_one_of_the_api_with_all_options(name: str, found: Any) -> None:
    (statement,) = ast.parse(found(name).call).body
    assert isinstance(statement, ast.Expr)
    assert isinstance(statement.value, ast.Call)
    function = statement.value.func
    assert isinstance(function, ast.Attribute)
    assert ast.unparse(function) == f"conrod.{name}"
    taken = inspect.signature(getattr(conrod, name)).parameters
    given = {str(one.arg): one.value for one in statement.value.keywords}
    assert set(given) <= set(taken)
    # All that was given and changes the answer stands there.
    assert GIVEN.get(name, set()) <= set(given)


# -- what is judged otherwise, and what cannot be used -----------------------------------------------------------------


def test_a_defect_is_out_of_tolerance(folder: Path) -> None:
    # Negative controls of the verdicts above.
    runs = Runs(ledger=folder / "ledger.sqlite", jobs=1)
    assert conrod.validate("saw-40rpm", tolerance={"position": 1e-12}, **QUICK, runs=runs).passed is False
    assert conrod.forces("saw-40rpm", tolerance={"torque": 1e-12}, **QUICK, runs=runs).passed is False
    assert conrod.check_table({**TABLE, "C.x": TABLE["C.x"] + 1e-4}, SAW, tolerance={"position": 1e-5}).passed is False
    opened = conrod.check_loops(
        mujoco.MjSpec.from_string(four_bar()), drives={"crank": "60rpm"}, seconds=0.05, tolerance={"position": 1e-12}
    )
    assert opened.passed is False


def test_findings_on_several_scenes_are_held_by_name(folder: Path) -> None:
    own = conrod.scene("saw-40rpm", crank="90 mm")
    several = {"one": SCENES["saw-40rpm"], "another": own}
    answer = conrod.validate(several, **QUICK, runs=Runs(ledger=folder / "ledger.sqlite", jobs=1))
    assert list(answer) == ["one", "another"]
    assert [study.scene.parameters["crank"] for study in answer.values()] == [0.1, 0.09]
    with pytest.raises(InvalidInput, match="these are findings on one, another: take one by its name"):
        _ = answer.study
    assert len(answer.verdict.splitlines()) == 2


def test_scenes_of_one_kind_have_findings_each(tmp_path: Path) -> None:
    done = typed("invariances", "saw-40rpm", "saw-500rpm", "--seconds", "0.01", "--json", str(tmp_path / "found.json"))
    assert done.returncode == 0, done.stderr
    parts = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))["parts"]
    assert list(parts) == ["saw-40rpm", "saw-500rpm"]
    assert [f"{name}: None of" in done.stdout for name in parts] == [True, True]


def test_lint_and_harden_do_as_their_commands_do(tmp_path: Path) -> None:
    report = conrod.lint(MODEL, seconds=0.01, ignore=("soft-closure",))
    assert report.model == str(MODEL)
    hardened = conrod.harden(mujoco.MjSpec.from_file(str(MODEL)), seconds=0.02, write=True)
    assert hardened.content
    assert not hardened.refusals
    assert conrod.harden(MODEL, seconds=0.02).content is None
    compiled = mujoco.MjModel.from_xml_path(str(MODEL))
    before = compiled.body_invweight0.copy()
    assert conrod.harden(compiled) is None
    assert np.abs(compiled.body_invweight0 - before).max() > 0.0


def test_export_returns_what_the_command_prints(tmp_path: Path) -> None:
    for kind in ("mjcf", "pymunk", "csv"):
        assert conrod.export("saw-40rpm", kind) == typed("export", "saw-40rpm", "--format", kind).stdout
    own = conrod.scene("saw-40rpm", crank="90 mm")
    assert conrod.export(own, "csv") != conrod.export("saw-40rpm", "csv")
    assert str(conrod.export("bennett")).startswith("<mujoco")


def test_progress_of_runs_is_given_to_a_callback(folder: Path) -> None:
    seen: list[tuple[str, str]] = []

    def watch(description: str, usual: str) -> Any:
        seen.append((description, usual))
        return Runs().progress(description, usual)

    runs = Runs(ledger=folder / "ledger.sqlite", jobs=1, progress=watch)
    assert conrod.validate("saw-40rpm", **QUICK, runs=runs).passed
    assert seen == [("runs", "completed")]


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "validate, scene": (lambda: conrod.validate("sheer-press"), "did you mean 'shear-press'"),
    "validate, engine": (lambda: conrod.validate("saw-40rpm", engines="pymunc"), "did you mean 'pymunk'"),
    "validate, preset": (lambda: conrod.validate("saw-40rpm", preset="tunned"), "did you mean 'tuned'"),
    "validate, steps": (lambda: conrod.validate("saw-40rpm", steps_per_rev=1), "--steps-per-rev = 1 is out of range"),
    "validate, tolerance": (lambda: conrod.validate("saw-40rpm", tolerance={"jerk": 1.0}), "unknown quantity 'jerk'"),
    "validate, accept": (lambda: conrod.validate("saw-40rpm", accept=True), "name its file with --baseline"),
    "forces, contact": (lambda: conrod.forces("saw-40rpm", quantities=["contact"]), "no joint of saw-40rpm acts by"),
    "forces, twice": (lambda: conrod.forces("saw-40rpm", quantities=["torque"] * 2), "torque is named twice"),
    "free_motion, torque": (lambda: conrod.free_motion("pendulum", torque=True), "no torque that drives its crank"),
    "free_motion, seconds": (lambda: conrod.free_motion("pendulum", seconds=-1.0), "-1 s is out of range"),
    "check_model, crank": (
        lambda: conrod.check_model(MODEL, SAW, crank="crnk", points={"C": "site:C"}), "did you mean 'crank'"
    ),
    "check_model, point": (
        lambda: conrod.check_model(MODEL, SAW, crank="crank", points={"D": "site:C"}), "unknown observed point 'D'"
    ),
    "check_table, numbers": (lambda: conrod.check_table({"time": ["a"]}, SAW), "an array of numbers is wanted"),
    "check_table, estimate": (lambda: conrod.check_table(TABLE, SAW, estimate=["fase"]), "unknown thing to estimate"),
    "check_table, column": (lambda: conrod.check_table(TABLE, SAW, columns={"D.x": "a"}), "unknown quantity 'D.x'"),
    "check_torque_run": (
        lambda: conrod.check_torque_run(TABLE, SAW, "motor"), "unknown column in --torque 'motor': choose from"
    ),
    "check_fmu": (lambda: conrod.check_fmu("none.fmu", SAW), "none.fmu: there is no such file"),
    "check_loops": (lambda: conrod.check_loops("none.xml", drives={"a": "1rpm"}), "none.xml: there is no such file"),
    "inspect_model": (lambda: conrod.inspect_model("none.xml"), "none.xml: there is no such file"),
    "inspect_model, unit": (
        lambda: conrod.inspect_model(mujoco.MjSpec.from_string(four_bar()), unit="mn"), "choose from cm, inch, m, mm"
    ),
    "check_loops, drive": (
        lambda: conrod.check_loops(mujoco.MjSpec.from_string(four_bar()), drives={"krank": "1rpm"}), "'krank'"
    ),
    "invariances": (lambda: conrod.invariances("none.xml"), "none.xml: there is no such file"),
    "sweep, grid": (lambda: conrod.sweep("saw-40rpm", grid="corse"), "did you mean 'coarse'"),
    "recommend": (lambda: conrod.recommend("saw-40rpm", {}), "tolerance"),
    "limits, axis": (lambda: conrod.limits("saw-40rpm", axes=["step"]), "did you mean 'steps'"),
    "limits, span": (lambda: conrod.limits("saw-40rpm", span=(1.0, 2.0)), "needs one --axis"),
    "validate_in_space": (lambda: conrod.validate_in_space("benett"), "did you mean 'bennett'"),
    "ablate": (lambda: conrod.ablate("saw-40rpm", rounds=1), "--rounds = 1 is out of range"),
    "versions, cluster": (
        lambda: conrod.versions("mujoco", runs=Runs(cluster="tcp://x:1")), "releases are installed on this machine"
    ),
    "versions, number": (lambda: conrod.versions("mujoco", releases=["3.x"]), "'3.x' is no version"),
    "explain": (lambda: conrod.explain("opned"), "did you mean 'opened'"),
    "begin_project": (lambda: conrod.begin_project(__file__), "it is a file: give the folder of the project"),
    "compare_releases": (lambda: conrod.compare_releases("none.xml"), "none.xml: there is no such file"),
    "check_loops_in_engines": (
        lambda: conrod.check_loops_in_engines("none.xml", drives={"input": "60rpm"}), "none.xml"
    ),
    "lint": (lambda: conrod.lint("none.xml"), "none.xml: there is no such file"),
    "harden": (lambda: conrod.harden("none.xml"), "none.xml: there is no such file"),
    "audit": (lambda: conrod.audit("none.csv"), "none.csv"),
    "export": (lambda: conrod.export("saw-40rpm", "mjfc"), "did you mean 'mjcf'"),
    "validate, two of a name": (lambda: conrod.validate([SAW, SCENES["saw-40rpm"]]), "two scenes are called 'saw'"),
    "scene": (lambda: conrod.scene("saw-40rpm", crnk="1 m"), "did you mean 'crank'"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_unusable_argument_raises_invalid_input_of_one_line(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    call, words = REFUSED[case]
    with pytest.raises(InvalidInput) as refused:
        call()
    assert words in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_each_function_of_the_api_has_a_case() -> None:
    # Negative control: a function that is added has its case.
    in_api = {name for one in SLICES for name in one.functions}
    assert len(in_api) > 15
    tried = {*CALLS, "check", "doctor", *(case.split(",")[0] for case in REFUSED)}
    assert in_api <= tried
