"""What a user types, and sees."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from conrod.scenes import SCENES

ENTRY_KEYS = {
    "scene", "parameters", "engine", "engine_version", "preset", "settings", "mode", "steps_per_revolution",
    "revolutions", "outcome", "errors", "closure", "phase", "drive", "order", "tolerance", "passed",
}  # fmt: skip


def conrod(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "conrod", *arguments], capture_output=True, text=True, cwd=cwd, timeout=300, check=False
    )


def files_in(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*"))


def test_show_lists_every_scene_in_a_line() -> None:
    done = conrod("show")
    assert done.returncode == 0
    for name in SCENES:
        assert sum(line.startswith(name) for line in done.stdout.splitlines()) == 1


@pytest.mark.parametrize("name", SCENES)
def test_show_tells_mobility_stroke_masses_and_references_of_a_scene(name: str) -> None:
    done = conrod("show", name)
    assert done.returncode == 0
    for word in ("mobility: 1", "stroke of", "dead centre", "kg", "closed form", "generic"):
        assert word in done.stdout


def test_show_draws_the_scene(tmp_path: Path) -> None:
    done = conrod("show", "saw-40rpm", "--svg", "saw.svg", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "saw.svg").read_text().rstrip().endswith("</svg>")


def test_validate_writes_one_json_entry_per_engine_preset_and_mode(tmp_path: Path) -> None:
    done = conrod("validate", "saw-40rpm", "--steps-per-rev", "200", "--json", "out.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr + done.stdout
    document = json.loads((tmp_path / "out.json").read_text())
    assert document["schema"] == 1
    assert {"conrod", "environment", "results"} <= set(document)
    entries = document["results"]
    assert all(set(entry) >= ENTRY_KEYS for entry in entries)
    combinations = {(e["engine"], e["mode"], e["preset"]) for e in entries}
    assert combinations == {
        ("mujoco", "kinematic", None),
        ("pymunk", "kinematic", None),
        *(("mujoco", "dynamic", p) for p in ("stock", "tuned", "hardened")),
        *(("pymunk", "dynamic", p) for p in ("stock", "tuned")),
    }
    for entry in entries:
        assert set(entry["errors"]) == {"C", "M"}
        assert set(entry["errors"]["C"]["position"]) == {"max", "rms", "final"}
        judged = entry["mode"] == "kinematic" or entry["preset"] != "stock"
        assert entry["passed"] is (True if judged else None)


def test_exit_status_is_1_when_something_is_out_of_tolerance() -> None:
    done = conrod("validate", "saw-40rpm", "--engine", "pymunk", "--preset", "stock", "--tolerance", "position=1e-9")
    assert done.returncode == 1
    assert "OUT OF TOLERANCE" in done.stdout


def test_stock_is_judged_only_where_asked_for() -> None:
    command = ("validate", "saw-40rpm", "--engine", "pymunk", "--preset", "stock")
    assert "measured, not judged" in conrod(*command).stdout
    asked = conrod(*command, "--tolerance", "position=0.1,velocity=0.1")
    assert asked.returncode == 0
    assert "not judged" not in asked.stdout


def test_hardened_does_not_apply_to_contact_and_says_so() -> None:
    done = conrod("validate", "cam-follower", "--engine", "mujoco", "--preset", "hardened", "--steps-per-rev", "4000")
    assert done.returncode == 0
    assert "unsupported" in done.stdout
    assert "contact" in done.stdout


def test_values_take_units() -> None:
    done = conrod("show", "saw-40rpm", "--set", "crank=8cm", "--set", "speed=-500rpm")
    assert done.returncode == 0
    lines = {line.split()[0]: line.split()[1:3] for line in done.stdout.splitlines() if line}
    assert lines["crank"] == ["80", "mm"]
    assert lines["speed"] == ["-500", "rpm"]


def test_exported_csv_is_the_exact_trajectory_with_units() -> None:
    done = conrod("export", "shear-press", "--format", "csv", "--steps-per-rev", "36")
    rows = list(csv.reader(io.StringIO(done.stdout)))
    assert rows[0][:4] == ["time [s]", "crank_angle [rad]", "A.x [m]", "A.y [m]"]
    values = np.array(rows[1:], dtype=float)
    assert len(values) == 37
    exact = SCENES["shear-press"].reference(values[:, 0]).point("A")
    assert np.array_equal(values[:, 2:4], exact.position)
    assert np.array_equal(values[:, 8:10], exact.jerk)


def test_exported_npz_holds_the_same_columns(tmp_path: Path) -> None:
    assert conrod("export", "saw-40rpm", "--format", "npz", "-o", "saw.npz", cwd=tmp_path).returncode == 0
    with np.load(tmp_path / "saw.npz") as archive:
        exact = SCENES["saw-40rpm"].reference(archive["time"]).point("M")
        assert np.array_equal(archive["M.ay"], exact.acceleration[:, 1])
        assert dict(archive["units"])["M.ay"] == "m/s^2"


BAD = {
    "unknown scene": (("validate", "sheer-press"), ("'sheer-press'", "did you mean 'shear-press'")),
    "unknown engine": (("validate", "--engine", "mujocco"), ("'mujocco'", "did you mean 'mujoco'")),
    "unknown preset": (("validate", "--preset", "hardend"), ("'hardend'", "did you mean 'hardened'")),
    "preset that no selected engine has": (
        ("validate", "--engine", "pymunk", "--preset", "hardened"),
        ("'hardened'", "stock, tuned"),
    ),
    "parameter that no selected scene has": (
        ("validate", "shear-press", "--set", "offset=1mm"),
        ("'offset'", "slider_mass"),
    ),
    "unknown unit": (("validate", "saw-40rpm", "--set", "crank=80mmm"), ("80mmm", "for instance 80mm")),
    "unit of another dimension": (("validate", "saw-40rpm", "--set", "crank=80kg"), ("'kg'", "m")),
    "ambiguous unit": (("validate", "saw-40rpm", "--set", "speed=8Hz"), ("8Hz", "rpm")),
    "nan": (("validate", "saw-40rpm", "--set", "crank=nan"), ("nan", "not a number")),
    "infinite": (("validate", "saw-40rpm", "--set", "crank=1e999"), ("inf", "finite")),
    "zero": (("validate", "saw-40rpm", "--set", "crank=0"), ("crank = 0", "<=")),
    "absurd": (("validate", "saw-40rpm", "--set", "slider_mass=1e30"), ("slider_mass", "1e+09")),
    "speed zero": (("validate", "saw-40rpm", "--set", "speed=0rpm"), ("speed = 0", "|speed|")),
    "cannot turn fully": (("validate", "saw-40rpm", "--set", "rod=150mm"), ("turn fully", "0.15")),
    "press cannot turn": (("validate", "shear-press", "--set", "crank=390mm"), ("turn fully", "0.39")),
    "flank below its minimum": (
        ("validate", "cam-follower", "--set", "flank_radius=72mm"),
        ("flank_radius = 0.072", "0.0725"),
    ),
    "no value": (("validate", "--set", "crank"), ("'crank'", "name=value")),
    "negative tolerance": (("validate", "--tolerance", "position=-1"), ("position = -1",)),
    "unknown quantity": (("validate", "--tolerance", "jerk=1"), ("'jerk'", "acceleration")),
    "too few steps": (("validate", "--steps-per-rev", "1"), ("--steps-per-rev = 1", "2 <=")),
    "no revolutions": (("validate", "--revolutions", "0"), ("--revolutions = 0", "1 <=")),
    "too many samples": (("validate", "--steps-per-rev", "5000000"), ("samples", "2000000")),
    "not a number of steps": (("validate", "--steps-per-rev", "ten"), ("'ten'",)),
    "unknown option": (("validate", "--presets", "tuned"), ("--presets", "--preset")),
    "unknown command": (("valdate",), ("'valdate'", "validate")),
    "unknown format": (("export", "saw-40rpm", "--format", "mjfc"), ("'mjfc'", "mjcf")),
    "binary to the terminal": (("export", "saw-40rpm", "--format", "npz"), ("-o",)),
    "drawing without scene": (("show", "--svg", "x.svg"), ("SCENE",)),
}


@pytest.mark.parametrize("mistake", BAD)
def test_a_mistake_gets_one_clear_line_and_status_2(mistake: str, tmp_path: Path) -> None:
    arguments, expected = BAD[mistake]
    outputs = ("--out", "report", "--json", "out.json") if arguments[0] == "validate" else ()
    done = conrod(*arguments, *outputs, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1, done.stderr
    for words in expected:
        assert words in done.stderr
    assert files_in(tmp_path) == []


@pytest.mark.parametrize("option", ["--out", "--json"])
def test_an_output_that_cannot_be_written_is_refused_before_any_work(option: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    target = "file" if option == "--out" else "nowhere/out.json"
    done = conrod("validate", option, target, cwd=tmp_path)
    assert done.returncode == 2
    assert target.split("/", maxsplit=1)[0] in done.stderr
    assert (tmp_path / "file").read_text() == "mine"
    assert files_in(tmp_path) == ["file"]


def test_help_loads_neither_engine_nor_plotting_nor_numerics() -> None:
    code = (
        "import sys; sys.argv = ['conrod', '--help']\n"
        "from conrod.cli import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "heavy = {'mujoco', 'pymunk', 'matplotlib', 'numpy', 'pint', 'rich'} & set(sys.modules)\n"
        "sys.exit(f'loaded: {heavy}' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "validate" in done.stdout
