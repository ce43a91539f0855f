"""`conrod validate FMU --scene SCENE` as a user types it: FMUs that are right, wrong, or take their process down."""

from __future__ import annotations

import json
import platform
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod, refusal

from conrod.errors import InvalidInput
from conrod.execution import local
from conrod.models.fmu import fmu
from conrod.models.fmu.fmu import read_fmu, simulate

pytest.importorskip("fmpy", reason="FMUs are run by the extra fmi")
at_once = pytest.mark.usefixtures("at_once")

# -- a slider-crank in C, with a planted fault -----------------------------------------------------------------------

SOURCE = Path(__file__).parents[1] / "support" / "slider_crank_fmu.c"
BINARY = "binaries/linux64/saw.so"
# What it calls its token is the fault.
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="saw" guid="none" generationTool="hand">
  <ModelExchange modelIdentifier="saw"/><CoSimulation modelIdentifier="saw"/>
  <UnitDefinitions><Unit name="mm"/><Unit name="m"/><Unit name="m/s"/><Unit name="deg"/></UnitDefinitions>
  <TypeDefinitions><SimpleType name="Angle"><Real unit="deg"/></SimpleType></TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="slider.r[1]" valueReference="0" causality="output"><Real unit="mm"/></ScalarVariable>
    <ScalarVariable name="slider.r[2]" valueReference="1" causality="output"><Real unit="m"/></ScalarVariable>
    <ScalarVariable name="slider.v" valueReference="2"><Real unit="m/s"/></ScalarVariable>
    <ScalarVariable name="crank.phi" valueReference="3"><Real declaredType="Angle"/></ScalarVariable>
    <ScalarVariable name="slider.s" valueReference="4"><Real/></ScalarVariable>
    <ScalarVariable name="der(slider.s)" valueReference="2"><Real derivative="5"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="1"/><Unknown index="2"/></Outputs>
    <Derivatives><Unknown index="6"/></Derivatives>
    <InitialUnknowns><Unknown index="1"/><Unknown index="2"/><Unknown index="6"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def write_fmu(path: Path, library: Path | None, files: Mapping[str, str]) -> Path:
    """An FMU of some files, and the library where there is one."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        if library is not None:
            archive.write(library, BINARY)
        for name, text in files.items():
            archive.writestr(name, text)
    return path


# -- judged ------------------------------------------------------------------------------------------------------------

CHECK = ("check", "saw.fmu", "--scene", "saw-500rpm")
POINT = ("--column", "C.x=slider.r[1]", "--column", "C.y=slider.r[2]", "--column", "crank_angle=crank.phi")
JUDGED = ("--tolerance", "position=1e-4")


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The machine as a shared library."""
    compiler = shutil.which("cc")
    if compiler is None or (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        pytest.skip("a test's FMU is built by cc, on Linux of x86-64")
    found = tmp_path_factory.mktemp("library") / "saw.so"
    subprocess.run([compiler, "-O1", "-w", "-fPIC", "-shared", "-o", found, SOURCE, "-lm"], check=True)
    return found


def saw(folder: Path, library: Path, fault: str = "none") -> Path:
    return write_fmu(folder / "saw.fmu", library, {"modelDescription.xml": DESCRIPTION.replace("none", fault)})


@at_once
@pytest.mark.usefixtures("undrawn")
def test_fmu_is_judged_in_both_modes(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library)
    speed = ("--column", "C.vx=slider.v")
    done = conrod(*CHECK, *POINT, *speed, *JUDGED, "--json", "o.json", "--out", "rep", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "within tolerance: phase" in done.stdout
    assert "it has model-exchange, too: --preset model-exchange" in done.stdout
    found = json.loads((tmp_path / "o.json").read_text())["parts"]["table"]["findings"]
    units = {column["name"]: (column["unit"], column["unit_from"]) for column in found["columns"]}
    assert (units["C.x"], units["crank_angle"]) == (("mm", "model description"), ("deg", "model description"))
    sizes = {name: found["errors"]["C"][name]["size"]["max"] for name in ("position", "velocity")}
    assert sizes["position"] == pytest.approx(1.6e-6, rel=0.05)  # of the midpoint rule at 1000 steps
    assert sizes["velocity"] < 1e-12
    assert "co-simulation, 1000 steps a turn" in (tmp_path / "rep/README.md").read_text()
    # Model exchange is as exact as its integrator.
    done = conrod(*CHECK, *POINT, "--preset", "model-exchange", "--json", "m.json", cwd=tmp_path)
    found = json.loads((tmp_path / "m.json").read_text())["parts"]["table"]["findings"]
    assert (done.returncode, "model-exchange, 1000 steps a turn, CVode at 1e-09" in found["form"]) == (0, True)
    assert found["errors"]["C"]["position"]["size"]["max"] < 1e-7
    assert "build" not in found["form"]


@at_once
def test_token_of_another_build_is_said(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library, "{8c4e810f-3df3-4a00-8276-176fa3c9f013}")
    done = conrod(*CHECK, *POINT, *JUDGED, cwd=tmp_path)
    said = "its binary does not contain its token '{8c4e810f-3df3-4a00-8276-176fa3c9f013}', and may be of another build"
    assert (done.returncode, said in " ".join(done.stdout.split())) == (0, True), done.stdout + done.stderr


@at_once
def test_a_planted_error_is_out_of_tolerance(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library, "late")
    done = conrod(*CHECK, "--column", "C.x=slider.r[1]", *JUDGED, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    assert "OUT OF TOLERANCE: position" in done.stdout
    assert "each row belongs 6e-05 s (0.5 of a step) earlier than its time says" in done.stdout


@pytest.mark.parametrize(("fault", "words"), [
    ("segfault", "the process ended abnormally (ended by signal SIGSEGV)"),
    ("fork", "the process ended abnormally (ended by signal SIGABRT)"),
    ("hang", "the run took longer than its limit (no result after 0.5 s)"),
    ("error", "co-simulation failed: fmi2DoStep failed with status 3 (error). the crank is stuck"),
])  # fmt: skip
def test_an_fmu_that_ends_its_process_is_an_outcome(fault: str, words: str, tmp_path: Path, library: Path) -> None:
    folder, path = str(tmp_path / "unpacked"), saw(tmp_path, library, fault)
    place, limit = read_fmu(path, folder).variables[:1], 0.5 if fault == "hang" else 60.0
    with pytest.raises(InvalidInput) as caught:
        local.call_on_file(simulate, path, folder, "co-simulation", (0.0, 0.24, 200), place, timeout=limit)
    assert words in str(caught.value)


def run_in_own_process(folder: Path) -> subprocess.CompletedProcess[str]:
    """The command as a user gives it; it ends only when nobody holds its output open any more."""
    command = [sys.executable, "-m", "conrod", *CHECK, *POINT, *JUDGED]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=100, check=False)


def test_forking_fmu_does_not_hold_the_output_open(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library, "fork")
    done = run_in_own_process(tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "ended by signal SIGABRT" in done.stderr


def test_fmu_that_writes_into_foreign_descriptors_is_judged(tmp_path: Path, library: Path) -> None:
    saw(tmp_path, library, "stray")
    done = run_in_own_process(tmp_path)
    assert (done.returncode, "within tolerance" in done.stdout) == (0, True), done.stderr


DESCRIBED = {"modelDescription.xml": DESCRIPTION}


@at_once
@pytest.mark.parametrize(("fault", "arguments", "words"), [
    ("none", (), "say which variables are the motion of an observed point: --column C.x=VARIABLE; its outputs are"),
    ("none", ("--column", "C.x=slidr.r[1]"), "it has no variable 'slidr.r[1]', but 'slider.r[1]'"),
    ("none", ("--column", "C.x=slider.s"), "slider.s has no unit in the model description: say with --unit m"),
    ("nan", POINT, "saw.fmu: row 252: C.x = nan is not finite"),
])  # fmt: skip
def test_unusable_variable_is_refused_in_one_line(
    fault: str, arguments: tuple[str, ...], words: str, tmp_path: Path, library: Path
) -> None:
    saw(tmp_path, library, fault)
    assert words in refusal(*CHECK, *arguments, cwd=tmp_path)


@at_once
@pytest.mark.parametrize(("files", "words"), [
    ({}, "it is no FMU: it has no modelDescription.xml"),
    ({"modelDescription.xml": "<a"}, "its description cannot be used"),
    (DESCRIBED | {"resources/a": "a" * 100_000}, "more than a model has"),
    (DESCRIBED | {"sources/a.c": ""}, "but none; of C sources `fmpy compile` builds one"),
])  # fmt: skip
def test_harmful_or_damaged_archive_is_refused(
    files: dict[str, str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fmu, "MAX_UNPACKED_BYTES", 100_000)
    write_fmu(tmp_path / "saw.fmu", None, files)
    assert words in refusal(*CHECK, *POINT, cwd=tmp_path)
    monkeypatch.setitem(sys.modules, "fmpy", None)
    assert "is not installed: pip install 'conrod[fmi]'" in refusal(*CHECK, *POINT, cwd=tmp_path)


@at_once
@pytest.mark.parametrize(("dimensions", "size"), [(53, 10), (3, 1000), (1, 10**18), (2, 10**30)])
def test_an_array_without_bounds_is_refused_at_once(dimensions: int, size: int, tmp_path: Path) -> None:
    array = f'<Dimension start="{size}"/>' * dimensions
    text = f"""<fmiModelDescription fmiVersion="3.0" modelName="saw" instantiationToken="x">
  <CoSimulation modelIdentifier="saw"/>
  <ModelVariables><Float64 name="a" valueReference="1" causality="output" start="0">{array}</Float64></ModelVariables>
  <ModelStructure/></fmiModelDescription>"""
    write_fmu(tmp_path / "saw.fmu", None, {"modelDescription.xml": text, "binaries/x86_64-linux/saw.so": ""})
    begun = time.process_time()
    said = refusal(*CHECK, *POINT, cwd=tmp_path)
    assert time.process_time() - begun < 5.0
    assert "brings it to more than 1000000 real numbers" in said or "its description cannot be used" in said


# -- the closed circle: the exact motion goes out as an FMU, comes back as any tool's FMU does, and nothing is lost ----

EXACT = ",".join(f"{quantity}=1e-12" for quantity in ("position", "velocity", "acceleration"))


def check_exported(folder: Path, scene: str, *options: str, exported: tuple[str, ...] = ()) -> tuple[int, Any]:
    """Exit status and findings of a scene that was exported with some parameters."""
    done = conrod("export", scene, "--format", "fmu", "-o", "unit.fmu", *exported, cwd=folder)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    done = conrod("check", "unit.fmu", "--scene", scene, *options, "--json", "o.json", cwd=folder)
    return done.returncode, json.loads((folder / "o.json").read_text())["parts"]["table"]["findings"]


# A closed form, and a pass, which begins before time 0.
@at_once
@pytest.mark.usefixtures("library")
@pytest.mark.parametrize(("scene", "mode"), [("saw-500rpm", "model-exchange"), ("geneva", "co-simulation")])
def test_an_exported_machine_is_judged_exact_at_any_step(scene: str, mode: str, tmp_path: Path) -> None:
    status, found = check_exported(tmp_path, scene, "--preset", mode, "--tolerance", EXACT)
    assert status == 0
    assert max(one["size"]["max"] for errors in found["errors"].values() for one in errors.values()) < 1e-12
    # The rotations of links go out with it, and are compared too.
    links = [errors for errors in found["errors"].values() if "rotation" in errors]
    assert links
    assert all(errors.keys() == {"rotation", "angular_velocity", "angular_acceleration"} for errors in links)


@at_once
@pytest.mark.usefixtures("library")
def test_rod_a_micrometre_longer_is_off_by_its_sensitivity(tmp_path: Path) -> None:
    longer = 1e-6  # [m]
    status, found = check_exported(
        tmp_path, "saw-500rpm", "--tolerance", "position=1e-9", exported=("--set", f"rod={0.3 + longer!r}")
    )
    assert status == 1
    # Document 002: x of C is sqrt(l^2 - e^2) - r + r cos t - w with w = sqrt(l^2 - u^2) and u = r sin t - e; by l:
    t, rod, crank, offset = np.linspace(0.0, 2.0 * np.pi, 1001), 0.3, 0.1, 0.09
    w = np.sqrt(rod**2 - (crank * np.sin(t) - offset) ** 2)
    sensitivity = np.abs(rod / np.sqrt(rod**2 - offset**2) - rod / w).max()
    stroke = 0.211138  # [m]
    assert found["errors"]["C"]["position"]["size"]["max"] == pytest.approx(longer / stroke * sensitivity, rel=2e-5)
