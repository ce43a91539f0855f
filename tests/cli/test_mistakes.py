"""Mistakes on the command line: each gets one clear line and status 2, before anything is run or written."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import refusal
from described import FOUR_BAR, SLIDER_CRANK
from own_model_edits import HACKSAW, ROD_END, TEXTS, replace_once
from table_files import csv_text, exact_table

from conrod.execution.baseline import Baseline, write_baseline
from conrod.scenes import SCENES

MODEL = "check hacksaw.xml --scene saw-40rpm"
GIVEN = f"{MODEL} --crank a --point C=x"
TABLE = "check t.csv --scene saw-500rpm"
MISTAKES = {
    # Names.
    "validate sheer-press": ("'sheer-press'", "did you mean 'shear-press'"),
    "validate --engine pymunk --preset hardened": ("pymunk has no preset 'hardened', mujoco has: choose from stock",),
    "export saw-40rpm": ("say with --format", "mjcf"),
    # A missing file, before anything else is asked for.
    "check none.xml": ("conrod: none.xml: there is no such file",),
    "check hacksav.xml": ("conrod: hacksav.xml: there is no such file: did you mean 'hacksaw.xml'?",),
    "check nowhere/saw.xml": ("conrod: nowhere/saw.xml: there is no such file: there is no folder nowhere",),
    "validate pas.toml": ("conrod: pas.toml: there is no such file: did you mean 'pass.toml'?",),
    "validate foreign": ("foreign: it is a folder; a machine goes by its name", "`conrod show`", ".toml"),
    "validate ''": ("unknown scene '': choose from", "more; all: conrod show"),
    "show empty.toml": ("empty.toml: it is empty", "conrod init"),
    "audit empty.csv": ("empty.csv: it is empty", "scene, quantity, angle_deg"),
    "report saw.xml": ("saw.xml: it is a file; give the folder of a report",),
    "versions saw.xml": ("the engine comes first: conrod versions mujoco saw.xml",),
    # Left out, or given twice.
    "sweep": ("sweep: give a SCENE: `conrod show` lists them",),
    "validate --tolerance position=1mm --tolerance=position=2mm": ("given twice", "'position=1mm'", "give it once"),
    "show saw-40rpm --angle 10deg --angle 20deg": ("--angle: given twice, as '10deg' and '20deg'",),
    "check foreign --scene saw-40rpm": ("conrod: foreign: it is a folder, not a file",),
    # Parameters and their units.
    "validate shear-press --set offset=1mm": ("'offset'", "slider_mass"),
    "validate saw-40rpm --set crank=80mm --set crank=70mm": ("crank", "twice", "'80mm'", "'70mm'"),
    "validate saw-40rpm --set crank=nan": ("nan", "not a number"),
    "validate cam-follower --set flank_radius=72mm": ("flank_radius = 0.072", "0.0725"),
    "show saw-40rpm --angle soon": ("60deg",),
    "show pass.toml --angle '70 deg'": ("one pass, from -10 to 60 deg",),
    # Mechanism files.
    "show taken.toml": ("conrod: taken.toml: ", "is taken by another scene"),
    "show apart.toml": ("conrod: apart.toml: ", "cannot be assembled at crank angle 0 deg: lengths do not reach"),
    # Tolerances, steps and revolutions.
    "validate --tolerance position=-1": ("position = -1",),
    "validate --tolerance jerk=1": ("'jerk'", "acceleration"),
    "forces saw-40rpm --quantity torq": ("unknown quantity 'torq'",),
    "forces saw-40rpm --quantity contact": ("no joint of saw-40rpm acts by contact",),
    "forces saw-40rpm --quantity torque --tolerance reactions=1e-3": ("unknown quantity 'reactions'",),
    "free pendulum --torque": ("no torque that drives its crank",),
    "free pendulum --tolerance velocity=1": ("velocity",),
    "free pendulum --seconds -1": ("--seconds = -1 s is out of range",),
    "free pendulum --step 1e-6 --seconds 10": ("steps; it must be 1 to",),
    "validate --steps-per-rev 1.5": ("--steps-per-rev = '1.5' is not a whole number; give for instance 1000",),
    "ablate saw-40rpm --rounds many": ("--rounds = 'many' is not a whole number",),
    "recommend saw-40rpm --position 0": ("--position = 0 is out of range: 0 < --position <= 1e+06",),
    "validate --steps-per-rev 10000000 --revolutions 3": ("samples", "20000000"),
    "export saw-40rpm --format mjcf --revolutions 1": ("--revolutions does not go with --format mjcf",),
    "validate double-rocker --steps-per-rev 5 --engine pymunk --preset tuned": ("are 0 of the pass: at least 3",),
    "export saw-40rpm --format mjcf --preset tuned": ("--preset does not go with --format mjcf",),
    "recommend saw-40rpm --position 1e-3 --engine pymunk --model saw.xml": ("files of models end otherwise", ".py"),
    "recommend saw-40rpm --position 1e-3 --engine mujoco --model saw.py": ("files of models end otherwise", ".xml"),
    "export saw-40rpm --format csv --free": ("--free does not go with --format csv",),
    "export saw-40rpm --format pack --motor": ("--motor does not go with --format pack",),
    "export saw-40rpm --format pymunk --motor": ("--motor goes with --free",),
    "export saw-40rpm --format pymunk --preset tund": ("'tund'", "did you mean 'tuned'"),
    "export saw-40rpm --format pymunk --steps-per-rev 1": ("--steps-per-rev", "2"),
    "export rack-and-wheel --format pymunk": ("rack-and-wheel: teeth: pymunk has no joint",),
    "export bennett --format mjcf --free": ("bennett is a machine in space",),
    "export bennett --format mjcf --set crank=3": ("bennett is a machine in space",),
    "validate saw-40rpm --cell-memory nanGB": ("--cell-memory",),
    "validate saw-40rpm --cell-timeout 0": ("--cell-timeout",),
    "validate saw-40rpm --json l.sqlite --ledger l.sqlite": ("it is the same file as the ledger",),
    "show pass.toml --json pass.toml": ("cannot write pass.toml: it is a mechanism file",),
    "results --csv x.out --json ./x.out --ledger l.sqlite": ("it is the same file as --csv",),
    # A grid, an axis, the rounds of a comparison.
    "sweep saw-500rpm --jobs 0": ("0 jobs", "1 to"),
    # Releases of an engine.
    "versions mujoco --versions 3.x": ("--versions: '3.x' is no version", "3.6.0,3.7.0"),
    "sweep saw-500rpm --cluster tcp://127.0.0.1:9 --jobs 2": ("--jobs does not go with --cluster",),
    "results": ("there is no ledger", "--ledger"),
    "limits --axis step": ("unknown axis 'step'", "did you mean 'steps'?"),
    "limits saw-500rpm --axis flight": ("no follower that a force holds down",),
    "limits saw-500rpm --axis steps --range 100..1": ("1 is out of range",),
    "ablate saw-500rpm --steps-per-rev 1000000": ("samples are too many",),
    # Names of outputs, and what is there already.
    "sweep saw-500rpm --ledger file": ("cannot use the ledger file: file is not a database",),
    "show --svg x.svg": ("SCENE",),
    "export saw-40rpm --format csv -o ''": ("-o ''", "name of a file"),
    "validate --out .": ("README.md that is not of this report",),
    "validate --out foreign": ("results.json that is not",),
    "validate --out report --json link/results.json": ("link/results.json", "report"),
    "validate --json pipe": ("pipe", "regular file"),
    "validate --json link-to-pipe": ("link-to-pipe", "regular file"),
    "export saw-40rpm --format csv -o itself": ("itself", "regular file"),
    "export saw-40rpm --format csv -o pipe": (
        "cannot write pipe: it is not a regular file",
    ),  # a pipe of the test: a defect may replace it
    "export saw-40rpm --format csv -o report": ("report", "folder"),
    "validate saw-40rpm --out linked": ("linked: README.md in it is not a regular file",),
    "validate saw-40rpm --out linked-figure": ("figures/saw-40rpm-error.svg",),
    "validate --out new/report --json new": ("new", "folder"),
    "sweep saw-500rpm --out report --json report/figures/a.svg": ("cannot write report/figures/a.svg: ",),
    "validate saw-500rpm --baseline new.json --json new.json": ("it is the same file as the baseline",),
    "validate saw-500rpm --preset stock --baseline saw.json": ("the baseline is of something else: ",),
    # Models that are linted or hardened.
    "lint model.mjb": ("a binary model cannot be taken apart; give the MJCF",),
    "lint saw.xml --json same.xml": ("it is the same file as the model",),
    "harden legged.xml --ctrl moter=1": ("moter: the model has no actuator",),
    "harden legged.xml --keyframe swung": ("did you mean 'swing'?",),
    **{f"{verb} endless.xml": ("pipe is no regular file",) for verb in ("lint", "harden")},
    "check endless.xml --scene saw-40rpm --crank j --point C=body:b": ("pipe is no regular file",),
    "harden includes.xml --json part.inc": ("part.inc, which the model is made of",),
    "harden legged.xml -o hard.mjb --json there/hard.mjb": ("it is the same file as -o",),
    # Models and tables that are validated.
    "check saw.xml there/saw.xml --drive crank=60rpm": ("another has the same name in the report",),
    f"{MODEL} --point C=C": ("unknown site 'C': did you mean 'crankpin'?", "taken as --crank motor"),
    f"{MODEL} --crank motor --point D=x": ("unknown observed point 'D': choose from C, M",),
    f"{MODEL} --crank moter --point C=body:bow": ("hacksaw.xml: unknown joint 'moter': did you mean 'motor'?",),
    f"{MODEL} --crank motor --point 'C=crank pin'": ("unknown site 'crank pin': did you mean 'crankpin'?",),
    f"{MODEL} --crank motor --point C=body:bow --keyframe a": ("unknown keyframe 'a': choose from qpos0",),
    "check cut.xml --scene saw-40rpm --crank crank --point C=C": ("cut.xml: it is no XML: no element found: line",),
    "check crossed.xml": ("it is no XML: mismatched tag: line 1, column 27; <body> is opened and not closed",),
    "check nan.xml --scene saw-40rpm --crank crank --point C=C": ("site_pos is not finite",),
    f"{GIVEN} --preset tuned": ("--preset does not go with a model",),
    "check saw.xml --scene saw-40rpm --crank crank --point C=C --json same.xml": ("it is the same file as",),
    "check saw.sdf --scene saw-40rpm --crank crank": ("a file is known by its ending, one of .xml, .m",),
    "validate saw-40rpm --crank a": ("--crank does not go with a scene: it is for a file",),
    "check t.csv": ("say with --scene",),
    f"{TABLE} saw-40rpm": ("t.csv: a file is judged on its own, without saw-40rpm",),
    # What to type in place of what was typed.
    "check saw.xml my.toml": ("as the machine of my.toml: conrod check saw.xml --scene my.toml",),
    "lint saw-40rpm": (
        "saw-40rpm: it is a scene",
        "conrod export saw-40rpm --format mjcf -o saw-40rpm.xml && conrod lint",
    ),
    "harden shear-press": ("shear-press: it is a scene", "&& conrod harden shear-press.xml"),
    "recommend saw.xml --position 1e-4": ("a model of your own is judged by: conrod check saw.xml --drive",),
    "show saw-320rpm": ("another speed is given by --set: saw-500rpm --set speed=320rpm",),
    f"{TABLE} --crank hinge": ("--crank does not go with a table",),
    f"{TABLE} --estimate fase": ("unknown thing to estimate 'fase'",),
    f"{TABLE} --json link.csv": ("--json link.csv: it is the same file as the table",),
}


FILES = {
    "file": "mine",
    "README.md": "mine",
    "pass.toml": FOUR_BAR.read_text(),
    "taken.toml": replace_once(SLIDER_CRANK.read_text(), 'name = "slider-crank"', 'name = "saw-40rpm"'),
    "apart.toml": re.sub(r'(B = \[)"?[\d.]+ ?m*"?', r'\1"9 m"', FOUR_BAR.read_text(), count=1),
    "hacksaw.xml": HACKSAW.read_text(),
    "legged.xml": (Path(__file__).parents[1] / "support" / "models" / "legged.xml").read_text(),
    "saw.xml": TEXTS["saw"],
    "saw.sdf": TEXTS["saw"],
    "cut.xml": TEXTS["saw"][:4000],
    "crossed.xml": "<mujoco><worldbody><body></mujoco>",
    "empty.toml": "\n",
    "empty.csv": "",
    "nan.xml": replace_once(TEXTS["saw"], ROD_END, 'name="slider-pin.rod" pos="nan 0 0"'),
    "model.mjb": "",
    "includes.xml": '<mujoco><include file="nowhere.xml"/><include file="part.inc"/></mujoco>',
    "part.inc": "<mujoco/>",
    "endless.xml": '<mujoco><include file="pipe"/></mujoco>',
    "foreign/results.json": "not json",
    "t.csv": csv_text(exact_table(SCENES["saw-500rpm"])),
}
LINKS = {
    "link": "report", "there": ".", "link.mjb": "model.mjb", "link.csv": "t.csv", "link-to-pipe": "pipe",
    "itself": "itself", "linked/README.md": "elsewhere", "linked-figure/figures/saw-40rpm-error.svg": "elsewhere",
}  # fmt: skip
HARD_LINKS = {"same.xml": "saw.xml", "hard.csv": "t.csv"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of somebody's, with an empty report in it; each mistake leaves it as it was."""
    made = tmp_path_factory.mktemp("mistakes") / "work"
    for name in ("report/figures", "foreign", "d.csv", "linked", "linked-figure/figures"):
        (made / name).mkdir(parents=True)
    os.mkfifo(made / "pipe")
    for name, text in FILES.items():
        (made / name).write_text(text)
    write_baseline(made / "saw.json", Baseline({"scene": ["saw-500rpm"]}, "ab", {}, {}))
    for name, other in LINKS.items():
        (made / name).symlink_to(other)
    for name, other in HARD_LINKS.items():
        (made / name).hardlink_to(made / other)
    return made


def contents(folder: Path) -> dict[Path, bytes | None]:
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("command", MISTAKES)
def test_mistake_gets_one_line_status_2_and_writes_nothing(command: str, folder: Path, tmp_path: Path) -> None:
    arguments = shlex.split(command)
    if (
        arguments[0] in ("validate", "forces", "free", "check", "sweep", "limits", "ablate")
        and "--json" not in arguments
    ):
        arguments += ["--json", "out.json"]
    before = contents(folder)
    line = refusal(*arguments, cwd=folder, ledger=tmp_path / "ledger.sqlite")
    for words in MISTAKES[command]:
        assert words in line
    assert contents(folder) == before
    # Nor a ledger, but where only the settings of a run tell that it is too short.
    assert any(tmp_path.iterdir()) is ("double-rocker" in command)


# -- whatever a file says: no file is waited for that has no end -------------------------------------------------------

BODY = '<body name="b"><joint name="j" type="hinge" axis="0 1 0"/><geom name="g" size="0.1" pos="0 0 -0.5"/></body>'
FIELD = '<asset><hfield name="h" nrow="30000" ncol="30000" size="1 1 1 1"/></asset>'
VERBS = {
    "lint": ("lint", "m.xml"),
    "harden": ("harden", "m.xml"),
    "check": ("check", "m.xml", "--scene", "saw-40rpm", "--crank", "j", "--point", "C=body:b"),
}


def model(folder: Path, beside: str = "", worldbody: str = "") -> None:
    text = f"<mujoco>{beside}<worldbody>{worldbody}{BODY}</worldbody></mujoco>"
    (folder / "m.xml").write_text(text, encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("verb", VERBS)
def test_a_height_field_of_gigabytes_is_out_of_memory(verb: str, tmp_path: Path) -> None:
    model(tmp_path, FIELD, '<geom type="hfield" hfield="h"/>')
    assert "needed more memory than its limit" in refusal(*VERBS[verb], cwd=tmp_path)


@pytest.mark.parametrize(
    "verb", ["lint", *(pytest.param(verb, marks=pytest.mark.slow) for verb in ("harden", "check"))]
)
def test_long_compilation_says_so_and_ends_on_ctrl_c(verb: str, tmp_path: Path) -> None:
    # Compiling it takes hours.
    model(tmp_path, worldbody=f'<replicate count="149999">{BODY}</replicate>')
    # What a shell starts in the background ignores Ctrl-C, and so would this.
    code = (
        "import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from conrod import cli\ncli.WAITING_NOTICE_DELAY = 2.0\ncli.main()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-P", "-c", code, *VERBS[verb]], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    ) as running:  # fmt: skip
        try:
            assert "m.xml: running (stops itself after 600 s; Ctrl-C stops now)" in running.stderr.readline()
            os.killpg(running.pid, signal.SIGINT)
            # Standard error ends where the last process has it no more: none is left that compiles.
            assert running.stderr.read().strip() == "conrod: interrupted"
            assert running.wait() == 130
        finally:
            running.kill()
