"""`conrod check MODEL --drive JOINT=LAW`: what a user types, sees and gets, and what is said of models and options
that cannot be used.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event

import pytest
from command_line import conrod, refusal
from four_bars import GRASHOF, four_bar, key
from table_files import write_file

DRIVE = ("--drive", "crank=60rpm")
BAR = four_bar()
MOTOR = '<actuator><motor name="motor" joint="crank" ctrlrange="-1 1"/></actuator>'
SERVO = '<actuator><position name="servo" joint="crank" kp="50" kv="2"/></actuator>'
NO_LOOP = BAR.replace("<connect", "<!--").replace('site2="C" />', "-->")
# A cart under the rocker: two freedoms.
FIVE_BAR = BAR.replace(
    '<body name="rocker" pos="0.35 0 0"',
    '<body name="cart" pos="0.35 0 0"><joint name="cart" type="slide" axis="1 0 0"/><geom size="0.01"/>'
    '<body name="rocker"',
).replace('<site name="C" pos="0.3 0 0"/></body>', '<site name="C" pos="0.3 0 0"/></body></body>')


pytestmark = pytest.mark.usefixtures("at_once")


@pytest.fixture(autouse=True)
def timed_coarsely(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps are timed as coarsely as may be: all else takes less."""
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)


# -- what is refused ---------------------------------------------------------------------------------------------------

MODELS = {
    "no drive": (BAR, ("--drive", "crank=hold"),
                 "none of its joints is driven: give --drive JOINT=LAW for one of crank, coupler, rocker"),
    "no loop and a tolerance": (NO_LOOP, (*DRIVE, "--tolerance", "position=1mm"),
                                "--tolerance does not go with --drive of an actuator, or outside loops"),
    "a drive of nothing": (NO_LOOP, ("--drive", "cranc=60rpm"), "unknown joint or actuator 'cranc': did you mean"),
    "too many": (BAR, (*DRIVE, "--drive", "rocker=hold"),
                 "leaves 1; 1 of its 2 drives is too many: give 1 of crank, rocker"),
    "too few": (FIVE_BAR, DRIVE, "its closures take 2 of 4 degrees of freedom, which leaves 2, and 1 is driven"),
    "out of range": (four_bar(joint='range="0 2"'), DRIVE,
                     "--drive crank=60rpm: it goes from 1 to 7.283, the joint's range is 0 to 2 rad"),
    "open": (BAR.replace('name="C" pos="0.3 0 0"', 'name="C" pos="0.3 0 0.5"'), DRIVE,
             "its loops do not close with crank at 57.296 deg: pin stays open by"),
    "flex": (
        BAR.replace("</worldbody>", '<flexcomp name="f" type="grid" count="3 3 1" spacing=".1 .1 .1" radius=".01" '
                    'dim="2"/></worldbody>'),
        DRIVE, "it has 1 flex: only rigid bodies have an exact motion here",
    ),
    "ten million steps": (BAR.replace('timestep="0.001"', 'timestep="1e-7"'), DRIVE,
                          "1 s are 1e+07 of its time steps of 1e-07 s: from 2 to 1,000,000 can be run"),
    "a control out of range": (four_bar(more=MOTOR), (*DRIVE, "--ctrl", "motor=3"), "MuJoCo clamps it"),
    "another quantity": (BAR, (*DRIVE, "--tolerance", "pos=1mm"), "unknown quantity 'pos': did you mean 'position'?"),
    "a unit of another kind": (BAR, (*DRIVE, "--tolerance", "velocity=1mm"), "'mm' is not a unit of m/s"),
    "an option of scenes": (BAR, (*DRIVE, "--revolutions", "2"), "--revolutions does not go with --drive"),
    "a qualification by itself": (BAR, ("--qualify",), "--qualify does not go with a model without --scene, which"),
}  # fmt: skip


@pytest.mark.parametrize("what", MODELS)
def test_unusable_model_is_refused_in_one_line_writing_nothing(what: str, tmp_path: Path) -> None:
    text, options, words = MODELS[what]
    file, out, document = write_file(tmp_path, text, "bar.xml"), tmp_path / "report", tmp_path / "result.json"
    assert words in refusal("check", str(file), *options, "--out", str(out), "--json", str(document))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bar.xml"]
    assert file.read_text() == text


@pytest.mark.parametrize("options", [(), ("--scene",)])
def test_none_of_several_models_is_written_over(tmp_path: Path, options: tuple[str, ...]) -> None:
    file, other = write_file(tmp_path, BAR, "bar.xml"), tmp_path / "other.xml"
    other.write_text(BAR)
    for target in (file, other):
        words = f"--json {target}: it is the same file as the model"
        assert words in refusal("check", str(file), *options, str(other), *DRIVE, "--json", str(target))


# -- what is judged ----------------------------------------------------------------------------------------------------

FEW = ("--seconds", "0.05")


def test_a_model_is_judged_written_and_rendered_again(tmp_path: Path) -> None:
    file, out, document = write_file(tmp_path, BAR, "bar.xml"), tmp_path / "report", tmp_path / "result.json"
    options = (*DRIVE, *FEW, "--tolerance", "position=1mm", "--out", str(out), "--json", str(document))
    done = conrod("check", str(file), *options)
    assert done.returncode == 0, done.stderr
    assert "driven: `crank=60rpm`; 0.05 s" in done.stdout
    part = json.loads(document.read_text())["parts"]["bar"]
    assert part["summary"]["passed"]
    found = part["findings"]
    assert max(found["kinematic"].values()) < 1e-12
    assert [run["label"] for run in found["runs"]] == ["as it is", "tuned", "hardened"]
    assert (found["mobility"]["rank"], found["mobility"]["redundant"]) == (2, {"pin": 1})
    assert file.read_text() == BAR
    pages = {path: path.read_text() for path in out.rglob("*.md")}
    assert len(pages) == 2
    assert conrod("report", str(out)).returncode == 0
    assert {path: path.read_text() for path in pages} == pages


@pytest.mark.parametrize(
    ("text", "drive", "words"),
    [
        (NO_LOOP, "crank=sine:20deg,1Hz", "crank = sine:20deg,1Hz: the law needs up to"),
        (four_bar(more=SERVO), "servo=sine:5deg,1Hz", "servo = sine:5deg,1Hz: joint crank follows within"),
    ],
)
def test_drive_that_no_loop_answers_is_inspected(tmp_path: Path, text: str, drive: str, words: str) -> None:
    done = conrod("check", str(write_file(tmp_path, text, "bar.xml")), "--drive", drive)
    assert words in done.stdout, done.stderr
    assert "1 degree of freedom" in done.stdout or "3 degrees of freedom" in done.stdout
    assert done.returncode in (0, 1)


def test_a_driven_actuator_is_said_to_run_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its loops are looked at first, and then its actuators: one task to its user."""
    asked: list[str] = []

    @contextmanager
    def waiting(subject: object, timeout: float | None) -> Iterator[Event]:
        asked.append(str(subject))
        printed = Event()
        printed.set()
        yield printed

    for verb in ("conrod.models.check.verb", "conrod.models.inspection.verb"):
        monkeypatch.setattr(f"{verb}.waiting", waiting)
    model = write_file(tmp_path, four_bar(more=SERVO), "bar.xml")
    assert conrod("check", str(model), "--drive", "servo=sine:5deg,10Hz").returncode in (0, 1)
    assert asked == [str(model)]


@pytest.mark.slow
def test_a_tolerance_that_is_missed_has_exit_status_1(tmp_path: Path) -> None:
    done = conrod("check", str(write_file(tmp_path, BAR, "bar.xml")), *DRIVE, *FEW, "--tolerance", "position=1e-6mm")
    assert done.returncode == 1
    assert "OUT OF TOLERANCE (position" in done.stdout


@pytest.mark.slow
def test_a_keyframe_selects_the_branch(tmp_path: Path) -> None:
    keys = key("right", GRASHOF, 1.0, 1.0) + key("left", GRASHOF, 1.0, -1.0)
    file, ways = write_file(tmp_path, four_bar(keys=keys), "bar.xml"), {}
    for name in ("qpos0", "right", "left"):
        document = tmp_path / f"{name}.json"
        done = conrod("check", str(file), *DRIVE, *FEW, "--keyframe", name, "--point", "C", "--json", str(document))
        assert done.returncode == 0, done.stderr
        ways[name] = json.loads(document.read_text())["parts"]["bar"]["findings"]["travel"]
    assert ways["qpos0"] == pytest.approx(ways["right"], rel=1e-12)
    assert abs(ways["left"] / ways["right"] - 1.0) > 0.01
