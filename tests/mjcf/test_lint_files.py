"""`conrod lint` with users' files: includes and assets, `--fix`, and what a user may get wrong."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import pytest
from command_line import conrod
from own_model_edits import HACKSAW, scaled
from planted_models import (
    SAW,
    closed_twice,
    colliding_links,
    renamed,
    replaced,
    without_start_speeds,
)

from conrod.errors import InvalidInput
from conrod.mjcf.lint.document import Document, differing
from conrod.mjcf.lint.findings import Exclude, Finding, Harm, Report, Request
from conrod.mjcf.lint.linting import RULES, described, lint, prepared
from conrod.own.files import as_outputs_must_not_be, files_of_model
from conrod.own.models.request import Place
from conrod.studies.frame.files import files_to_write
from conrod.studies.frame.paired_timing import BLOCK_TIME, MOST_STEPS, paired_cost

SHORT = Request(seconds=0.03)
CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)) + "".join(
    f"f {face}\n" for face in ("1 2 4", "1 4 3", "5 7 8", "5 8 6", "1 5 6", "1 6 2", "3 4 8", "3 8 7", "1 3 7", "1 7 5")
) + "f 2 6 8\nf 2 8 4\n"  # fmt: skip

# A gripper on a floating palm above a floor: two fingers, each a parallelogram closed by a connect and coupled by a
# joint equality and a tendon; a mesh, an include, a frame, a replicate, defaults, and next to no names.
GRIPPER = """
<mujoco>
  <compiler meshdir="shapes" autolimits="true"/>
  <option timestep="0.001" integrator="implicitfast"><flag autoreset="disable"/></option>
  <include file="parts/defaults.xml"/>
  <worldbody>
    <geom type="plane" size="1 1 0.1" class="floor"/>
    <replicate count="3" offset="0.1 0 0"><geom type="sphere" size="0.01" pos="0.5 0 0.01" class="seen"/></replicate>
    <body pos="0 0 0.3">
      <freejoint/>
      <geom type="mesh" mesh="cube" density="500"/>
      <frame pos="0 0.05 0" childclass="finger">
        <body><joint name="left"/><geom/><body pos="0 0 0.1"><joint axis="1 0 0"/><geom/><site name="l1" pos="0 0 0.1"/>
        </body></body>
        <body name="lo" pos="0 0.02 0"><joint/><geom/><site name="l2" pos="0 -0.02 0.2"/></body>
      </frame>
      <body pos="0 -0.05 0" childclass="finger"><joint name="right"/><geom/></body>
    </body>
  </worldbody>
  <equality>
    <connect site1="l1" site2="l2" solref="0.002 1" solimp="0.9999 0.9999 0.001 0.5 2"/>
    <joint joint1="left" joint2="right" polycoef="0 -1 0 0 0"/>
  </equality>
  <tendon><fixed name="both"><joint joint="left" coef="0.5"/><joint joint="right" coef="-0.5"/></fixed></tendon>
  <actuator><position tendon="both" kp="1"/></actuator>
  <sensor><tendonpos tendon="both"/></sensor>
</mujoco>
"""
DEFAULTS = """
<mujocoinclude>
  <default>
    <joint type="hinge" axis="1 0 0" damping="0.01"/>
    <default class="finger"><geom type="capsule" fromto="0 0 0 0 0 0.08" size="0.008"/></default>
    <mesh scale="1 1 1"/>
    <default class="floor"><geom contype="1" conaffinity="1"/></default>
    <default class="seen"><geom contype="0" conaffinity="0"/></default>
  </default>
  <asset><mesh name="cube" file="cube.obj"/></asset>
</mujocoinclude>
"""


def at(folder: Path, text: str, request: Request = SHORT, name: str = "model.xml") -> Report:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return lint(path, request)


@pytest.fixture
def gripper(tmp_path: Path) -> Path:
    folder = tmp_path / "robot"
    for part in ("parts", "shapes"):
        (folder / part).mkdir(parents=True)
    (folder / "parts" / "defaults.xml").write_text(DEFAULTS)
    (folder / "shapes" / "cube.obj").write_text(CUBE)
    (folder / "gripper.xml").write_text(GRIPPER)
    return folder / "gripper.xml"


# -- files -----------------------------------------------------------------------------------------------------------


def test_a_gripper_of_many_files_is_linted_and_its_elements_are_found_in_them(gripper: Path) -> None:
    report = lint(gripper, Request(seconds=0.3))
    # Fingers that pass through each other's parallelogram are nobody's pin.
    assert not {f.rule for f in report.findings} & {"never-touch", "step-too-long", "freedom-taken-away"}
    assert report.notes == ()
    document = Document(gripper)
    model = document.model
    assert all(document.can_edit("body", body) for body in range(1, model.nbody))
    assert all(document.can_edit("geom", geom) for geom in range(model.ngeom))
    parts = ("gripper.xml", "parts/defaults.xml", "shapes/cube.obj")
    assert set(files_of_model(gripper)) == {gripper.parent / name for name in parts}
    # Bodies without a name get one where they are excluded.
    unnamed = [body for body in range(1, model.nbody) if not model.body(body).name]
    edit = Exclude((unnamed[0], unnamed[-1]), ("one", "other"))
    assert document.compiled((edit,)).exclude_signature.tolist() == [(unnamed[0] << 16) + unnamed[-1]]


@pytest.mark.parametrize("place", ["robot", ".", "elsewhere/deep"])
def test_a_fixed_model_finds_its_assets_from_wherever_it_is(place: str, gripper: Path, tmp_path: Path) -> None:
    gripper.write_text(replaced('<flag autoreset="disable"/>', "")(GRIPPER))
    folder = tmp_path / place
    folder.mkdir(parents=True, exist_ok=True)
    before = {path: path.read_bytes() for path in gripper.parent.rglob("*.*")}
    report = lint(gripper, Request(seconds=0.02, fix_folder=str(folder)))
    assert [edit.words for edit in report.fixed.edits] == ['<option><flag autoreset="disable"/></option>']
    assert report.fixed.change == 0.0
    (folder / "fixed.xml").write_text(report.fixed.text)
    fixed, model = (mujoco.MjModel.from_xml_path(str(path)) for path in (folder / "fixed.xml", gripper))
    assert differing(fixed, model) == "option"
    model.opt.disableflags = fixed.opt.disableflags
    assert differing(fixed, model) == ""
    assert {path: path.read_bytes() for path in before} == before


def test_a_fix_removes_all_that_is_safe_and_tells_the_change(tmp_path: Path) -> None:
    text = closed_twice(replaced('tolerance="0" ', "")(replaced('autoreset="disable" ', "")(SAW)))
    text = renamed(replaced('gravity="0 -9.81 0"', 'gravity="0 -9 -3"')(text))
    request = Request(seconds=0.03, fix_folder=str(tmp_path))
    report = at(tmp_path, text, request)
    safe = {finding.rule for finding in report.findings if finding.safe}
    assert safe == {"redundant-closure", "solver-stops-early", "silent-reset"}
    assert 0.0 < report.fixed.change < 1e-4
    again = at(tmp_path, report.fixed.text, request, "fixed.xml")
    # Gravity is the machine's: without that part of it its loads would be another machine's, so it stays as it is.
    assert [finding.rule for finding in again.findings] == ["gravity-across"]
    assert 'gravity="0 -9 -3"' in report.fixed.text
    assert again.fixed.text == ""


def test_what_somebody_must_decide_is_not_fixed(tmp_path: Path) -> None:
    text = without_start_speeds(colliding_links(SAW))
    report = at(tmp_path, text, Request(seconds=0.003, fix_folder=str(tmp_path)))
    assert {finding.rule for finding in report.findings} == {"joined-links-collide", "torn-start"}
    assert report.fixed.text == ""


@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_start_speeds_that_fit_leave_a_heavy_crank_its_own_in_every_unit(unit: float, tmp_path: Path) -> None:
    text = without_start_speeds(SAW) if unit == 1.0 else without_start_speeds(scaled(SAW, unit))
    report = at(tmp_path, text, Request(seconds=0.005))
    (finding,) = (finding for finding in report.findings if finding.rule == "torn-start")
    slide, crank, rod = (float(value) for value in finding.fix.split('"')[1].split())
    # Those of the keyframe that conrod writes.
    assert (slide / unit, crank, rod) == pytest.approx((-1.6466419709575786, 52.35987755982988, -34.06385566030124))


def test_comments_and_all_digits_survive_a_fix(tmp_path: Path) -> None:
    report = at(tmp_path, replaced('autoreset="disable" ', "")(SAW), Request(seconds=0.01, fix_folder=str(tmp_path)))
    for words in ("LOAD THE KEYFRAME", "2.836899999574396", 'autoreset="disable"'):
        assert words in report.fixed.text


def test_another_model_is_told_by_one_digit() -> None:
    one = mujoco.MjModel.from_xml_string(SAW)
    assert differing(one, mujoco.MjModel.from_xml_string(SAW)) == ""
    assert differing(one, mujoco.MjModel.from_xml_string(SAW.replace('mass="1.5"', 'mass="1.5000000001"'))) != ""
    assert differing(one, mujoco.MjModel.from_xml_string(SAW.replace('tolerance="0"', 'tolerance="1e-9"'))) == "option"


# -- with a scene ----------------------------------------------------------------------------------------------------


def test_a_scene_drives_the_crank_and_named_points_are_observed(tmp_path: Path) -> None:
    # Neither a flywheel nor speeds: on its own the machine would stand, or fall.
    text = replaced('armature="1e+13" ', "")(SAW)
    text = replaced('qvel="-1.6466419709575786 52.35987755982988 -34.06385566030124"', 'qvel="0 0 0"')(text)
    report = at(tmp_path, text, Request(seconds=0.03, speed=52.35987755982988, points=(Place("C", "site", "C"),)))
    assert "driven run" in report.run
    assert report.findings == ()


def test_a_driven_model_must_have_one_crank_on_the_frame(tmp_path: Path) -> None:
    text = SAW.replace('type="slide" axis="1 0 0"', 'type="hinge" axis="0 0 1"')
    with pytest.raises(InvalidInput, match="2 hinges are on the frame: name the crank with --crank"):
        at(tmp_path, text, Request(speed=1.0, seconds=0.01))
    with pytest.raises(InvalidInput, match="--crank slide: it is a slide joint, a crank is a hinge; its hinges: cr"):
        at(tmp_path, SAW, Request(speed=1.0, crank="slide", seconds=0.01))


def test_a_brake_on_the_crank_does_not_stop_a_driven_run(tmp_path: Path) -> None:
    # Without it the flywheel is the least one: the speed is kept to a per cent at once.
    brakes = ("", '<actuator><velocity joint="crank" kv="50" /></actuator>')
    text = replaced(' armature="1e+13"', "")(SAW)
    request = Request(seconds=0.03, speed=52.35987755982988, crank="crank")
    heavy = []
    for brake in brakes:
        path = tmp_path / "model.xml"
        path.write_text(text.replace("<sensor>", f"{brake}<sensor>"))
        bench = prepared(Document(path), request)
        speeds = bench.run.states[:, bench.model.nq + 1] / 52.35987755982988
        assert abs(speeds - 1.0).max() <= 0.01
        # The solver stops where it would without the drive.
        own = bench.document.model
        assert bench.model.opt.tolerance * bench.model.stat.meaninertia == pytest.approx(
            own.opt.tolerance * own.stat.meaninertia
        )
        heavy.append(bench.model.dof_armature[1])
    assert heavy[1] > 2.0 * heavy[0]


def test_a_soft_closure_is_found_where_the_step_alone_opens_a_stiff_one(tmp_path: Path) -> None:
    request = Request(seconds=0.12, speed=52.35987755982988, crank="motor", ignored=("silent-reset",))
    (finding,) = lint(HACKSAW, request).findings
    evidence = dict(finding.evidence)
    assert finding.rule == "soft-closure"
    assert evidence["with a step of [s]"] < mujoco.MjModel.from_xml_path(str(HACKSAW)).opt.timestep
    assert evidence["opening when stiff [m]"] <= 0.1 * evidence["opening [m]"]
    # Negative control: what opens by the step and not by its softness is none.
    text = replaced('site2="crankpin"/>', 'site2="crankpin" solref="0.004 1" solimp="0.9999 0.9999 0.001 0.5 2"/>')
    assert at(tmp_path, text(HACKSAW.read_text()), request).findings == ()


# -- what a user gets wrong ------------------------------------------------------------------------------------------

BROKEN = {
    "no XML": ("nothing", "MuJoCo cannot load it"),
    "a missing include": (replaced("<asset>", '<include file="parts.xml"/><asset>')(SAW), "parts.xml"),
    "a missing mesh": (replaced("<asset>", '<asset><mesh name="m" file="m.stl"/>')(SAW), "m.stl"),
    "nothing that moves": ("<mujoco/>", "nothing in the model can move"),
    "a robot description": (
        "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' "
        "ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='j' type='continuous'><parent link='a'/>"
        "<child link='b'/><axis xyz='0 0 1'/></joint></robot>",
        "is no MJCF",
    ),
}


NAMES = {
    "a keyframe": (Request(keyframe="begin"), "unknown keyframe 'begin': choose from qpos0, start"),
    "a site": (Request(points=(Place("C", "site", "CC"),)), "unknown site 'CC'"),
    "a body": (Request(points=(Place("C", "body", "slidr"),)), "did you mean 'slider'"),
    "a joint": (Request(speed=1.0, crank="crnk"), "did you mean 'crank'"),
    "a rule": (Request(ignored=("soft",)), "did you mean 'soft-closure'"),
    "no number of steps": (Request(seconds=1e6), "at most 1000000"),
}


@pytest.mark.parametrize(
    ("text", "request_", "words"),
    [
        *(pytest.param(text, SHORT, words, id=name) for name, (text, words) in BROKEN.items()),
        *(pytest.param(SAW, request_, words, id=name) for name, (request_, words) in NAMES.items()),
    ],
)
def test_what_cannot_be_used_is_told_in_one_line(text: str, request_: Request, words: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as told:
        at(tmp_path, text, request_)
    assert words in str(told.value)
    assert len(str(told.value).splitlines()) == 1


def test_a_model_that_runs_at_no_step_is_a_finding(tmp_path: Path) -> None:
    text = replaced('<joint name="crank-pin" type="hinge" axis="0 0 1" />', '<joint name="crank-pin" damping="-1e9" />')
    report = at(tmp_path, text(SAW))
    assert report.findings[0].rule == "step-too-long"
    assert "at no step" in report.findings[0].what
    json.dumps(report.document(), allow_nan=False)


# -- the command -----------------------------------------------------------------------------------------------------


def test_the_command_tells_writes_and_ends_with_its_status(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "saw.xml").write_text(renamed(closed_twice(SAW)))
    arguments = ("--seconds", "0.01", "--scene", "saw-500rpm")
    outputs = ("--fail-on", "note", "--json", "found.json", "--fix", "fixed.xml")
    done = conrod("lint", "saw.xml", *arguments, *outputs, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    for words in (
        "redundant-closure",
        "evidence: ",
        "change of motion without it: ",
        "1 finding: 1 note\n",
        "fixed.xml: 1 edit;",
    ):
        assert words in done.stdout
    found = json.loads((tmp_path / "found.json").read_text())
    (finding,) = found["findings"]
    assert (finding["rule"], finding["evidence"]["redundant"]) == ("redundant-closure", 2)
    assert (finding["severity"], finding["harm"]) == ("note", "waste")
    assert found["fixed"]["change"] < 1e-6
    monkeypatch.setattr("conrod.studies.execution.isolation.confined", lambda task, *given: task(*given))
    done = conrod("lint", "fixed.xml", *arguments, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "no findings" in done.stdout


def finding(harm: Harm) -> Finding:
    return Finding(what="found", harm=harm, evidence={}, fix="none")


@pytest.mark.parametrize(("harms", "fails"), [
    ((), ()),
    ((Harm.WASTE, Harm.HIDES), ("note",)),
    ((Harm.LATENT, Harm.WASTE), ("note", "warning")),
    ((Harm.WRONG,), ("note", "warning", "error")),
])  # fmt: skip
def test_the_severity_that_fails_can_be_chosen(
    harms: tuple[Harm, ...], fails: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "saw.xml").write_text("<mujoco/>")
    monkeypatch.chdir(tmp_path)
    report = Report("saw.xml", "a free run", tuple(map(finding, harms)), ())
    monkeypatch.setattr("conrod.studies.execution.isolation.confined", lambda task, *given: report)
    for severity in ("note", "warning", "error"):
        assert conrod("lint", "saw.xml", "--fail-on", severity).returncode == int(severity in fails)
    assert conrod("lint", "saw.xml").returncode == int("warning" in fails)
    done = conrod("lint", "saw.xml", "--fail-on", "errors")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)


def test_a_run_with_controls_is_linted(tmp_path: Path) -> None:
    servo = '<actuator><velocity name="motor" kv="30" joint="crank"/></actuator></mujoco>'
    text = without_start_speeds(replaced("</mujoco>", servo)(replaced(' armature="1e+13"', "")(SAW)))
    (tmp_path / "model.xml").write_text(text)
    document, request = Document(tmp_path / "model.xml"), replace(SHORT, controls=(("motor", 52.36),))
    driven, free = (prepared(document, one) for one in (request, SHORT))
    run = "an actuated run of 250 steps of 0.00012 s from keyframe start with motor = 52.36"
    assert described(driven, request) == run
    assert described(free, SHORT).startswith("a free run")
    assert driven.run.travel > 10.0 * free.run.travel


@pytest.mark.parametrize("option", ["--json", "--fix"])
@pytest.mark.parametrize("part", ["parts/defaults.xml", "shapes/cube.obj"])
def test_what_a_model_is_made_of_is_not_written_over(option: str, part: str, gripper: Path) -> None:
    before = (gripper.parent / part).read_bytes()
    with pytest.raises(InvalidInput, match="which the model is made of"):
        files_to_write({option: str(gripper.parent / part)}, as_outputs_must_not_be(gripper))
    assert (gripper.parent / part).read_bytes() == before
    # Negative control: a file beside it may be written.
    assert files_to_write({option: str(gripper.parent / "parts" / "found.json")}, as_outputs_must_not_be(gripper))


def test_the_rules_are_those_of_their_page() -> None:
    text = (Path(__file__).parents[2] / "docs" / "lint.md").read_text()
    rows = re.findall(r"^\| `([\w-]+)` \| ([^|]*) \|", text, re.MULTILINE)
    assert [(name, finds[0].upper() + finds[1:]) for name, finds in rows] == [
        (rule.name, (rule.judge.__doc__ or "").removesuffix(".")) for rule in RULES
    ]


def test_mujocos_warnings_litter_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    at(tmp_path, replaced('timestep="0.00012"', 'timestep="0.05"')(SAW), Request(seconds=5.0))
    assert [path.name for path in tmp_path.iterdir()] == ["model.xml"]


# -- timing ----------------------------------------------------------------------------------------------------------


class Clock:
    """Moves when somebody works."""

    def __init__(self) -> None:
        self.now = 0

    def stepper(self, nanoseconds: int) -> Callable[[], Callable[[int], None]]:
        def make() -> Callable[[int], None]:
            def advance(steps: int) -> None:
                self.now += steps * nanoseconds

            return advance

        return make


@pytest.mark.parametrize(("ratio", "slower"), [(1, 1), (7, 1), (3, 10)])
def test_a_paired_cost_is_the_ratio_of_the_work_also_where_the_machine_slows_down(ratio: int, slower: int) -> None:
    clock, seen = Clock(), itertools.count()
    # From some block on everything takes longer.
    cost = paired_cost(
        clock.stepper(1000 * ratio), clock.stepper(1000), clock=lambda: clock.now * (1 if next(seen) < 40 else slower)
    )
    assert cost.ratio == pytest.approx(ratio)
    if slower == 1:
        assert (cost.low, cost.high, cost.seconds) == pytest.approx((ratio, ratio, 1e-6 * ratio))


def test_a_block_is_bounded() -> None:
    asked: list[int] = []
    paired_cost(lambda: asked.append, lambda: asked.append, rounds=1, clock=lambda: 0)
    assert max(asked) == MOST_STEPS
    clock = Clock()
    slow = clock.stepper(round(1e10 * BLOCK_TIME))
    paired_cost(slow, slow, rounds=1, clock=lambda: clock.now)
    assert clock.now < 1e12 * BLOCK_TIME
