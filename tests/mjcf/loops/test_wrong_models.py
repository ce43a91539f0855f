"""Models that are not the machine they are to be: each kind of mistake is named, none passes in silence."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from command_line import conrod
from four_bars import four_bar

from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.exact.space.motion import NO_FURTHER
from conrod.mjcf.causes import append_causes
from conrod.mjcf.differences import MachineComparison, list_differences
from conrod.mjcf.equalities import constraint_violations, inactive_closures, inactive_words
from conrod.mjcf.loop_results import LoopRequest, LoopRun, LoopStudy
from conrod.mjcf.reading import machine_tree, tree_of
from conrod.mjcf.start import open_start
from conrod.models.loops import study as study_module
from conrod.models.loops.report import finding
from conrod.models.loops.study import study_loops
from conrod.scenes.space import MACHINES

CASES = Path(__file__).parents[2] / "data" / "cases"
SAW = ("--scene", "saw-40rpm", "--crank", "crank", "--point", "C=site:C", "--point", "M=site:M")


def check_file(*arguments: object) -> tuple[int, str]:
    """Exit status of the command and all that it prints."""
    done = conrod("check", *map(str, arguments))
    return done.returncode, done.stdout + done.stderr


@pytest.fixture
def few_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Studies of closed loops make no more runs than their verdict needs."""
    for name, cheap in {"COARSER": (2,), "FINER": (), "CHECKED_INSTANTS": 25}.items():
        monkeypatch.setattr(study_module, name, cheap)
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)


def study_of(path: Path, machine: str, **question: object) -> LoopStudy:
    drives = dict(MACHINES[machine]().drives)
    return study_loops(path, replace(LoopRequest(drives, machine=machine), **question), path.stem)  # type: ignore[arg-type]


# -- another machine in space ------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("few_runs")
def test_a_rod_a_tenth_of_a_millimetre_long_is_another_machine() -> None:
    found = study_of(CASES / "rssr-rod.xml", "rssr")
    assert not found.is_machine
    assert not found.passed
    words = "It is not rssr as it stands: rod is 0.01 % longer to rocker_pin: 420.042 mm instead of 420 mm"
    assert words in finding(found)
    # Who allows for it has the machine: what is off is still said.
    allowed = replace(found, question=replace(found.question, tolerance={"position": 1e-3}))
    assert allowed.is_machine
    assert "though rod is 0.01 % longer to rocker_pin" in finding(allowed)
    # Every part of the verdict counts alone; the rest of it is healthy here.
    healthy = replace(
        found, compared=None, kinematic={"position": 0.0}, shipped=replace(found.shipped, outcome=Outcome.COMPLETED)
    )
    assert healthy.passed
    for off in (1.0, None):
        assert not replace(healthy, compared=MachineComparison("rssr", off, "rod_end", ())).passed
    assert replace(healthy, compared=MachineComparison("rssr", 0.0, "rod_end", ())).passed
    assert not replace(healthy, kinematic={"position": 1e-3}).passed
    assert not replace(healthy, shipped=replace(found.shipped, outcome=Outcome.DIVERGED)).passed
    diverged = LoopRun("as it is", 1e-3, Outcome.DIVERGED)
    assert not replace(healthy, runs=(diverged,)).passed


@pytest.mark.slow
def test_a_rod_that_is_too_long_has_exit_status_1() -> None:
    status, told = check_file(CASES / "rssr-rod.xml", "--scene", "rssr")
    assert (status, "rod is 0.01 % longer to rocker_pin" in told) == (1, True)


Edit = Callable[[ET.Element], None]


def element(root: ET.Element, tag: str, name: str) -> ET.Element:
    return next(one for one in root.iter(tag) if one.get("name") == name)


def setting(tag: str, name: str, /, **fields: str) -> Edit:
    def edit(root: ET.Element) -> None:
        element(root, tag, name).attrib.update(fields)

    return edit


def retagged(tag: str, name: str, other: str, /, **fields: str) -> Edit:
    """Another element in the place of one, such as a weld of a connect."""

    def edit(root: ET.Element) -> None:
        one = element(root, tag, name)
        one.tag, one.attrib = other, {**({} if fields else one.attrib), "name": name, **fields}

    return edit


def adding(parent: str, text: str) -> Edit:
    def edit(root: ET.Element) -> None:
        next(root.iter(parent)).append(ET.fromstring(text))

    return edit


def edited(machine: str, *edits: Edit) -> str:
    root = ET.fromstring(MACHINES[machine]().mjcf)
    for edit in edits:
        edit(root)
    return ET.tostring(root, encoding="unicode")


ROD = "0.21886430830622252 -0.04035182306687574 -0.20117192876944414"  # place of its end on it
FAN = '<body name="fan" pos="1 1 1"><joint name="idle"/><geom type="sphere" size="0.01"/></body>'
OTHERWISE: dict[str, tuple[str, tuple[Edit, ...], tuple[str, ...]]] = {
    "a slide for a hinge": (
        "rssr",
        (setting("joint", "output", type="slide"),),
        ("joint output is a slide, the machine has a hinge",),
    ),
    "a ball for a hinge": (
        "tilted-slider-crank",
        (setting("joint", "rod", type="ball"),),
        ("joint rod is a ball, the machine has a hinge",),
    ),
    "a weld for a connect": (
        "rssr",
        (retagged("connect", "rocker_pin", "weld"),),
        ("closure rocker_pin is a weld, the machine has a connect",),
    ),
    "a coupling for a connect": (
        "rssr",
        (adding("worldbody", FAN), retagged("connect", "rocker_pin", "joint", joint1="idle")),
        (
            "fan is a body more",
            "fan has a joint more, idle",
            "closure rocker_pin is a joint coupling, the machine has a connect",
        ),
    ),
    "a joint that is missing": (
        "rssr",
        (lambda root: element(root, "body", "rod").remove(element(root, "joint", "rod_pitch")),),
        ("joint rod_pitch of rod is missing",),
    ),
    "a joint with another name": (
        "rssr",
        (setting("joint", "rod_pitch", name="pitch"),),
        ("joint rod_pitch of rod is missing", "rod has a joint more, pitch"),
    ),
    "a closure at another body": (
        "rssr",
        (adding("body", '<site name="here"/>'), setting("connect", "rocker_pin", site2="here")),
        ("rocker_pin ties rod to crank, in the machine rod to rocker",),
    ),
    "a weld that is turned": (
        "tilted-slider-crank",
        (setting("weld", "rod_weld", relpose=f"{ROD} 1 0.0005 0 0"),),
        ("rod_weld holds its bodies turned by 0.0573 deg from where the machine has them",),
    ),
    "a slider that is turned": (
        "tilted-slider-crank",
        (setting("body", "slider", euler="0 0 0.01"),),
        ("slider is turned by 0.573 deg on world",),
    ),
    "a crank with another zero": (
        "rssr",
        (setting("body", "crank", euler="0 0 0.1"),),
        (),  # a matter of the drive, which says it
    ),
    "an inactive closure": (
        "rssr",
        (setting("connect", "rocker_pin", active="false"),),
        ("closure rocker_pin is inactive",),
    ),
    "all equalities off": (
        "rssr",
        (lambda root: root.find("option").append(ET.fromstring('<flag equality="disable"/>')),),  # type: ignore[union-attr]
        ("closure rocker_pin is inactive",),
    ),
}


@pytest.mark.parametrize("mistake", OTHERWISE)
def test_what_a_model_has_otherwise_is_named(mistake: str) -> None:
    machine, edits, words = OTHERWISE[mistake]
    model = mujoco.MjModel.from_xml_string(edited(machine, *edits))
    found = list(list_differences(tree_of(model, model.qpos0), machine_tree(machine), inactive_closures(model)))
    assert set(words) <= set(found)
    assert not list(list_differences(tree_of(model, model.qpos0), tree_of(model, model.qpos0)))


@pytest.mark.usefixtures("few_runs")
@pytest.mark.parametrize("mistake", OTHERWISE)
def test_no_mistake_in_a_machine_in_space_passes_in_silence(mistake: str, tmp_path: Path) -> None:
    machine, edits, words = OTHERWISE[mistake]
    path = tmp_path / "model.xml"
    path.write_text(edited(machine, *edits), encoding="utf-8")
    try:
        told = finding(study_of(path, machine, seconds=0.2))
    except InvalidInput as refused:
        told = str(refused)
    assert all(one in told for one in words or ["input is at zero 5.73 deg from where the machine has it"])


@pytest.mark.usefixtures("few_runs")
def test_closure_of_another_kind_gives_verdict_and_no_traceback() -> None:
    found = study_of(CASES / "rssr-other-joint.xml", "rssr", seconds=0.2)
    assert "closure rocker_pin is a joint coupling, the machine has a connect" in finding(found)
    # It moves as the machine does, and has other joints: it is another one.
    assert found.compared is not None
    assert found.compared.off < 1e-12  # type: ignore[operator]
    assert not found.is_machine
    assert "It is not rssr as it stands" in finding(found)
    assert replace(found, compared=replace(found.compared, other_kinds=False)).is_machine


def test_study_names_inactive_closure_when_another_acts_for_it() -> None:
    again = '<connect name="again" site1="rod_end" site2="rocker_pin" />'
    text = edited("rssr", setting("connect", "rocker_pin", active="false"), adding("equality", again))
    question = LoopRequest(dict(MACHINES["rssr"]().drives), machine="rssr", seconds=0.1)
    bench = study_module._LoopBench.from_request(mujoco.MjModel.from_xml_string(text), question, explained=True)
    motion = bench.machine.motion(np.linspace(0.0, 0.1, 5))
    compared = bench._compare_with_machine(machine_tree("rssr"), motion, 0.1)
    assert compared is not None
    assert compared.differences == ("again is a loop more", "closure rocker_pin is inactive")
    assert compared.off is not None
    assert compared.off < 1e-9


# -- closures that do not act ------------------------------------------------------------------------------------------


def off_by_flag(flag: str) -> Callable[[str], str]:
    return lambda text: text.replace('contact="disable"', f'contact="disable" {flag}="disable"')


SAW_XML = (CASES / "saw-closure-inactive.xml").read_text(encoding="utf-8")
ACTIVE = SAW_XML.replace(' active="false"', "")


@pytest.mark.parametrize(("text", "cause"), [
    (SAW_XML, 'active="false"'),
    (off_by_flag("equality")(ACTIVE), '<flag equality="disable"/>'),
    (off_by_flag("constraint")(ACTIVE), '<flag constraint="disable"/>'),
], ids=["inactive", "equality", "constraint"])  # fmt: skip
def test_a_closure_that_does_not_act_is_named(text: str, cause: str, tmp_path: Path) -> None:
    path = tmp_path / "saw.xml"
    path.write_text(text, encoding="utf-8")
    for asked in (SAW, ("--drive", "crank=40rpm")):
        status, told = check_file(path, *asked)
        assert status == 2
        assert f"closure slider-pin is inactive ({cause})" in told
    # Negative control: nothing of it where the closure acts.
    model = mujoco.MjModel.from_xml_string(ACTIVE)
    assert inactive_words(model) == ""
    assert [closure.name for closure in tree_of(model, model.qpos0).closures] == ["slider-pin"]
    assert not tree_of(model := mujoco.MjModel.from_xml_string(text), model.qpos0).closures


# -- loops that are open at the start ----------------------------------------------------------------------------------

MEANT = ("--scene", CASES / "anchor-apart-meant.toml", "--crank", "crank", "--point", "P=site:P")


@pytest.mark.usefixtures("at_once", "few_runs")
@pytest.mark.parametrize("asked", [("--drive", "crank=60rpm"), MEANT], ids=["drive", "scene"])
def test_verdict_starts_with_open_start_and_nearest_closed_pose(asked: tuple[object, ...], tmp_path: Path) -> None:
    status, told = check_file(CASES / "four-bar-open.xml", *asked)
    assert status == 1
    begins = re.search(
        r"It begins 38.3 mm open: pin2, in its own pose; the nearest closed pose is qpos=\"(.*?)\"", told
    )
    assert begins
    data = mujoco.MjData(model := mujoco.MjModel.from_xml_path(str(CASES / "four-bar-open.xml")))
    data.qpos[:] = [float(value) for value in begins[1].split()]
    mujoco.mj_forward(model, data)
    assert np.linalg.norm(data.site("P").xpos - data.site("R").xpos) < 1e-9
    # Negative control: from there it does not begin open.
    path, key = tmp_path / "closed.xml", f'<keyframe><key qpos="{begins[1]}"/></keyframe></mujoco>'
    path.write_text((CASES / "four-bar-open.xml").read_text().replace("</mujoco>", key))
    status, told = check_file(path, *asked)
    assert "It begins" not in told
    assert status == int("its crank stands still" in told)  # which a scene has turn


@pytest.mark.parametrize(
    "machine", ["rssr", "spherical-four-bar", "sarrus", "bennett", "stewart", "tilted-slider-crank"]
)
@pytest.mark.parametrize("gap", [1e-3, 1e-2, 4e-2])
def test_open_keyframe_is_measured_as_in_mujoco_on_every_machine(machine: str, gap: float) -> None:
    model = mujoco.MjModel.from_xml_string(MACHINES[machine]().mjcf)
    data, extent = mujoco.MjData(model), tree_of(model, model.qpos0).extent
    assert open_start(model, data, extent, "its own pose") is None  # negative control
    way = np.random.default_rng(1).normal(size=model.nv)
    # A pose that is open by the gap, by bisection along a random way.
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, way, middle)
        mujoco.mj_forward(model, data)
        opened = max(constraint_violations(model, data, extent))
        low, high = (middle, high) if opened < gap else (low, middle)
    found = open_start(model, data, extent, "its own pose")
    assert found is not None
    assert max(found.gaps.values()) == pytest.approx(gap, rel=1e-9)
    assert found.exceeds(None) == (gap > 1e-3 * extent)
    assert found.exceeds(0.99 * gap)
    assert not found.exceeds(1.01 * gap)
    data.qpos[:] = [float(value) for value in found.closed.split()]
    assert open_start(model, data, extent, "its own pose") is None


def test_a_start_that_no_pose_closes_is_said_so() -> None:
    text = re.sub(r'(fromto="0 0 0 |name="P" pos=")0.26 ', r"\g<1>0.9 ", (CASES / "four-bar-open.xml").read_text())
    data = mujoco.MjData(model := mujoco.MjModel.from_xml_string(text))
    found = open_start(model, data, 0.3, "its own pose")
    assert found is not None
    assert found.closed == ""
    assert "no pose near it closes them" in found.words()


# -- a start outside the joints' ranges --------------------------------------------------------------------------------

FOLDED = (CASES / "folded-leg.xml").read_text(encoding="utf-8")
LENGTH = {"length": "move:0.3m,0.6m,1s"}


def leg(text: str = FOLDED, **question: object) -> study_module._LoopBench:
    model = mujoco.MjModel.from_xml_string(text)
    return study_module._LoopBench.from_request(model, replace(LoopRequest(LENGTH), **question))  # type: ignore[arg-type]


def knee_of(bench: study_module._LoopBench) -> tuple[float, float]:
    """Length and knee at the start of the motion [m, rad]."""
    at = {joint.name: joint.coordinate for joint in bench.machine.tree.joints}
    start = bench.machine.knots[0].coordinates[:, 0]
    return float(start[at["length"]]), float(start[at["knee"]])


def test_folded_leg_starts_from_nearest_pose_inside_its_ranges() -> None:
    bench = leg()
    assert bench.moved_start.startswith(
        "its own pose has length at 0 m, outside its range 0.12 to 0.68 m, femur at 0 deg, outside its range 10 to 75 "
        "deg, knee at 0 deg, outside its range -160 to -10 deg, and is folded: the motion starts from the nearest"
    )
    # Thigh and shin of 0.36 m with 0.3 m between their ends, the knee as its range has it: an isosceles triangle.
    length, knee = knee_of(bench)
    assert length == pytest.approx(0.3, abs=1e-12)
    assert knee == pytest.approx(-2.0 * np.arcsin(0.15 / 0.36), abs=1e-9)
    # The pose that is printed closes the loop in MuJoCo.
    data = mujoco.MjData(bench.model)
    data.qpos[:] = [float(value) for value in re.search(r'qpos="(.*?)"', bench.moved_start)[1].split()]  # type: ignore[index]
    assert open_start(bench.model, data, 1.0, "") is None


def test_a_leg_that_starts_inside_its_ranges_starts_there() -> None:
    key = "<keyframe><key name='half' qpos='0 0.3 0 1.1410 -0.8596'/><key name='flat'/></keyframe></mujoco>"
    text = FOLDED.replace("</mujoco>", key)
    bench = leg(text, keyframe="half")
    assert bench.moved_start == ""
    assert knee_of(bench) == pytest.approx(knee_of(leg()), abs=1e-9)
    assert leg(text, keyframe="flat").moved_start.startswith("keyframe flat has length at 0 m, outside its range")
    # Negative control: without ranges nothing is outside, and the folded leg goes nowhere.
    with pytest.raises(InvalidInput, match="it goes no further than") as refused:
        leg(re.sub(r' range="[^"]*"', "", FOLDED))
    assert "outside" not in str(refused.value)


@pytest.mark.parametrize("explained", [True, False])
def test_pose_inside_is_refused_without_guess_when_explained(explained: bool) -> None:
    # The rocker's range is that of the other branch; on both a coupling holds the crank, beside its drive.
    text = four_bar().replace('name="rocker" axis', 'name="rocker" range="-3 -0.1" axis')
    text = text.replace("</equality>", '<joint name="spare" joint1="crank"/></equality>')
    with pytest.raises(InvalidInput, match="the nearest pose inside, its closures take 3 of 3") as refused:
        study_module._LoopBench.from_request(
            mujoco.MjModel.from_xml_string(text), LoopRequest({"crank": "60rpm"}), explained=explained
        )
    assert str(refused.value).count("without spare it moves") == (0 if explained else 2)


def test_ranges_that_no_closed_pose_keeps_are_named() -> None:
    with pytest.raises(InvalidInput, match=r"knee at 0 deg, outside .*, and no pose inside closes its loops"):
        leg(FOLDED.replace('range="-160 -10"', 'range="-15 -10"'))
    with pytest.raises(
        InvalidInput, match=r"range is 0.12 to 0.68 m, which the pose that it starts from, at 0, is out"
    ):
        leg(drives={"length": "sine:50mm,1Hz"})


# -- parts that do not meet --------------------------------------------------------------------------------------------

TO_THE_MEANT = ("--scene", CASES / "anchor-apart-meant.toml", "--crank", "crank", "--point", "P=site:coupler_end")


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(("asked", "expected"), [(("--drive", "crank=60rpm"), 2), (TO_THE_MEANT, 1)])
def test_a_pin_whose_parts_do_not_meet_is_why_it_goes_no_further(asked: tuple[object, ...], expected: int) -> None:
    status, told = check_file(CASES / "anchor-apart.xml", *asked)
    assert status == expected  # of a scene it is another machine
    assert "it goes no further than with crank at 250.28 deg" in told
    assert "pin holds rocker at a point 331 mm from its nearest geom: the parts do not meet, connect sites" in told
    assert "dead centre" not in told


@pytest.mark.usefixtures("few_runs")
def test_pin_is_named_when_its_parts_lie_apart_and_machine_moves() -> None:
    found = study_loops(CASES / "anchor-apart.xml", LoopRequest({"crank": "move:0,20deg,1s"}), "apart")
    assert "Pin holds rocker at a point 331 mm from its nearest geom" in finding(found)


def test_cause_replaces_the_guess_when_there_is_one() -> None:
    error = f"it goes no further than here: {NO_FURTHER}"
    assert append_causes(error) == append_causes(error, "") == error
    assert append_causes(error, "a is so", "b is so") == "it goes no further than here: a is so; b is so"
    assert append_causes("it cannot move", "a is so") == "it cannot move; a is so"
    assert append_causes("it cannot move, as a is so", "a is so") == "it cannot move, as a is so"


@pytest.mark.parametrize(("drive", "law"), [("femur", "move:20deg,60deg,1s"), ("knee", "move:-30deg,-100deg,1s")])
def test_folded_leg_unfolds_into_its_ranges_when_it_could_stay(drive: str, law: str) -> None:
    bench = leg(drives={drive: law})
    assert "the motion starts from the nearest closed pose inside" in bench.moved_start
    length, knee = knee_of(bench)
    assert 0.12 <= length <= 0.68
    assert np.radians(-160.0) <= knee <= np.radians(-10.0)
