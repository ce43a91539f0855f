"""The exact motion as an FMU: what a tool that knows nothing of conrod computes with it is the exact motion."""

from __future__ import annotations

import io
import re
import shutil
import zipfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod

from conrod.exact.motion import Array
from conrod.models.export import fmu as archive
from conrod.scenes import SCENES, Scene, catalogue_names, scene_named

fmpy = pytest.importorskip("fmpy", reason="FMPy, of the extra fmi, is not installed")
compiled = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")

MODES = ("CoSimulation", "ModelExchange")
QUANTITIES = (("", "position", 0), ("v", "velocity", 1), ("a", "acceleration", 2))


@cache
def export_scene(name: str, speed: float = 1.0) -> tuple[Scene, bytes]:
    """A scene at so many times its speed, and its FMU."""
    scene = scene_named(name)
    scene = scene.with_parameters(speed=speed * scene.speed)
    return scene, archive.fmu(name, scene)[0]


def simulate(content: bytes, folder: Path, **options: Any) -> Any:
    (folder / "unit.fmu").write_bytes(content)
    outputs = [
        v.name for v in fmpy.read_model_description(folder / "unit.fmu").modelVariables if "o" in v.causality[:1]
    ]
    return fmpy.simulate_fmu(str(folder / "unit.fmu"), output=outputs, **options)


def load_unit(folder: Path, **options: Any) -> Any:
    (folder / "unit.fmu").write_bytes(export_scene("saw-500rpm")[1])
    described = fmpy.read_model_description(folder / "unit.fmu")
    place = fmpy.extract(str(folder / "unit.fmu"), unzipdir=str(folder / "unit"))
    given = {"guid": described.guid, "modelIdentifier": described.coSimulation.modelIdentifier, **options}
    return fmpy.fmi3.FMU3Slave(unzipDirectory=place, instanceName="one", **given)


def largest_error(scene: Scene, result: Any) -> float:
    """Of all quantities of all points, over L, omega L and omega^2 L."""
    span = scene.mechanism().driver.span
    angle: Array = np.clip(result["crank_angle"], *span) if span else result["crank_angle"]
    exact = scene.motion(angle, scene.speed, side="right" if scene.speed > 0.0 else "left")
    return max(
        float(np.abs(result[f"{point}.{letter}{axis}"] - getattr(motion, quantity)[:, k]).max())
        / (scene.lengths[point] * abs(scene.speed) ** order)
        for point, motion in exact.points.items()
        for letter, quantity, order in QUANTITIES
        for k, axis in enumerate("xy")
    )


@compiled
@pytest.mark.parametrize("mode", MODES)
# A closed form turning backwards, a cam with jumps of its acceleration, one pass.
@pytest.mark.parametrize(
    ("name", "speed"),
    [("saw-500rpm", -1.0), ("cam-follower", 1.0), ("geneva", -1.0)],
)
def test_fmpy_computes_the_exact_motion(name: str, speed: float, mode: str, tmp_path: Path) -> None:
    scene, content = export_scene(name, speed)
    turns = 1.0 if scene.mechanism().driver.span else 30.0
    run = fmpy.read_model_description(io.BytesIO(content)).defaultExperiment
    stop = turns * float(run.stopTime)
    result = simulate(
        content, tmp_path, fmi_type=mode, stop_time=stop, output_interval=(stop - float(run.startTime)) / 300
    )
    assert len(result) > 300
    assert largest_error(scene, result) < 1e-12


@compiled
@pytest.mark.slow
@pytest.mark.parametrize("name", [*SCENES, *catalogue_names()])
def test_fmu_of_every_machine_is_valid_and_exact(name: str, tmp_path: Path) -> None:
    from fmpy.validation import validate_fmu

    scene, content = export_scene(name)
    result = simulate(content, tmp_path)
    assert validate_fmu(str(tmp_path / "unit.fmu")) == []
    # Near its change points the parallelogram's own exact accelerations are rounded more.
    assert largest_error(scene, result) < (1e-11 if name == "parallelogram" else 1e-12)


@compiled
def test_only_speed_and_start_angle_are_parameters_of_an_fmu(tmp_path: Path) -> None:
    scene, content = export_scene("cam-follower")
    slow = scene.with_parameters(speed=-1.25)
    result = simulate(content, tmp_path, start_values={"speed": -1.25, "start_angle": 40.0}, stop_time=9.0)
    assert result["crank_angle"] == pytest.approx(40.0 - 1.25 * result["time"], abs=1e-13)
    assert largest_error(slow, result) < 1e-12
    unit = load_unit(tmp_path)
    unit.instantiate()
    with pytest.raises(fmpy.fmi1.FMICallException, match="SetFloat64"):
        unit.setFloat64([4], [0.0])
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    with pytest.raises(fmpy.fmi1.FMICallException, match="SetFloat64"):
        unit.setFloat64([1], [2.0])


@compiled
def test_fmu_of_a_pass_ends_with_a_reason_beyond_its_span(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(export_scene("geneva")[1], tmp_path, stop_time=export_scene("geneva")[0].period)
    assert re.search(
        r"crank angle 0\.[78]\d+ rad is out of range, -0\.785398163 to 0\.785398163 rad", capfd.readouterr()[0]
    )


@compiled
def test_fmu_has_every_function_of_the_standard(tmp_path: Path) -> None:
    header = Path(fmpy.__file__).with_name("c-code") / "fmi3FunctionTypes.h"
    library, names = load_unit(tmp_path).dll, re.findall(r"\b(fmi3\w+)TYPE\b", header.read_text(encoding="utf-8"))
    assert len(names) > 70
    assert [name for name in names if not hasattr(library, name)] == []
    # The same scene gives the same bytes.
    scene, content = export_scene("saw-500rpm")
    assert archive.fmu("saw-500rpm", scene)[0] == content


def test_fmu_without_a_compiler_holds_sources_and_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive, "COMPILER", "no-such-compiler")
    done = conrod("export", "saw-40rpm", "--format", "fmu", "-o", "saw.fmu", cwd=tmp_path)
    reason = "conrod: saw-40rpm: the FMU holds sources alone: there is no C compiler (no-such-compiler) here\n"
    assert (done.returncode, done.stdout, done.stderr) == (0, "", reason)
    names = zipfile.ZipFile(tmp_path / "saw.fmu").namelist()
    assert [name for name in names if "binaries" in name] == []
    assert {"sources/motion.c", "sources/motion_table.h", "sources/buildDescription.xml"} < set(names)
