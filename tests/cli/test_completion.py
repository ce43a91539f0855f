"""A shell completes what there is, and files of the endings that a verb takes."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from conrod.cli import COMPLETION, cli
from conrod.cli.bash_completion import LineCompletion


def completions(*words: str, begun: str = "") -> list[str]:
    """Words that a shell offers after those typed."""
    shell = ShellComplete(cli, {}, "conrod", "_CONROD_COMPLETE")
    return [item.value for item in shell.get_completions(list(words), begun)]


@pytest.mark.parametrize(
    ("words", "begun", "found"),
    [
        (("validate",), "saw-5", ["saw-500rpm"]),
        (("validate", "--fresh", "saw-40rpm"), "benn", ["bennett"]),
        (("forces",), "benn", []),  # a machine in space has no planar forces
        (("sweep",), "catal", ["catalogue"]),
        (("validate", "--engine"), "pym", ["pymunk"]),
        (("versions",), "muj", ["mujoco"]),
        (("validate", "--preset"), "hard", ["hardened"]),
        (("validate", "--engine", "pymunk", "--preset"), "", ["stock", "tuned"]),
        (("limits", "--axis"), "speed", ["speed"]),
        ((), "inv", ["invariances"]),
        (("validate", "saw-40rpm", "--set"), "crank", ["crank=", "crank_mass=", "crank_inertia="]),
        (("show", "four-bar-swing", "--set"), "slider", []),
        (("lint", "saw.xml", "--ignore"), "silent", ["silent-reset"]),
        (("explain",), "arc", ["arc length"]),
        (("explain", "arc"), "l", ["length"]),
    ],
)
def test_names_are_completed_where_they_may_stand(words: tuple[str, ...], begun: str, found: list[str]) -> None:
    assert completions(*words, begun=begun) == found


MODEL = """<mujoco>
  <default><default class="rail"><joint type="slide"/><default class="short"/></default></default>
  <worldbody>
    <body name="crank"><joint name="crank"/><site name="Q"/><geom name="web"/>
      <body childclass="short"><joint name="bed"/><joint name="bend" class="main" type="hinge"/></body>
      <include file="parts/leg.xml"/></body>
  </worldbody>
  <equality><joint name="coupling" joint1="crank" joint2="bed"/></equality>
  <actuator><motor name="motor" joint="crank"/></actuator>
  <keyframe><key name="up"/></keyframe>
</mujoco>"""
LEG = """<mujocoinclude><body name="leg"><joint name="ball" type="ball"/><joint name="knee"/><joint name="two words"/>
  <include file="leg.xml"/></body></mujocoinclude>"""


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "leg.xml").write_text(LEG)
    (tmp_path / "saw.xml").write_text(MODEL)
    return tmp_path / "saw.xml"


@pytest.mark.parametrize(
    ("words", "begun", "found"),
    [
        (("--drive",), "", ["crank=", "bend=", "knee=", "bed=", "motor="]),
        (("--drive", "crank=60rpm", "--drive"), "k", ["knee="]),
        (("--ctrl",), "", ["motor="]),
        (("--keyframe",), "", ["up", "qpos0"]),
        (("--scene", "saw-40rpm", "--crank"), "", ["crank", "bend", "knee"]),
        (("--scene", "saw-40rpm", "--point"), "", ["C=", "M="]),
        (("--scene", "saw-40rpm", "--point"), "C=", ["C=site:", "C=body:", "C=geom:"]),
        (("--scene", "saw-40rpm", "--point"), "C=site:", ["C=site:Q"]),
        (("--scene", "saw-40rpm", "--point"), "C=body:l", ["C=body:leg"]),
    ],
)
def test_names_of_the_model_on_the_line_are_completed(
    model: Path, words: tuple[str, ...], begun: str, found: list[str]
) -> None:
    assert completions("check", "saw.xml", *words, begun=begun) == found
    # Control: without the model its names are not known; a file that an option writes is no model that is read.
    names = [one for one in completions("check", "--json", "saw.xml", *words, begun=begun) if one in found]
    assert names == [one for one in found if one in ("qpos0", "C=", "M=", "C=site:", "C=body:", "C=geom:")]


@pytest.mark.parametrize(
    "text",
    [
        b"<mujoco><worldbody><body><joint name='crank'/>",
        b"\x00\xff",
        b"",
        b"<?xml version='1.0' encoding='no-such'?><mujoco/>",
        b"<include file='parts/leg.xml'/></mujoco>",
    ],
)
def test_a_broken_model_completes_nothing(model: Path, text: bytes) -> None:
    model.write_bytes(text)
    assert completions("check", "saw.xml", "--drive") == []
    assert completions("check", "missing.xml", "--drive") == []
    assert completions("check", "parts", "--scene", "no-such", "--point") == []


def test_a_joint_of_urdf_is_driven_by_its_type(model: Path) -> None:
    joints = '<joint name="a" type="revolute"/><joint name="b" type="fixed"/><joint name="c" type="prismatic"/>'
    model.with_suffix(".urdf").write_text(f'<robot><link name="base"/>{joints}</robot>')
    assert completions("check", "saw.urdf", "--drive") == ["a=", "c="]


def test_bash_is_given_what_stands_behind_its_word_breaks(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shell = LineCompletion(cli, {}, "conrod", COMPLETION)

    def replied(line: str) -> str:
        monkeypatch.setenv("COMP_LINE", line)
        return shell.complete()

    assert replied("conrod check saw.xml --drive cr") == "crank="
    assert replied("conrod check saw.xml --scene saw-40rpm --point C=si") == "site:"
    assert replied("conrod check saw.xml --scene saw-40rpm --point C=site:") == "Q"
    assert replied("conrod invari") == "invariances"
    assert "compopt -o nospace" in shell.source()


def test_files_are_completed_by_the_endings_of_a_verb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("saw.xml", "saw.toml", "saw.csv", "saw.png", ".saw.xml"):
        (tmp_path / name).touch()
    (tmp_path / "saws").mkdir()
    assert completions("check", begun="s") == ["saw.csv", "saw.xml", "saws/"]
    assert completions("lint", begun="s") == ["saw.xml", "saws/"]
    assert completions("validate", begun="saw.") == ["saw.toml"]
    assert completions("audit", begun=f"{tmp_path}/s") == [f"{tmp_path}/saw.csv", f"{tmp_path}/saws/"]
    assert completions("check", begun="missing/") == []
