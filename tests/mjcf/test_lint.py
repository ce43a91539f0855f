"""`conrod lint` finds what was planted, by what it does and by no name; users' files are only read."""

from __future__ import annotations

import json
import random
import re
import string
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import mujoco
import pytest
from command_line import conrod
from four_bars import four_bar
from own_model_edits import replace_once

from conrod.errors import InvalidInput
from conrod.mjcf.anchors import parts_apart
from conrod.mjcf.document import first_difference
from conrod.models.invariances.results import InvarianceOutcome
from conrod.models.invariances.study import study_invariances
from conrod.models.lint.findings import Finding, Report, Severity, sarif
from conrod.models.lint.linting import RULES, lint
from conrod.user_files.files import model_files

SHORT = 0.03  # [s], a quarter of a turn of the saw's crank
MJCF = Path(__file__).parents[2] / "mjcf"
CASES = Path(__file__).parents[1] / "data" / "cases"
SAW = (MJCF / "saw-500rpm.xml").read_text(encoding="utf-8")
REFERENCES = ("name", "site1", "site2", "objname", "mesh", "geom1", "geom2", "site", "refsite", "body1", "body2")
CLOSURE = 'solref="0.00096 1" solimp="0.9999 0.9999 0.001 0.5 2"'
INERT = 'contype="0" conaffinity="0" '


def renamed(text: str, seed: int = 0) -> str:
    """A model in which no name says what it is."""
    rng, names = random.Random(seed), sorted(set(re.findall(r' name="([^"]+)"', text)))
    letters = {name: "".join(rng.choices(string.ascii_lowercase, k=12)) for name in names}
    places = rf' ({"|".join(REFERENCES)})="([^"]+)"'
    return re.sub(places, lambda place: f' {place[1]}="{letters.get(place[2], place[2])}"', text)


RESETS = replace_once(SAW, 'autoreset="disable" ', "")
TOO_LONG = replace_once(SAW, 'timestep="0.00012"', 'timestep="0.05"')
AT_REST = re.sub(' qvel="[^"]*"', "", replace_once(SAW, 'gravity="0 -9.81 0"', 'gravity="0 0 -9.81"'))
TWICE = f'<connect site1="slider-pin.rod" site2="slider-pin.slider" {CLOSURE} />'
APART = replace_once((CASES / "anchor-apart.xml").read_text(encoding="utf-8"), 'gravity="0 0 0"/>',
                 'gravity="0.1 0 0"><flag autoreset="disable"/></option>')  # fmt: skip
PLANTED = {
    "links that collide at their pin": (
        SAW.replace(INERT, "").replace(' contact="disable"', ""),
        "joined-links-collide",
    ),
    "a loop closed twice": (replace_once(SAW, "</equality>", f"{TWICE}</equality>"), "redundant-closure"),
    "a soft closure": (replace_once(SAW, f" {CLOSURE}", ""), "soft-closure"),
    "a void tolerance": (replace_once(SAW, 'tolerance="0" ', ""), "solver-stops-early"),
    "a silent reset": (RESETS, "silent-reset"),
    "a step that is too long": (TOO_LONG, "step-too-long"),
    "parts that do not meet": (APART, "parts-apart"),
    "a model at rest": (AT_REST, "nothing-moves"),
    "an open start": (replace_once(SAW, 'euler="0 0 2.836899999574396"', 'euler="0 0 2.8379"'), "open-start"),
}

SAFE = ("solver-stops-early", "silent-reset")

CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)) + "f 1 2 4\nf 5 7 8\n"
# A gripper on a floating palm: two fingers by a replicate, an include with defaults and a mesh, and no names.
GRIPPER = """<mujoco>
  <compiler meshdir="shapes"/>
  <option timestep="0.001"/>
  <include file="parts/defaults.xml"/>
  <worldbody><body><freejoint/><geom type="mesh" mesh="cube" density="500"/>
    <replicate count="2" offset="0 0.1 0"><body><joint/><geom/><body pos="0 0 0.1"><joint/><geom/></body></body>
    </replicate>
  </body></worldbody>
</mujoco>
"""
DEFAULTS = """<mujocoinclude>
  <default><joint axis="1 0 0"/><geom type="capsule" size="0.008 0.04"/></default>
  <asset><mesh name="cube" file="cube.obj" inertia="convex"/></asset>
</mujocoinclude>
"""


def at(folder: Path, text: str, **request: Any) -> Report:
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    return lint(path, **{"seconds": SHORT} | request)


# -- what is planted -------------------------------------------------------------------------------------------------


def rules_of(report: Report) -> set[str]:
    return {finding.rule for finding in report.findings}


@pytest.mark.parametrize("planted", PLANTED)
def test_what_is_planted_is_found_and_nothing_else(planted: str, tmp_path: Path) -> None:
    text, rule = PLANTED[planted]
    seconds = 10.0 if rule == "step-too-long" else SHORT
    report = at(tmp_path, renamed(text, seed=len(planted)), seconds=seconds)
    assert [(finding.rule, finding.safe) for finding in report.findings] == [(rule, rule in SAFE)]
    assert not rules_of(at(tmp_path, text, seconds=seconds, ignored=[rule]))
    assert set(RULES) == {rule for _, rule in PLANTED.values()}


@pytest.mark.parametrize(("constant", "found"), [(0.003, set()), (0.0034, {"soft-closure"})])
def test_closure_is_soft_when_it_gives_more_than_bearing_play(constant: float, found: set[str], tmp_path: Path) -> None:
    """By 0.88 and 1.1 ten-thousandths of the machine's size."""
    assert (
        rules_of(at(tmp_path, replace_once(SAW, CLOSURE, f'solref="{constant} 1" solimp="0.99 0.99 0.001 0.5 2"')))
        == found
    )


@pytest.mark.parametrize("off", [0.0, 1e-4])
def test_double_loop_is_redundant_and_pin_on_tilted_plane_is_not(off: float, tmp_path: Path) -> None:
    twice = four_bar().replace('pos="0.3 0 0"/>', f'pos="0.3 0 0"/><site name="D" pos="{0.3 + off} 0 0"/>')
    twice = twice.replace("</equality>", '<connect name="again" site1="B" site2="D"/></equality>')
    # Also where both contradict each other by a tenth of a millimetre.
    (found,) = (one for one in at(tmp_path, twice).findings if one.rule == "redundant-closure")
    assert (found.subjects, found.evidence["redundant"]) == (("again",), 2)
    # Negative control: the one pin has three rows, of which the plane leaves two.
    assert "redundant-closure" not in rules_of(at(tmp_path, four_bar()))


HANDLE = (CASES / "mocap-weld.xml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "text", [HANDLE, replace_once(HANDLE, "</equality>", "</equality><keyframe><key mpos='0.6 0 0.1'/></keyframe>")]
)
def test_a_weld_to_a_mocap_body_is_a_handle_and_no_error(text: str, tmp_path: Path) -> None:
    """Where the hand is at the start, and 0.1 m from there."""
    report = at(tmp_path, text, seconds=1.0)
    assert {one.severity for one in report.findings} == {Severity.NOTE}
    # Negative control: welded to the world it is a closure that gives way.
    assert "soft-closure" in rules_of(at(tmp_path, replace_once(HANDLE, ' mocap="true"', ""), seconds=1.0))


PIN = '<connect name="pin" body1="coupler" body2="rocker" anchor="0 0 -0.26"/>'
SWAPPED = '<connect name="pin" body1="rocker" body2="coupler" anchor="0 0 -0.22"/>'


@pytest.mark.parametrize(("pin", "words"), [
    (PIN, "pin holds rocker at a point 331 mm from its nearest geom: the parts do not meet"),
    # sqrt(0.3^2 + 0.14^2) m from end to end; from the rocker's end the coupler hangs 0.3 m aside.
    (SWAPPED, "pin holds coupler at a point 300 mm from its nearest geom: the parts do not meet"),
    ('<weld name="pin" body1="coupler" body2="rocker"/>', "pin holds rocker 282 mm apart from coupler"),
])  # fmt: skip
def test_parts_apart_are_named_with_the_sites_to_connect(pin: str, words: str, tmp_path: Path) -> None:
    (found,) = (one for one in at(tmp_path, replace_once(APART, PIN, pin)).findings if one.rule == "parts-apart")
    assert found.what.startswith(words)
    assert found.severity is (Severity.NOTE if "weld" in pin else Severity.ERROR)
    sites = 'site1="coupler_end" site2="rocker_end"' if pin == PIN else 'site1="rocker_end" site2="coupler_end"'
    assert "weld" in pin or sites in found.fix
    # Without sites on both it says to put them there.
    bare = re.sub(r"<site [^>]*>", "", replace_once(APART, PIN, pin))
    assert "put a site on each" in next(parts_apart(mujoco.MjModel.from_xml_string(bare))).cure


MEETING = """<mujoco><worldbody>
  <body name="a"><joint axis="0 1 0"/><geom {a}/>
    <body name="b" pos="0 0 -0.2"><joint axis="0 1 0"/><geom {b}/></body></body>
  <body name="c" pos="0.2 0 0"><joint axis="0 1 0"/><geom {c}/></body></worldbody>
  <equality><connect body1="b" body2="c" anchor="{anchor}"/></equality></mujoco>"""
BAR, CROSS = 'type="capsule" size="0.01" fromto="0 0 0 0 0 -0.2"', 'type="capsule" size="0.01" fromto="0 0 0 0.2 0 0"'


@pytest.mark.parametrize(("c", "anchor", "apart"), [
    (BAR, "0.2 0 0", False),  # end to end
    ('type="box" size="0.01 0.01 0.1" pos="0 0 -0.1"', "0.2 0 0", False),
    ('size="0.02" pos="0 0 -0.1" mass="1"', "0.2 0 0", False),  # a mass that is not drawn: nothing is known of it
    (BAR, "0.1 0 0", True),  # at the middle of b, beside c
])  # fmt: skip
def test_parts_that_meet_or_are_not_drawn_are_no_finding(c: str, anchor: str, apart: bool) -> None:
    model = mujoco.MjModel.from_xml_string(MEETING.format(a=BAR, b=CROSS, c=c, anchor=anchor))
    assert bool(list(parts_apart(model))) == apart
    # To the world anything may be pinned anywhere.
    world = MEETING.format(a=BAR, b=CROSS, c=c, anchor=anchor).replace(' body2="c"', "")
    assert not list(parts_apart(mujoco.MjModel.from_xml_string(world)))


# A four-bar of 216 mm with bars that are 8 mm thick: its coupler is held at the rocker's end, or beside it.
SMALL = """<mujoco><default><geom type="capsule" size="0.004"/><joint axis="0 1 0"/></default><worldbody>
  <body name="crank"><joint/><geom fromto="0 0 {gap} 0.04 0 0"/>
    <body name="coupler" pos="0.04 0 0"><joint/><geom fromto="0 0 0 0.096 0 0.11"/></body></body>
  <body name="rocker" pos="0.16 0 0"><joint/><geom fromto="0 0 0 -0.024 0 0.11"/></body></worldbody>
  <equality><connect name="pin" body1="coupler" body2="rocker" anchor="{x} 0 0.11"/></equality></mujoco>"""


@pytest.mark.parametrize(("off", "gap", "apart"), [
    (0.0, 0.0, False), (0.003, 0.0, False), (0.01, 0.0, True), (-0.01, 0.0, True), (0.01, 0.006, False),
])  # fmt: skip
def test_an_anchor_beside_thin_bars_is_found(off: float, gap: float, apart: bool) -> None:
    """Beyond the bar's own thickness, and twice what any joint of the file is off its links, which `gap` makes 6 mm."""
    found = list(parts_apart(mujoco.MjModel.from_xml_string(SMALL.format(x=0.096 + off, gap=gap))))
    assert bool(found) == apart
    if apart:
        assert found[0].distance == pytest.approx(0.01, rel=0.35)
        assert found[0].distance < 0.05 * 0.216  # which was the least that was seen


def test_steering_has_a_nothing_moves_note_until_driven(tmp_path: Path) -> None:
    text = (CASES / "steering.xml").read_text(encoding="utf-8")
    report = at(tmp_path, text, seconds=0.2)
    (found,) = (one for one in report.findings if one.rule == "nothing-moves")
    assert (found.severity, found.evidence["travel [m]"]) == (Severity.NOTE, 0.0)
    assert found.fix.endswith("`conrod check --drive JOINT=LAW` moves it")
    # Nothing is said to move what has neither a loop nor an actuator.
    loose = at(tmp_path, re.sub("<equality>.*</equality>", "", text, flags=re.DOTALL), seconds=0.02)
    (alone,) = (one for one in loose.findings if one.rule == "nothing-moves")
    assert alone.fix == "--keyframe KEY starts from a keyframe with rates (qvel)"
    motor = '</equality><actuator><motor name="m" joint="pinion"/></actuator>'
    driven = at(tmp_path, replace_once(text, "</equality>", motor), seconds=0.2, controls=(("m", 0.1),))
    assert "nothing-moves" not in rules_of(driven)


SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in ("shear-press", "saw-40rpm", "cam-follower")]


@pytest.mark.parametrize("name", ["saw-500rpm", *SLOW])
def test_conrods_own_models_have_no_finding(name: str) -> None:
    report = lint(MJCF / f"{name}.xml")
    assert report.findings == ()


def test_model_is_judged_at_a_stable_step_when_its_own_is_long(tmp_path: Path) -> None:
    report = at(tmp_path, replace_once(TOO_LONG, 'autoreset="disable" ', ""), seconds=10.0)
    assert rules_of(report) == {"step-too-long", "silent-reset"}
    evidence = next(finding.evidence for finding in report.findings if finding.rule == "step-too-long")
    assert evidence["step [s]"] == 0.05
    # RK4 follows a crank with four to five steps a turn, of 0.12 s.
    assert evidence["longest stable step [s]"] == 0.025
    assert report.notes == ("all other rules are judged with a step of 0.0125 s",)


def test_soft_closure_is_found_when_the_step_opens_a_stiff_one(tmp_path: Path) -> None:
    text = replace_once(SAW, 'timestep="0.00012" integrator="RK4"', 'timestep="0.004" integrator="Euler"')
    request: dict[str, Any] = {"seconds": 0.12, "ignored": ["step-too-long"]}
    (finding,) = at(tmp_path, replace_once(text, f" {CLOSURE}", ""), **request).findings
    assert finding.evidence["with a step of [s]"] < 0.004
    assert finding.evidence["opening when stiff [m]"] <= 0.1 * finding.evidence["opening [m]"]
    # Negative control: what opens by the step and not by its softness is none.
    assert at(tmp_path, text, **request).findings == ()


def test_the_rules_are_those_of_their_page() -> None:
    page = (MJCF.parent / "docs" / "lint.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([\w-]+)` \| (.)(.*?) \|", page, re.MULTILINE)
    assert {name: f"{first.upper()}{rest}." for name, first, rest in rows} == {n: r.__doc__ for n, r in RULES.items()}


# -- files -----------------------------------------------------------------------------------------------------------


def test_model_of_many_files_stays_and_its_fix_keeps_other_text(tmp_path: Path) -> None:
    gripper = tmp_path / "robot" / "gripper.xml"
    parts = {"gripper.xml": GRIPPER, "parts/defaults.xml": DEFAULTS, "shapes/cube.obj": CUBE}
    for name, text in parts.items():
        (gripper.parent / name).parent.mkdir(parents=True, exist_ok=True)
        (gripper.parent / name).write_text(text)
    assert set(model_files(gripper)) == {gripper.parent / name for name in parts}
    report = lint(gripper, seconds=0.02, fix_folder=gripper.parent)
    assert report.fixed.edits == ('<option><flag autoreset="disable"/></option>',)
    assert report.fixed.change == 0.0
    lines = GRIPPER.splitlines()
    assert [line for line in report.fixed.text.decode().splitlines() if line in lines] == lines
    with pytest.raises(InvalidInput, match=r"write it into .*robot, beside the model"):
        lint(gripper, seconds=0.02, fix_folder=tmp_path)
    _, found = study_invariances(gripper, 0.02, None, (), "")
    assert next(one.outcome for one in found if one.change == "order of declaration") is InvarianceOutcome.HOLDS
    left = {str(path.relative_to(gripper.parent)): path.read_text() for path in gripper.parent.rglob("*.*")}
    assert left == parts
    (gripper.parent / "fixed.xml").write_bytes(report.fixed.text)
    fixed, model = (mujoco.MjModel.from_xml_path(str(gripper.parent / name)) for name in ("fixed.xml", "gripper.xml"))
    assert first_difference(fixed, model) == "option"
    model.opt.disableflags = fixed.opt.disableflags
    assert first_difference(fixed, model) == ""


def test_what_needs_no_other_file_is_fixed_anywhere(tmp_path: Path) -> None:
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    report = at(tmp_path, RESETS + "<!-- </mujoco> -->\n", fix_folder=folder)
    (folder / "fixed.xml").write_bytes(report.fixed.text)
    assert lint(folder / "fixed.xml", seconds=SHORT).findings == ()


# -- what a user gets wrong ------------------------------------------------------------------------------------------

BAD: list[tuple[str, dict[str, Any], str]] = [
    ("nothing", {}, "it is no XML: syntax error"),
    ("<mujoco></mujoco>", {}, "nothing in the model can move"),
    ('<robot name="r"><link name="a"><inertial><mass value="1"/></inertial></link></robot>', {}, "is no MJCF|load"),
    (SAW, {"keyframe": "begin"}, "unknown keyframe 'begin': choose from qpos0, start"),
    (SAW, {"ignored": ("soft",)}, "did you mean 'soft-closure'"),
    (SAW, {"seconds": 1e6}, "at most 1000000"),
]


@pytest.mark.parametrize(("text", "request_", "words"), BAD)
def test_what_cannot_be_used_is_told_in_one_line(
    text: str, request_: dict[str, Any], words: str, tmp_path: Path
) -> None:
    with pytest.raises(InvalidInput, match=words) as told:
        at(tmp_path, text, **request_)
    assert len(str(told.value).splitlines()) == 1


def test_a_model_that_runs_at_no_step_is_a_finding(tmp_path: Path) -> None:
    joint = '<joint name="crank-pin" type="hinge" axis="0 0 1" />'
    report = at(tmp_path, replace_once(SAW, joint, '<joint name="crank-pin" damping="-1e9" />'))
    assert report.findings[0].rule == "step-too-long"
    assert "at no step" in report.findings[0].what
    json.dumps(report.document(), allow_nan=False)


# -- the command -----------------------------------------------------------------------------------------------------


def test_the_command_tells_writes_and_ends_with_its_status(tmp_path: Path) -> None:
    (tmp_path / "saw.xml").write_text(renamed(RESETS))
    outputs = ("--fail-on", "note", "--json", "found.json", "--fix", "fixed.xml")
    done = conrod("lint", "saw.xml", "--seconds", "0.01", *outputs, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    for words in ("silent-reset", "evidence: ", "1 finding: 1 note\n", "fixed.xml: 1 edit; the motion did not change"):
        assert words in done.stdout
    found = json.loads((tmp_path / "found.json").read_text())
    (finding,) = found["findings"]
    assert (finding["rule"], finding["severity"], found["fixed"]["change"]) == ("silent-reset", "note", 0.0)
    assert conrod("lint", "saw.xml", "--seconds", "0.01", cwd=tmp_path).returncode == 0  # a note is no error
    done = conrod("lint", "fixed.xml", "--seconds", "0.01", "--fail-on", "note", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "no findings" in done.stdout


def test_sarif_gives_each_finding_its_line_and_escapes_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    name, hostile = "my saw, 100%: é.xml", 'planted "\r\n<name>'
    lines = ("<mujoco>", " <option/>", ' <!-- name="pin" -->', " <equality>", "  <connect", '    name="pin"/>')
    Path(name).write_text("\n".join((*lines, " </equality></mujoco>")), encoding="utf-8")
    one = Finding(rule="open", what="opens", why="so", severity=Severity.ERROR, evidence={}, fix="", subjects=("pin",))
    reset = replace(one, rule="reset", severity=Severity.NOTE, subjects=(), edits=('<option><flag autoreset=""/>',))
    report = Report(name, "a free run", (one, replace(one, what=hostile, subjects=("elsewhere",)), reset))
    (run,) = json.loads(sarif([report]))["runs"]
    places = [found["locations"][0]["physicalLocation"] for found in run["results"]]
    assert [found["level"] for found in run["results"]] == ["error", "error", "note"]
    assert [place["region"]["startLine"] for place in places] == [5, 1, 2]
    assert {unquote(place["artifactLocation"]["uri"]) for place in places} == {name}
    assert {found["ruleId"] for found in run["results"]} == {rule["id"] for rule in run["tool"]["driver"]["rules"]}
    assert run["results"][1]["message"]["text"].startswith(hostile)
