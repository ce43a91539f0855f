"""`conrod lint` with users' files: includes and assets, `--fix`, SARIF, and what a user may get wrong."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import mujoco
import pytest
from command_line import conrod
from planted_models import SAW, colliding_links, renamed, replaced

from conrod.errors import InvalidInput
from conrod.mjcf.lint.bench import Document, differing
from conrod.mjcf.lint.findings import Finding, Report, Request, Severity, sarif
from conrod.mjcf.lint.linting import RULES, described, lint, prepared
from conrod.own.files import as_outputs_must_not_be, files_of_model
from conrod.studies.frame.files import files_to_write
from conrod.studies.frame.paired_timing import paired_cost

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


def test_a_gripper_of_many_files_is_linted_and_left_alone(gripper: Path) -> None:
    before = {path: path.read_bytes() for path in gripper.parent.rglob("*.*")}
    report = lint(gripper, Request(seconds=0.3))
    # Fingers that pass through each other's parallelogram are nobody's pin.
    assert {finding.rule for finding in report.findings} <= {"soft-closure", "open-start"}
    assert report.notes == ()
    parts = ("gripper.xml", "parts/defaults.xml", "shapes/cube.obj")
    assert set(files_of_model(gripper)) == {gripper.parent / name for name in parts}
    assert {path: path.read_bytes() for path in gripper.parent.rglob("*.*")} == before


def test_a_fixed_model_has_all_that_is_safe_and_the_rest_of_its_text(gripper: Path) -> None:
    text = replaced('<flag autoreset="disable"/>', "")(GRIPPER)
    gripper.write_text(text)
    report = lint(gripper, Request(seconds=0.02, fix_folder=str(gripper.parent)))
    (edit,) = report.fixed.edits
    assert edit == '<option><flag autoreset="disable"/></option>'
    assert report.fixed.change == 0.0
    assert [line for line in report.fixed.text.decode().splitlines() if line in text.splitlines()] == text.splitlines()
    (gripper.parent / "fixed.xml").write_bytes(report.fixed.text)
    fixed, model = (mujoco.MjModel.from_xml_path(str(gripper.parent / name)) for name in ("fixed.xml", "gripper.xml"))
    assert differing(fixed, model) == "option"
    model.opt.disableflags = fixed.opt.disableflags
    assert differing(fixed, model) == ""


def test_a_fix_goes_where_the_model_finds_what_it_needs(gripper: Path, tmp_path: Path) -> None:
    gripper.write_text(replaced('<flag autoreset="disable"/>', "")(GRIPPER))
    with pytest.raises(InvalidInput, match=r"write it into .*robot, beside the model"):
        lint(gripper, Request(seconds=0.02, fix_folder=str(tmp_path)))
    # Negative control: what needs no other file is whole anywhere.
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    report = at(tmp_path, replaced('autoreset="disable" ', "")(SAW), replace(SHORT, fix_folder=str(folder)))
    (folder / "fixed.xml").write_bytes(report.fixed.text)
    assert lint(folder / "fixed.xml", SHORT).findings == ()


def test_what_somebody_must_decide_is_not_fixed(tmp_path: Path) -> None:
    report = at(tmp_path, colliding_links(SAW), Request(seconds=0.003, fix_folder=str(tmp_path)))
    assert [(finding.rule, finding.safe) for finding in report.findings] == [("joined-links-collide", False)]
    assert report.fixed.text == b""


def test_another_model_is_told_by_one_digit() -> None:
    one = mujoco.MjModel.from_xml_string(SAW)
    assert differing(one, mujoco.MjModel.from_xml_string(SAW)) == ""
    assert differing(one, mujoco.MjModel.from_xml_string(SAW.replace('mass="1.5"', 'mass="1.5000000001"'))) != ""
    assert differing(one, mujoco.MjModel.from_xml_string(SAW.replace('tolerance="0"', 'tolerance="1e-9"'))) == "option"


# -- what a user gets wrong ------------------------------------------------------------------------------------------

BROKEN = {
    "no XML": ("nothing", "MuJoCo cannot load it"),
    "a missing include": (replaced("<asset>", '<include file="parts.xml"/><asset>')(SAW), "parts.xml"),
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


def test_the_command_tells_writes_and_ends_with_its_status(tmp_path: Path) -> None:
    (tmp_path / "saw.xml").write_text(renamed(replaced('autoreset="disable" ', "")(SAW)))
    outputs = ("--fail-on", "note", "--json", "found.json", "--fix", "fixed.xml")
    done = conrod("lint", "saw.xml", "--seconds", "0.01", *outputs, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    for words in ("silent-reset", "evidence: ", "1 finding: 1 note\n", "fixed.xml: 1 edit; the motion did not change"):
        assert words in done.stdout
    found = json.loads((tmp_path / "found.json").read_text())
    (finding,) = found["findings"]
    assert (finding["rule"], finding["severity"], found["fixed"]["change"]) == ("silent-reset", "note", 0.0)
    done = conrod("lint", "fixed.xml", "--seconds", "0.01", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "no findings" in done.stdout


def finding(severity: Severity, what: str = "found", subject: str = "", *edits: str) -> Finding:
    return Finding(rule=f"rule-{severity.value}", what=what, why="so", severity=severity, evidence={}, fix="none",
                   subjects=(subject,) if subject else (), edits=edits)  # fmt: skip


@pytest.mark.parametrize(("worst", "fails"), [
    ((), ()),
    ((Severity.NOTE,), ("note",)),
    ((Severity.ERROR, Severity.NOTE), ("note", "error")),
])  # fmt: skip
def test_the_severity_that_fails_can_be_chosen(
    worst: tuple[Severity, ...], fails: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "saw.xml").write_text("<mujoco/>")
    monkeypatch.chdir(tmp_path)
    report = Report("saw.xml", "a free run", tuple(map(finding, worst)), ())
    monkeypatch.setattr("conrod.studies.execution.isolation.confined", lambda task, *given: report)
    for severity in ("note", "error"):
        assert conrod("lint", "saw.xml", "--fail-on", severity).returncode == int(severity in fails)
    assert conrod("lint", "saw.xml").returncode == int("error" in fails)


def test_sarif_gives_each_finding_its_line_and_no_text_breaks_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name, hostile = "my saw, 100%: é.xml", 'planted "\r\n<name>'
    lines = ("<mujoco>", " <option/>", ' <!-- name="pin" -->', " <equality>", "  <connect", '    name="pin"/>')
    Path(name).write_text("\n".join((*lines, " </equality></mujoco>")), encoding="utf-8")
    found = (
        finding(Severity.ERROR, "opens", "pin"),
        finding(Severity.ERROR, hostile, "elsewhere"),
        finding(Severity.NOTE, "resets", "", '<option><flag autoreset="disable"/></option>'),
    )
    report = Report(name, "a free run", found, ())
    (run,) = json.loads(sarif(report))["runs"]
    places = [one["locations"][0]["physicalLocation"] for one in run["results"]]
    assert [one["level"] for one in run["results"]] == ["error", "error", "note"]
    assert [one["region"]["startLine"] for one in places] == [5, 1, 2]
    assert {unquote(one["artifactLocation"]["uri"]) for one in places} == {name}
    assert {one["ruleId"] for one in run["results"]} == {one["id"] for one in run["tool"]["driver"]["rules"]}
    assert run["results"][1]["message"]["text"].startswith(hostile)
    monkeypatch.setattr("conrod.studies.execution.isolation.confined", lambda task, *given: report)
    done = conrod("lint", name, "--format", "sarif", "--fail-on", "error")
    assert (done.returncode, done.stdout) == (1, sarif(report))


def test_a_run_with_controls_is_linted(tmp_path: Path) -> None:
    servo = '<actuator><velocity name="motor" kv="30" joint="crank"/></actuator></mujoco>'
    (tmp_path / "model.xml").write_text(replaced("</mujoco>", servo)(SAW))
    document, request = Document(tmp_path / "model.xml"), replace(SHORT, controls=(("motor", 52.36),))
    driven, free = (prepared(document, one) for one in (request, SHORT))
    assert described(driven) == "an actuated run of 250 steps of 0.00012 s from keyframe start with motor = 52.36"
    assert described(free).startswith("a free run")


@pytest.mark.parametrize("option", ["--json", "--fix"])
def test_what_a_model_is_made_of_is_not_written_over(option: str, gripper: Path) -> None:
    part = "shapes/cube.obj"
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
        (name, (rule.__doc__ or "").removesuffix(".")) for name, rule in RULES.items()
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
