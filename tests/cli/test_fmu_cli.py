"""`conrod validate FMU --scene SCENE` as a user types it: FMUs that are right, wrong, or take their process down."""

from __future__ import annotations

import json
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import pytest
from command_line import conrod, said
from slider_crank_fmu import BINARY, BOTH, compiled, description, write_fmu

from conrod.errors import InvalidInput
from conrod.own.fmu import unit
from conrod.own.fmu.study import in_columns
from conrod.own.fmu.unit import Order, read_fmu, simulate
from conrod.studies.execution import isolation

pytest.importorskip("fmpy", reason="FMUs are run by the extra fmi")
VALIDATE = ("validate", "saw.fmu", "--scene", "saw-500rpm")
POINT = ("--point", "C=slider.r[1],slider.r[2]", "--crank", "crank.phi")
JUDGED = ("--tolerance", "position=1e-4")


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = compiled(tmp_path_factory.mktemp("library"))
    if found is None:
        pytest.skip("a test's FMU is built by cc, on Linux of x86-64")
    return found


def saw(folder: Path, library: Path, fault: str = "none", modes: tuple[str, ...] = BOTH) -> Path:
    return write_fmu(folder / "saw.fmu", library, {"modelDescription.xml": description(fault, modes)})


@pytest.mark.usefixtures("at_once", "undrawn")
def test_co_simulation_is_judged_and_its_order_is_found(tmp_path: Path, library: Path) -> None:
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
    positions, velocities = ([run["sizes"][name] for run in found["runs"]] for name in ("position", "velocity"))
    assert [run["steps"] for run in found["runs"]] == [1000, 500, 250]
    ratios = [finer / coarser for finer, coarser in pairwise(positions)]
    assert ratios == pytest.approx([0.25, 0.25], rel=1e-2)  # of the midpoint rule, order 2
    assert max(velocities) < 1e-12
    page = (tmp_path / "rep/README.md").read_text()
    assert "| co-simulation, 1000 steps a turn | 1.6e-6 |" in page
    assert "| order in the step | 2.0 |" in page


@pytest.mark.usefixtures("at_once")
def test_model_exchange_is_as_exact_as_its_integrator(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library)
    done = conrod(*VALIDATE, *POINT, "--preset", "model-exchange", "--json", "o.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    runs = json.loads((tmp_path / "o.json").read_text())["parts"]["table"]["findings"]["runs"]
    assert [run["setting"] for run in runs] == [f"model-exchange, CVode at 1e-0{digits}" for digits in (9, 7, 5)]
    finest, finer, coarse = (run["sizes"]["position"] for run in runs)
    assert finest < 1e-7 < 20.0 * finest < finer < coarse / 20.0
    assert "order in the step" not in done.stdout


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
    done = conrod(*VALIDATE, "--point", "C=slider.r[1]", *JUDGED, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    assert "OUT OF TOLERANCE: position" in done.stdout
    assert words in done.stdout


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("crash", "the process ended abnormally (ended by signal SIGABRT)"),
        ("segfault", "the process ended abnormally (ended by signal SIGSEGV)"),
        ("exit", "the process ended abnormally (ended with status 0)"),
        ("hang", "the run took longer than its limit (no result after 0.5 s)"),
        ("error", "co-simulation failed: fmi2DoStep failed with status 3 (error). the crank is stuck"),
        ("refuses", "co-simulation failed: Failed to instantiate model"),
    ],
)
def test_an_fmu_that_ends_its_process_is_an_outcome(fault: str, words: str, tmp_path: Path, library: Path) -> None:
    folder, path = str(tmp_path / "unpacked"), saw(tmp_path, library, fault)
    place = read_fmu(path, folder).variables[:1]
    order, limit = Order("co-simulation", 100, None, 0.0, 0.24, 200), 0.5 if fault == "hang" else 60.0
    with pytest.raises(InvalidInput) as caught:
        isolation.confined(simulate, path, folder, order, place, timeout=limit)
    assert words in str(caught.value)


def test_a_crash_costs_that_run_alone(tmp_path: Path, library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    saw(tmp_path, library, "coarse")
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    done = conrod(*VALIDATE, *POINT, *JUDGED, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("ended by signal SIGABRT") == 2
    assert "within tolerance" in done.stdout
    assert list((tmp_path / "temporary").iterdir()) == []


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(
    ("fault", "arguments", "words"),
    [
        (
            "none",
            (),
            "say which variables an observed point is: --point C=X,Y; its outputs are slider.r[1], slider.r[2]",
        ),
        ("none", ("--point", "C=slidr.r[1]"), "it has no variable 'slidr.r[1]', but 'slider.r[1]'"),
        ("none", ("--point", "K=slider.r[1]"), "unknown observed point 'K'"),
        ("none", ("--point", "C=slider.s"), "slider.s has no unit in the model description: say with --unit C.x=m"),
        ("none", ("--point", "C=slider.v"), "column 'slider.v': 'm/s' is no unit of length"),
        ("none", ("--point", "C=a,b,c"), "C=a,b,c: give its x and y"),
        ("none", (*POINT, "--column", "C.x=slider.s"), "--column C.x: given twice"),
        ("none", (*POINT, "--unit", "M.x=mm"), "no column of the table takes its unit from it"),
        ("none", (*POINT, "--preset", "tuned"), "unknown mode in --preset 'tuned': choose from"),
        ("none", (*POINT, "--engine", "mujoco"), "--engine does not go with an FMU"),
        ("none", (*POINT, "--plane", "xz"), "--plane does not go with an FMU"),
        ("none", (*POINT, "--steps-per-rev", "3"), "--steps-per-rev 3: in 2 turns"),
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


@pytest.mark.usefixtures("at_once")
def test_a_mode_that_it_has_not_is_refused(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library, modes=BOTH[1:])
    words = "unknown mode in --preset 'model-exchange': choose from co-simulation"
    refused(*POINT, "--preset", "model-exchange", words=words, cwd=tmp_path)


ENTITIES = '<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;&b;">]><fmiModelDescription modelName="&c;"/>'
WHOLE = description()


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({}, "it is no FMU: it has no modelDescription.xml"),
        ({"modelDescription.xml": WHOLE, "../up.txt": ""}, "'../up.txt', which leads out of its folder"),
        ({"modelDescription.xml": WHOLE, "/etc/up.txt": ""}, "'/etc/up.txt', which leads out of its folder"),
        ({"modelDescription.xml": ENTITIES}, "a document type or entities, which FMI does not use"),
        ({"modelDescription.xml": "<a"}, "its modelDescription.xml is no XML"),
        ({"modelDescription.xml": "<a/>"}, "its description cannot be used"),
        ({"modelDescription.xml": " " * 10_001}, "10001 bytes: at most 10000 are read"),
        ({"modelDescription.xml": WHOLE, "resources/a": "a" * 100_000}, "at most 100000, 100000 are"),
        ({"modelDescription.xml": WHOLE, "binaries/win64/a.dll": ""}, "it has no binary for this platform"),
        ({"modelDescription.xml": WHOLE, "sources/a.c": ""}, "but none; of C sources `fmpy compile` builds one"),
    ],
)
def test_an_archive_that_was_made_to_do_harm_is_refused(
    files: dict[str, str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(unit, "MOST_DESCRIPTION", 10_000)
    monkeypatch.setattr(unit, "MOST_BYTES", 100_000)
    write_fmu(tmp_path / "saw.fmu", None, files)
    refused(*POINT, words=words, cwd=tmp_path)


@pytest.mark.usefixtures("at_once")
def test_what_is_no_archive_or_a_damaged_one_is_refused(tmp_path: Path, library: Path) -> None:
    path = saw(tmp_path, library)
    path.write_bytes(path.read_bytes().replace(b"\x03\x04", b"\x03\x05", 1))
    refused(*POINT, words="its archive is damaged", cwd=tmp_path)
    path.write_bytes(b"MZ")
    refused(*POINT, words="it is no FMU: no zip archive", cwd=tmp_path)


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


def test_a_comma_in_brackets_is_no_border_and_one_coordinate_is_enough() -> None:
    given = in_columns(("C=T[1,2],r[3]", "M=,y"), "phi", ("C", "M"))
    assert given == ["crank_angle=phi", "C.x=T[1,2]", "C.y=r[3]", "M.y=y"]
