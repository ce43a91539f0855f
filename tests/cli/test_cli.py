"""What a user types, and sees."""

from __future__ import annotations

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import conrod, conrod_process

from conrod.report.figure import Figure
from conrod.scenes import SCENES

ENTRY_KEYS = {
    "scene", "parameters", "engine", "engine_version", "preset", "settings", "mode", "steps_per_revolution",
    "revolutions", "outcome", "errors", "closure", "phase", "drive", "order", "tolerance", "passed",
}  # fmt: skip

# A run of a tenth of a second.
QUICK = ("validate", "saw-40rpm", "--engine", "pymunk", "--preset", "tuned", "--steps-per-rev", "100")


def files_in(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*"))


IN_A_PROCESS = {
    "measured": (("show", "saw-40rpm"), 0),
    "a table": (("export", "saw-40rpm", "--format", "csv", "--steps-per-rev", "4"), 0),
    "out of tolerance": ((*QUICK, "--tolerance", "position=1e-9"), 1),
    "a mistake": (("validate", "sheer-press"), 2),
    "a mistake in an option": (("validate", "--presets", "tuned"), 2),
}


def said(done: subprocess.CompletedProcess[str]) -> list[str]:
    """What standard error has besides the progress of runs, which takes time and goes by what has been run before."""
    return [line for line in done.stderr.splitlines() if not line.startswith("runs: ")]


@pytest.mark.parametrize("command", IN_A_PROCESS)
def test_a_python_of_its_own_prints_the_same_and_ends_with_the_same_status(command: str) -> None:
    # All other tests run the command line in their own process.
    arguments, status = IN_A_PROCESS[command]
    alone, here = conrod_process(*arguments), conrod(*arguments)
    assert alone.returncode == here.returncode == status
    assert (alone.stdout, said(alone)) == (here.stdout, said(here))
    assert alone.stdout or alone.stderr


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
    assert document["kind"] == "validation"
    assert {"schema", "conrod", "environment", "parts"} <= set(document)
    entries = document["parts"]["saw-40rpm"]["findings"]["results"]
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


@pytest.mark.parametrize("speed", ["500 rev/min", "500rpm", "500 revolution/minute"])
def test_a_speed_is_written_as_machinists_write_it(speed: str) -> None:
    done = conrod("show", "saw-40rpm", "--set", f"speed={speed}")
    assert done.returncode == 0, done.stderr
    assert next(line.split()[1:3] for line in done.stdout.splitlines() if line.startswith("speed")) == ["500", "rpm"]


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
    "steps of a table": (
        ("export", "saw-40rpm", "--format", "csv", "--revolutions", "1389"),
        ("360 steps x 1389 revolutions", "500000"),
    ),
    "revolutions of a model": (
        ("export", "saw-40rpm", "--format", "mjcf", "--revolutions", "1"),
        ("a model has no revolutions",),
    ),
    "parameter twice": (
        ("validate", "saw-40rpm", "--set", "crank=80mm", "--set", "crank=70mm"),
        ("crank", "twice", "'80mm'", "'70mm'"),
    ),
    "tolerance twice": (("validate", "--tolerance", "position=1,position=2"), ("position", "twice")),
    "no engine": (("validate", "--engine", ""), ("unknown engine ''", "mujoco")),
    "no preset": (("validate", "--preset", ""), ("unknown preset ''", "tuned")),
    "no tolerance": (("validate", "--tolerance", ""), ("--tolerance ''", "name=value")),
    "drawing that is no SVG": (("show", "saw-40rpm", "--svg", "a.png"), ("a.png", ".svg")),
    "drawing without a name": (("show", "saw-40rpm", "--svg", ""), ("--svg ''", "name of a file")),
    "export without a name": (("export", "saw-40rpm", "--format", "csv", "-o", ""), ("-o ''", "name of a file")),
    "export to a dash": (("export", "saw-40rpm", "--format", "csv", "-o", "-"), ("-o '-'", "name of a file")),
    "no revolutions": (("validate", "--revolutions", "0"), ("--revolutions = 0", "1 <=")),
    "too many samples": (("validate", "--steps-per-rev", "5000000"), ("samples", "500000")),
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


# -- what is written, and what is left alone -------------------------------------------------------------------------


def refused(done: subprocess.CompletedProcess[str], *words: str) -> None:
    """One clear line, before anything was run."""
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1, done.stderr
    for word in words:
        assert word in done.stderr


@pytest.mark.parametrize(("option", "text"), [("--json", ""), ("--json", "-"), ("--json", "new/"), ("--out", "")])
def test_an_output_without_a_name_is_refused(option: str, text: str, tmp_path: Path) -> None:
    refused(conrod("validate", option, text, cwd=tmp_path), f"{option} {text!r}: give the name of a")
    assert files_in(tmp_path) == []


@pytest.mark.parametrize("kind", ["folder", "pipe", "device", "link to a pipe", "link to itself"])
@pytest.mark.parametrize("command", [("validate", "--json"), ("export", "saw-40rpm", "--format", "csv", "-o")])
def test_what_is_not_a_regular_file_is_refused(command: tuple[str, ...], kind: str, tmp_path: Path) -> None:
    target = tmp_path / "target"
    match kind:
        case "folder":
            target.mkdir()
        case "pipe":
            os.mkfifo(target)
        case "device":
            target = Path(os.devnull)
        case "link to a pipe":
            os.mkfifo(tmp_path / "pipe")
            target.symlink_to("pipe")
        case "link to itself":
            target.symlink_to("target")
    before, mode = files_in(tmp_path), target.lstat().st_mode
    refused(conrod(*command, str(target), cwd=tmp_path), str(target), "folder" if kind == "folder" else "regular file")
    assert files_in(tmp_path) == before
    assert target.lstat().st_mode == mode


@pytest.mark.parametrize("there", [True, False])
def test_a_link_stays_a_link_and_the_file_behind_it_is_written(there: bool, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    if there:
        (tmp_path / "data" / "real.csv").write_text("old")
    (tmp_path / "link.csv").symlink_to("data/real.csv")
    done = conrod("export", "saw-40rpm", "--format", "csv", "-o", "link.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "data" / "real.csv").read_text().startswith("time [s]")
    assert files_in(tmp_path) == ["data", "data/real.csv", "link.csv"]


@pytest.mark.parametrize("name", ["README.md", "results.json", "saw-40rpm.md", "figures/saw-40rpm-error.svg"])
def test_results_may_not_take_the_place_of_a_file_of_the_report(name: str, tmp_path: Path) -> None:
    (tmp_path / "report" / "figures").mkdir(parents=True)
    (tmp_path / "link").symlink_to("report")
    before = files_in(tmp_path)
    refused(conrod(*QUICK, "--out", "report", "--json", f"link/{name}", cwd=tmp_path), f"link/{name}", "report")
    assert files_in(tmp_path) == before


def test_results_may_not_take_the_place_of_the_reports_folder(tmp_path: Path) -> None:
    refused(conrod(*QUICK, "--out", "new/report", "--json", "new", cwd=tmp_path), "new", "folder")
    assert files_in(tmp_path) == []


@pytest.mark.parametrize("beside", [None, "{}", '{"schema": 1, "results": []}', "not json"])
@pytest.mark.parametrize("name", ["README.md", "saw-40rpm.md"])
def test_a_folder_with_files_of_somebody_else_is_not_made_a_report(
    name: str, beside: str | None, tmp_path: Path
) -> None:
    (tmp_path / name).write_text("mine")
    if beside is not None:
        (tmp_path / "results.json").write_text(beside)
    before = files_in(tmp_path)
    refused(conrod(*QUICK, "--out", ".", cwd=tmp_path), "that is not")
    assert (tmp_path / name).read_text() == "mine"
    assert files_in(tmp_path) == before


def test_results_of_an_earlier_run_are_not_taken_for_a_report(tmp_path: Path) -> None:
    (tmp_path / "results.json").write_text('{"schema": 1, "results": []}')
    refused(conrod(*QUICK, "--out", ".", cwd=tmp_path), "results.json that is not a conrod report")


@pytest.mark.parametrize("name", ["README.md", "figures", "figures/saw-40rpm-error.svg"])
def test_a_report_with_a_link_in_it_is_refused(name: str, tmp_path: Path) -> None:
    if "/" in name:
        (tmp_path / "figures").mkdir()
    (tmp_path / name).symlink_to("elsewhere")
    refused(conrod(*QUICK, "--out", ".", cwd=tmp_path), name)
    assert (tmp_path / name).is_symlink()


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures take a second or two; tests of their files alone need not see them drawn."""
    monkeypatch.setattr(Figure, "svg", lambda figure: figure.alt)


@pytest.mark.usefixtures("blank_figures")
def test_a_report_is_written_over_an_earlier_one_with_the_results_beside_it(tmp_path: Path) -> None:
    # Negative control of the refusals above; also of a report behind a link.
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    for _ in range(2):
        done = conrod(*QUICK, "--out", "link", "--json", "link/all.json", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "link").is_symlink()
        assert {"README.md", "all.json", "data", "figures", "results.json", "saw-40rpm.md"} == {
            path.name for path in (tmp_path / "real").iterdir()
        }


def test_a_report_of_a_run_has_its_figures(tmp_path: Path) -> None:
    assert conrod(*QUICK, "--out", "report", cwd=tmp_path).returncode == 0
    page = (tmp_path / "report" / "saw-40rpm.md").read_text()
    named = {path for path in files_in(tmp_path / "report") if path.endswith(".svg") and "overview" not in path}
    assert {f"figures/saw-40rpm-{name}.svg" for name in ("mechanism", "motion", "error", "order")} == named
    for name in named:
        assert f"]({name})" in page
        assert (tmp_path / "report" / name).read_text().rstrip().endswith("</svg>")


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize("name", ["conrod.report.figure.Figure.svg", "conrod.report.writer.json_text"])
def test_an_interrupt_while_the_report_is_made_leaves_nothing_and_says_no_more_than_that(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(name, stop)
    done = conrod(*QUICK, "--out", "new/report", "--json", "all.json", cwd=tmp_path)
    assert done.returncode == 130
    assert said(done)[-1] == "conrod: interrupted"
    assert files_in(tmp_path) == []


def test_running_out_of_memory_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("conrod.cli.runner.pursue", full)
    done = conrod(*QUICK, "--out", "report", "--json", "all.json", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said(done) == ["conrod: out of memory: fewer --steps-per-rev or --revolutions"]
    assert files_in(tmp_path) == []


def test_a_full_disk_names_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    done = conrod("export", "saw-40rpm", "--format", "csv", "-o", "table.csv", cwd=tmp_path)
    refused(done, "No space left on device", "table.csv")
    assert files_in(tmp_path) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_standard_output_is_named_too() -> None:
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "conrod", "export", "saw-40rpm", "--format", "csv"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=300, check=False)
    assert done.returncode == 2
    assert done.stderr == "conrod: No space left on device: standard output\n"


def test_a_table_is_measured_by_its_own_samples_not_by_the_models_steps(tmp_path: Path) -> None:
    # The 62832 steps of the cam's model would have been far too many.
    done = conrod("export", "cam-follower", "--format", "npz", "--revolutions", "20", "-o", "cam.npz", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with np.load(tmp_path / "cam.npz") as archive:
        assert len(archive["time"]) == 20 * 360 + 1


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
