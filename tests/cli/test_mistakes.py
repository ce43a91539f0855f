"""Mistakes on the command line: each gets one clear line and status 2, before anything is run or written."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from command_line import conrod, said

from tests.support.described import FOUR_BAR

MISTAKES = {
    # Names.
    "valdate": ("'valdate'", "validate"),
    "validate --presets tuned": ("--presets", "--preset"),
    "validate sheer-press": ("'sheer-press'", "did you mean 'shear-press'"),
    "validate --engine mujocco": ("'mujocco'", "did you mean 'mujoco'"),
    "validate --engine ''": ("unknown engine ''", "mujoco"),
    "validate --preset hardend": ("'hardend'", "did you mean 'hardened'"),
    "validate --engine pymunk --preset hardened": ("'hardened'", "stock, tuned"),
    "export saw-40rpm --format mjfc": ("'mjfc'", "mjcf"),
    # Parameters and their units.
    "validate --set crank": ("'crank'", "name=value"),
    "validate shear-press --set offset=1mm": ("'offset'", "slider_mass"),
    "validate saw-40rpm --set crank=80mm --set crank=70mm": ("crank", "twice", "'80mm'", "'70mm'"),
    "validate saw-40rpm --set crank=80mmm": ("80mmm", "for instance 80mm"),
    "validate saw-40rpm --set crank=80kg": ("'kg'", "m"),
    "validate saw-40rpm --set speed=8Hz": ("8Hz", "rpm"),
    "validate saw-40rpm --set crank=nan": ("nan", "not a number"),
    "validate saw-40rpm --set crank=1e999": ("inf", "finite"),
    "validate saw-40rpm --set crank=0": ("crank = 0", "<="),
    "validate saw-40rpm --set slider_mass=1e30": ("slider_mass", "1e+09"),
    "validate saw-40rpm --set speed=0rpm": ("speed = 0", "|speed|"),
    "validate saw-40rpm --set rod=150mm": ("turn fully", "0.15"),
    "validate shear-press --set crank=390mm": ("turn fully", "0.39"),
    "validate cam-follower --set flank_radius=72mm": ("flank_radius = 0.072", "0.0725"),
    "show --angle 60deg": ("SCENE",),
    "show saw-40rpm --angle soon": ("60deg",),
    "show saw-40rpm --angle 1e9": ("out of range",),
    "show saw-40rpm --angle 60mm": ("'mm' is not a unit of rad",),
    "show pass.toml --angle '70 deg'": ("one pass, from -10 to 60 deg",),
    # Tolerances, steps and revolutions.
    "validate --tolerance position=-1": ("position = -1",),
    "validate --tolerance jerk=1": ("'jerk'", "acceleration"),
    "validate --tolerance position=1,position=2": ("position", "twice"),
    "validate --tolerance ''": ("--tolerance ''", "name=value"),
    "validate --steps-per-rev ten": ("'ten'",),
    "validate --steps-per-rev 1": ("--steps-per-rev = 1", "2 <="),
    "validate --steps-per-rev 5000000": ("samples", "500000"),
    "validate --revolutions 0": ("--revolutions = 0", "1 <="),
    "export saw-40rpm --format csv --revolutions 1389": ("360 steps x 1389 revolutions", "500000"),
    "export saw-40rpm --format mjcf --revolutions 1": ("a model has no revolutions",),
    "recommend saw-500rpm": ("--position", "--acceleration"),
    "recommend saw-500rpm --position 0": ("--position",),
    "recommend saw-500rpm --position=-1e-6": ("--position",),
    "recommend saw-500rpm --position nan": ("--position",),
    "recommend saw-500rpm --position inf": ("--position",),
    # A grid, an axis, the rounds of a comparison.
    "sweep saw-500rpm --grid corse": ("unknown grid 'corse'", "did you mean 'coarse'?"),
    "sweep saw-500rpm --jobs 0": ("0 jobs", "1 to"),
    "sweep saw-500rpm --cell-timeout -1": ("time limit", "-1"),
    "sweep saw-500rpm --cell-memory lots": ("--cell-memory", "lots"),
    "sweep saw-500rpm --cluster tcp://127.0.0.1:9 --jobs 2": ("--jobs does not go with --cluster",),
    "results": ("there is no ledger", "conrod sweep"),
    "limits --axis step": ("unknown axis 'step'", "did you mean 'steps'?"),
    "limits saw-500rpm --axis float": ("saw", "float"),
    "limits saw-500rpm --axis flight": ("no cam",),
    "limits cam-follower --axis mass-ratio": ("mass-ratio", "connecting rod"),
    "limits cam-follower --axis steps-x-nearness": ("nearness",),
    "limits saw-500rpm --axis steps --range 100..100": ("--range 100..100 is empty",),
    "limits saw-500rpm --axis steps --range 100": ("'100' is no range", "20000..2"),
    "limits saw-500rpm --axis steps --range 100..": ("'100..' is no range", "20000..2"),
    "limits saw-500rpm --axis steps --range 100..1": ("1 is out of range",),
    "limits saw-500rpm --axis steps --range 99.5..10": ("99.5 is not a whole number",),
    "limits --axis steps --axis speed --range 9..3": ("one --axis",),
    "limits saw-500rpm --range 9..3": ("one --axis",),
    "limits saw-500rpm --axis rounding --range 0..1": ("its values are a list",),
    "limits saw-500rpm --axis steps --most-runs 0": ("--most-runs = 0 is out of range",),
    "limits saw-500rpm --axis steps --most-runs 40": ("--most-runs", "40", "up to"),
    "limits saw-500rpm --axis steps --cell-timeout 0": ("time limit of 0 s",),
    "limits saw-500rpm --axis steps --cell-memory 0": ("memory limit of 0",),
    "limits saw-500rpm --axis steps --cell-memory 200MB": ("is too little", "may need"),
    "limits saw-500rpm --axis run-length --revolutions 0": ("--revolutions", "1"),
    "limits --axis steps --revolutions 9": ("--revolutions 9", "run-length"),
    "limits --axis run-length --range 1..9 --revolutions 5": ("--range 1..9", "give one"),
    "limits cam-follower --axis steps --preset hardened": ("hardened",),
    "ablate": ("Missing argument",),
    "ablate saw-500rpm --set lift=1mm": ("unknown parameter 'lift'",),
    "ablate saw-500rpm --steps-per-rev 1": ("--steps-per-rev = 1 is out of range",),
    "ablate saw-500rpm --steps-per-rev 1000000": ("samples are too many",),
    "ablate saw-500rpm --rounds 1": ("--rounds = 1 is out of range",),
    "ablate saw-500rpm --cluster tcp://x:1 --jobs 2": ("--jobs does not go with",),
    # Names of outputs, and what is there already.
    "show --svg x.svg": ("SCENE",),
    "show saw-40rpm --svg a.png": ("a.png", ".svg"),
    "show saw-40rpm --svg ''": ("--svg ''", "name of a file"),
    "show saw-40rpm --figures ''": ("name of a folder",),
    "show saw-40rpm --figures . --svg centres.svg": ("it is the same file as --svg",),
    "export saw-40rpm --format csv -o ''": ("-o ''", "name of a file"),
    "export saw-40rpm --format csv -o -": ("-o '-'", "name of a file"),
    "export saw-40rpm --format npz": ("-o",),
    "validate --json ''": ("--json '': give the name of a",),
    "validate --json -": ("--json '-': give the name of a",),
    "validate --json new/": ("--json 'new/': give the name of a",),
    "validate --json nowhere/out.json": ("nowhere",),
    "validate --out ''": ("--out '': give the name of a",),
    "validate --out file": ("file",),
    "validate --out .": ("README.md that is not of this report",),
    "validate --out report --json link/results.json": ("link/results.json", "report"),
    "validate --out report --json link/saw-40rpm.md": ("link/saw-40rpm.md", "report"),
    "validate --out report --json link/figures/saw-40rpm-error.svg": ("link/figures/saw-40rpm-error.svg", "report"),
    "validate --out new/report --json new": ("new", "folder"),
    "sweep saw-500rpm --out file/x": ("cannot write into",),
    "sweep saw-500rpm --out report --json report/figures/a.svg": ("cannot write report/figures/a.svg: ",),
    "limits saw-500rpm --out report --json report/README.md": ("cannot write report/README.md: ",),
    "limits saw-500rpm --out report --json report/figures/steps.svg": ("cannot write report/figures/steps.svg: ",),
    "ablate saw-500rpm --out report --json report/README.md": ("has a file of that name",),
    "ablate saw-500rpm --out .": ("README.md that is not of this report",),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of somebody's, with an empty report in it."""
    made = tmp_path / "work"
    (made / "report" / "figures").mkdir(parents=True)
    (made / "link").symlink_to("report")
    for name, text in (("file", "mine"), ("README.md", "mine"), ("pass.toml", FOUR_BAR.read_text())):
        (made / name).write_text(text)
    return made


def contents(folder: Path) -> dict[Path, bytes | None]:
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.parametrize("command", MISTAKES)
def test_a_mistake_gets_one_clear_line_and_status_2_and_nothing_is_written(command: str, folder: Path) -> None:
    arguments = shlex.split(command)
    if arguments[0] in ("validate", "sweep", "limits", "ablate") and "--json" not in arguments:
        arguments += ["--json", "out.json"]
    before = contents(folder)
    done = conrod(*arguments, cwd=folder, ledger=folder.parent / "ledger.sqlite")
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = said(done)
    assert line.startswith("conrod: ")
    for words in MISTAKES[command]:
        assert words in line
    assert contents(folder) == before
