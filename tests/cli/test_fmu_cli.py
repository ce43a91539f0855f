"""`conrod validate FMU --scene SCENE` as a user types it: FMUs that are right, wrong, or take their process down."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from command_line import conrod, said
from slider_crank_fmu import BINARY, compiled, description, write_fmu

from conrod.errors import InvalidInput
from conrod.own import fmu
from conrod.own.fmu import Order, read_fmu, simulate
from conrod.studies.execution import isolation

pytest.importorskip("fmpy", reason="FMUs are run by the extra fmi")
VALIDATE = ("validate", "saw.fmu", "--scene", "saw-500rpm")
POINT = ("--column", "C.x=slider.r[1]", "--column", "C.y=slider.r[2]", "--column", "crank_angle=crank.phi")
JUDGED = ("--tolerance", "position=1e-4")


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = compiled(tmp_path_factory.mktemp("library"))
    if found is None:
        pytest.skip("a test's FMU is built by cc, on Linux of x86-64")
    return found


def saw(folder: Path, library: Path, fault: str = "none") -> Path:
    return write_fmu(folder / "saw.fmu", library, {"modelDescription.xml": description(fault)})


@pytest.mark.usefixtures("at_once", "undrawn")
def test_co_simulation_is_judged(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library)
    done = conrod(
        *VALIDATE, *POINT, "--column", "C.vx=slider.v", *JUDGED, "--json", "o.json", "--out", "rep", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert "within tolerance: phase" in done.stdout
    assert "it has model-exchange, too: --preset model-exchange" in done.stdout
    found = json.loads((tmp_path / "o.json").read_text())["parts"]["table"]["findings"]
    units = {column["target"]["name"]: (column["unit"], column["unit_from"]) for column in found["columns"]}
    assert units["C.x"] == ("mm", "model description")
    assert units["crank_angle"] == ("deg", "model description")
    sizes = {name: found["errors"]["C"][name]["size"]["max"] for name in ("position", "velocity")}
    assert sizes["position"] == pytest.approx(1.6e-6, rel=0.05)  # of the midpoint rule at 1000 steps
    assert sizes["velocity"] < 1e-12
    assert "co-simulation, 1000 steps a turn" in (tmp_path / "rep/README.md").read_text()


@pytest.mark.usefixtures("at_once")
def test_model_exchange_is_as_exact_as_its_integrator(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library)
    done = conrod(*VALIDATE, *POINT, "--preset", "model-exchange", "--json", "o.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "o.json").read_text())["parts"]["table"]["findings"]
    assert "model-exchange, 1000 steps a turn, CVode at 1e-09" in found["form"]
    assert found["errors"]["C"]["position"]["size"]["max"] < 1e-7


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("rod", "none of the common causes reproduces the difference"),
        ("late", "likely cause: each row belongs 6e-05 s (0.5 of a step) earlier than its time says"),
    ],
)
def test_a_planted_error_is_out_of_tolerance(fault: str, words: str, tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library, fault)
    done = conrod(*VALIDATE, "--column", "C.x=slider.r[1]", *JUDGED, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    assert "OUT OF TOLERANCE: position" in done.stdout
    assert words in done.stdout


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("segfault", "the process ended abnormally (ended by signal SIGSEGV)"),
        ("hang", "the run took longer than its limit (no result after 0.5 s)"),
        ("error", "co-simulation failed: fmi2DoStep failed with status 3 (error). the crank is stuck"),
    ],
)
def test_an_fmu_that_ends_its_process_is_an_outcome(fault: str, words: str, tmp_path: Path, library: Path) -> None:
    folder, path = str(tmp_path / "unpacked"), saw(tmp_path, library, fault)
    place = read_fmu(path, folder).variables[:1]
    order, limit = Order("co-simulation", 100, None, 0.0, 0.24, 200), 0.5 if fault == "hang" else 60.0
    with pytest.raises(InvalidInput) as caught:
        isolation.confined(simulate, path, folder, order, place, timeout=limit)
    assert words in str(caught.value)


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(
    ("fault", "arguments", "words"),
    [
        ("none", (), "say which variables are the motion of an observed point: --column C.x=VARIABLE; its outputs are"),
        ("none", ("--column", "C.x=slidr.r[1]"), "it has no variable 'slidr.r[1]', but 'slider.r[1]'"),
        ("none", ("--column", "C.x=slider.s"), "slider.s has no unit in the model description: say with --unit m"),
        ("none", (*POINT, "--engine", "mujoco"), "--engine does not go with an FMU"),
        ("nan", POINT, "saw.fmu: row 252: C.x = nan is not finite"),
    ],
)
def test_what_cannot_be_used_is_one_line(
    fault: str, arguments: tuple[str, ...], words: str, tmp_path: Path, library: Path
) -> None:
    saw(tmp_path, library, fault)
    refused(*arguments, words=words, cwd=tmp_path)


def refused(*arguments: str, words: str, cwd: Path) -> None:
    done = conrod(*VALIDATE, *arguments, cwd=cwd)
    lines = said(done)
    assert (done.returncode, len(lines), done.stdout) == (2, 1, ""), lines
    assert words in lines[0]


WHOLE = description()


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({}, "it is no FMU: it has no modelDescription.xml"),
        ({"modelDescription.xml": "<a"}, "its description cannot be used"),
        ({"modelDescription.xml": WHOLE, "resources/a": "a" * 100_000}, "more than a model has"),
        ({"modelDescription.xml": WHOLE, "sources/a.c": ""}, "but none; of C sources `fmpy compile` builds one"),
    ],
)
def test_an_archive_that_was_made_to_do_harm_is_refused(
    files: dict[str, str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fmu, "MOST_BYTES", 100_000)
    write_fmu(tmp_path / "saw.fmu", None, files)
    refused(*POINT, words=words, cwd=tmp_path)


def test_elements_of_an_array_are_variables_of_their_own(tmp_path: Path) -> None:
    variables = """<Float64 name="time" valueReference="9" causality="independent"/>
        <Float64 name="r" valueReference="0" unit="mm"><Dimension start="2"/></Float64>
        <Float64 name="T" valueReference="1"><Dimension start="1"/><Dimension start="2"/></Float64>"""
    text = f"""<fmiModelDescription fmiVersion="3.0" modelName="a" instantiationToken="a">
        <CoSimulation modelIdentifier="a"/><UnitDefinitions><Unit name="mm"/></UnitDefinitions>
        <ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>"""
    path = write_fmu(tmp_path / "a.fmu", None, {"modelDescription.xml": text, BINARY: ""})
    found = read_fmu(path, str(tmp_path / "unpacked"))
    assert (found.version, found.modes) == ("3.0", ("co-simulation",))
    named = [(one.name, one.unit, one.array, one.index) for one in found.variables]
    assert named == [("r[1]", "mm", "r", 0), ("r[2]", "mm", "r", 1), ("T[1,1]", "", "T", 0), ("T[1,2]", "", "T", 1)]


@pytest.mark.usefixtures("at_once")
def test_without_fmpy_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fmpy", None)
    write_fmu(tmp_path / "saw.fmu", None, {"modelDescription.xml": WHOLE, BINARY: ""})
    refused(*POINT, words="is not installed: pip install 'conrod[fmi]'", cwd=tmp_path)
