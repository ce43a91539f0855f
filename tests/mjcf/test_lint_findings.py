"""Findings of lint in all their words and figures, as people and build servers read them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from four_bars import four_bar

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.document import Document, first_difference
from conrod.mjcf.runs import Run, state_of
from conrod.models.lint import closures, stepping
from conrod.models.lint.bench import BOUNDLESS, LintBench
from conrod.models.lint.findings import Finding, FixedModel, Report, Severity, sarif
from conrod.models.lint.linting import RULES, fix, judge_rules, lint, prepare_bench

# Two arms on a common axis at 0.4 m from each other, tied by a belt.
ARMS = """<mujoco><option timestep="0.001" gravity="0 0 0"><flag {flag}/></option><worldbody>
  <body name="a"><joint name="a" axis="0 0 1"/><geom name="bar" size="0.01" pos="0.3 0 0" mass="1"/>{inner}</body>
  <body name="b" pos="0 0.4 0"><joint name="b" axis="0 0 1"/><geom size="0.01" pos="0.3 0 0" mass="1"/></body>
</worldbody><equality>{equality}</equality>{more}</mujoco>
"""
NO_RESET = 'autoreset="disable" contact="disable"'


def arms(equality: str = "", more: str = "", flag: str = NO_RESET, inner: str = "") -> str:
    return ARMS.format(equality=equality, more=more, flag=flag, inner=inner)


def bench_of(
    folder: Path, text: str, seconds: float = 0.02, keyframe: str | None = None, controls: Any = ()
) -> LintBench:
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    return prepare_bench(Document(path), keyframe, seconds, controls)[0]


def run_with(bench: LintBench, **values: Any) -> LintBench:
    """The bench with something else in its run, which it keeps."""
    made = replace(bench)
    made.__dict__["run"] = replace(bench.run, **values)
    return made


# -- the run -----------------------------------------------------------------------------------------------------------

KEYS = '<keyframe><key name="still" qpos="0.5 0"/><key name="spun" qpos="0 0.5" qvel="1 2"/></keyframe>'
MOTOR = '<actuator><motor name="m" joint="a"/><motor joint="b"/></actuator>'


@pytest.mark.parametrize(("asked", "steps", "words", "index"), [
    ({}, 2000, "a free run of 2000 steps of 0.001 s from keyframe still", 0),
    ({"seconds": 0.0305}, 31, "a free run of 31 steps of 0.001 s from keyframe still", 0),
    ({"seconds": 1e-9}, 2, "a free run of 2 steps of 0.001 s from keyframe still", 0),
    ({"seconds": 0.02, "keyframe": "spun"}, 20, "a free run of 20 steps of 0.001 s from keyframe spun", 1),
    ({"keyframe": "qpos0"}, 2000, "a free run of 2000 steps of 0.001 s from its own pose", None),
    ({"controls": (("m", 0.5),)}, 2000,
     "an actuated run of 2000 steps of 0.001 s from keyframe still with m = 0.5", 0),
])  # fmt: skip
def test_a_run_is_as_long_and_from_where_it_is_asked_for(
    asked: dict[str, Any], steps: int, words: str, index: int | None, tmp_path: Path
) -> None:
    (tmp_path / "model.xml").write_text(arms(more=KEYS + MOTOR))
    request = {"keyframe": None, "seconds": None, "controls": ()} | asked
    bench, said = prepare_bench(Document(tmp_path / "model.xml"), **request)
    assert (bench.steps, said, bench.keyframe, bench.step) == (steps, words, index, 0.001)
    pose = [[0.5, 0.0], [0.0, 0.5], [0.0, 0.0]][-1 if index is None else index]
    assert bench.start[:4].tolist() == [*pose, *([1.0, 2.0] if index == 1 else [0.0, 0.0])]
    assert (0.5 in bench.start[4:]) == ("controls" in asked)


def test_a_run_of_too_many_steps_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"^2000 s are 2000000 steps of 0\.001 s: at most 1000000$"):
        bench_of(tmp_path, arms(), seconds=2000.0)
    bench_of(tmp_path, arms(), seconds=1000.0)  # exactly so many
    with pytest.raises(InvalidInput, match=r"^nothing in the model can move$"):
        bench_of(tmp_path, '<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
    (tmp_path / "model.mjb").write_bytes(b"")
    with pytest.raises(InvalidInput) as told:
        Document(tmp_path / "model.mjb")
    assert str(told.value) == (
        f"{tmp_path}/model.mjb: a binary model cannot be taken apart; give the MJCF that it was made from"
    )


def test_a_bench_with_a_finer_step_runs_for_the_same_time(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, arms(more=KEYS), keyframe="spun")
    finer = bench.finer
    assert (finer.step, finer.steps, finer.edits) == (0.0005, 40, ('<option timestep="0.0005"/>',))
    assert finer.start is bench.start
    assert finer.finer.edits == ('<option timestep="0.0005"/>', '<option timestep="0.00025"/>')
    assert (bench.with_edits(()).steps, bench.with_edits((), 7).steps) == (20, 7)


def test_size_is_the_diagonal_about_moving_bodies_and_joints(tmp_path: Path) -> None:
    still = '<body pos="9 9 9"><geom size="0.01"/></body>'
    text = arms(inner='<body name="far" pos="0 0 0.5"><geom size="0.01" mass="1"/></body>')
    bench = bench_of(tmp_path, text.replace("</worldbody>", f"{still}</worldbody>"))
    # Of x from 0 to 0.3 m, y from 0 to 0.4 m, z from 0 to 0.5 m; what stands at (9, 9, 9) m is no part of it.
    assert bench.size == pytest.approx(0.5**0.5 * 1.0, rel=1e-12)
    turned = bench_of(
        tmp_path, text.replace("</mujoco>", '<keyframe><key qpos="1.5707963267948966 0"/></keyframe></mujoco>')
    )
    assert turned.size == pytest.approx((0.3**2 + 0.4**2 + 0.5**2) ** 0.5, rel=1e-9)
    point = '<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
    one = bench_of(tmp_path, point)
    assert one.size == float(one.model.stat.extent) > 0.0


def test_document_without_an_end_tag_is_refused_with_its_name(tmp_path: Path) -> None:
    path = tmp_path / "short.xml"
    path.write_text("<mujoco/>", encoding="utf-8")
    with pytest.raises(InvalidInput) as raised:
        Document(path)
    assert str(raised.value) == (f"{path}: it is no MJCF: it does not end with </mujoco>; mj_saveLastXML writes MJCF")


def moved(bench: LintBench, largest: float, travel: float) -> tuple[LintBench, Run]:
    """A bench whose point travels, and a run in which the point is off by so much."""
    points = np.zeros((2, 1, 3))
    points[1, 0, 0] = travel
    other = points.copy()
    other[1, 0, 1] = largest
    return run_with(bench, points=points), replace(bench.run, points=other)


def test_a_change_is_over_the_travel_or_the_size_of_what_stands(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, arms())
    assert bench.size == pytest.approx(0.5)
    for travel, largest, share in ((0.2, 0.01, 0.05), (1e-6, 1e-7, 0.1), (1e-11, 0.05, 0.1), (0.0, 0.05, 0.1)):
        one, other = moved(bench, largest, travel)
        assert one.change_to(other) == pytest.approx(share, rel=1e-9)
    one, other = moved(bench, np.nan, 0.2)
    assert one.change_to(other) == BOUNDLESS == 1e300
    assert one.change_to(replace(other, points=np.zeros((1, 1, 3)))) == BOUNDLESS
    empty = replace(other, points=np.zeros((2, 0, 3)))
    assert run_with(bench, points=empty.points).change_to(empty) == 0.0
    # What travels by exactly a billionth of the size stands, too.
    one, other = moved(bench, 0.05, 1e-9 * bench.size)
    assert one.change_to(other) == pytest.approx(0.05 / bench.size)


def test_models_differ_in_the_first_array_that_differs() -> None:
    one, other, third = (mujoco.MjModel.from_xml_string(arms(BELT)) for _ in range(3))
    assert first_difference(one, other) == ""
    other.body_mass[1] = 2.0
    assert first_difference(one, other) == "body_mass"
    third.opt.timestep = 0.5
    assert first_difference(one, third) == "option"
    assert first_difference(one, mujoco.MjModel.from_xml_string(arms())) != ""
    # What is no number in both is the same.
    both = [mujoco.MjModel.from_xml_string(arms(BELT)) for _ in range(2)]
    for model in both:
        model.geom_user = model.geom_user
        model.qpos_spring[0] = np.nan
    assert first_difference(*both) == ""
    renamed = mujoco.MjModel.from_xml_string(arms(BELT).replace('name="bar"', 'name="rab"'))
    assert first_difference(one, renamed) == ""


# -- findings of closures ----------------------------------------------------------------------------------------------

BELT = '<joint name="belt" joint1="a" joint2="b"/>'
PUSHED = ' gravity="0 0 0"'


def only(found: Any) -> Finding:
    (finding,) = found
    assert isinstance(finding, Finding)
    return finding


def test_an_open_start_is_a_finding_with_the_nearest_closed_pose(tmp_path: Path) -> None:
    key = '<keyframe><key name="begin" qpos="0.02 0"/></keyframe>'
    bench = bench_of(tmp_path, arms(BELT, key))
    found = only(closures.open_start(bench))
    # Of 0.02 rad at a size of 0.5 m; both arms go half of the way.
    size = bench.size
    assert found == Finding(
        subjects=("belt",),
        what=f"the start pose leaves loops open: belt by up to {20.0 * size:.3g} mm",
        severity=Severity.ERROR,
        evidence={"opening [m]": pytest.approx(0.02 * size), "start": "keyframe 0"},
        why="the closures pull it shut in the first steps: a blow that no machine gets, and speeds that stay",
        fix='qpos="0.01 0.01"',
        change=found.change,
    )
    assert found.change is not None
    assert found.change > 0.1
    closed = bench_of(tmp_path, arms(BELT, key.replace("0.02", "0")))
    assert list(closures.open_start(closed)) == []
    # A belt from nothing to nothing can be closed by no pose.
    hopeless = '<connect name="pin" body1="a" body2="world" anchor="0.3 0 0"/><connect name="no" site1="s" site2="t"/>'
    sites = '<site name="s" pos="0.3 0 0"/>'
    text = arms(hopeless, inner=sites).replace("<worldbody>", '<worldbody><site name="t" pos="5 0 0"/>')
    far = only(closures.open_start(bench_of(tmp_path, text)))
    assert (far.subjects, far.evidence["start"], far.change) == (("no",), "qpos0", None)
    assert far.what == "the start pose leaves loops open: no by up to 4.7e+03 mm"
    assert far.fix == "lengths or places of the closures: no pose closes them"


def test_double_closure_gives_a_whole_finding(tmp_path: Path) -> None:
    twice = BELT + BELT.replace("belt", "again")
    found = only(closures.redundant_closure(bench_of(tmp_path, arms(twice))))
    assert found == Finding(
        subjects=("again",),
        what="without again the closures hold what they hold",
        severity=Severity.NOTE,
        evidence={"redundant": 1, "rank": 1},
        why="forces are shared between rows that say the same: their reactions mean nothing, and where they do not "
        "agree to the last digit they fight",
        fix="leave out again",
    )
    other = BELT + '<joint name="other" joint1="a" polycoef="0 0 0 0 0"/>'
    assert list(closures.redundant_closure(bench_of(tmp_path, arms(other)))) == []
    assert list(closures.redundant_closure(bench_of(tmp_path, arms()))) == []


def test_partly_redundant_rows_give_a_finding_of_all_closures(tmp_path: Path) -> None:
    # Two pins between bodies that only turn about parallel axes: each holds what the other does, in part.
    text = """<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody>
      <body name="a"><joint axis="0 0 1"/><geom size="0.01" pos="0.3 0 0" mass="1"/>
        <body name="c" pos="0.3 0 0"><joint axis="0 0 1"/><geom size="0.01" pos="0.4 0 0" mass="1"/></body></body>
      <body name="b" pos="0.7 -0.2 0"><joint axis="0 0 1"/><joint type="slide" axis="0 1 0"/><geom size="0.01"
        mass="1"/></body></worldbody>
      <equality><connect name="p" body1="c" body2="b" anchor="0.4 0 0"/>
      <connect name="q" body1="c" body2="b" anchor="0.4 0.1 0"/></equality></mujoco>"""
    found = only(closures.redundant_closure(bench_of(tmp_path, text)))
    # Two rows each, of which three say something: c turns with b, and goes along.
    assert found.evidence == {"redundant": 1, "rank": 3}
    assert found.what == "1 rows of the closures (p, q) say what others say"
    assert found.fix == "tie each pin at one point, or let the bodies move in the plane of the machine only"
    assert found.subjects == ("p", "q")


OVERLAP = """<mujoco><option timestep="0.001" gravity="0 0 0"><flag autoreset="disable"/></option><worldbody>
  <body {one}><joint name="shaft" axis="0 0 1"/><geom size="0.05" mass="1"/>
    <body {two} pos="0.06 0 0"><joint name="pin" axis="0 0 1"/><geom size="0.05" mass="1"/></body></body>
  </worldbody>{more}</mujoco>"""
COLLIDE = 'option><default><geom solref="0.02 1"/></default>'


def overlap(one: str = 'name="arm"', two: str = 'name="hand"', more: str = "") -> str:
    # A body and its child are not tested for contact, but where filtering is off.
    text = OVERLAP.format(one=one, two=two, more=more)
    return text.replace('autoreset="disable"', 'autoreset="disable" filterparent="disable"')


def test_links_that_collide_at_their_joint_give_a_whole_finding(tmp_path: Path) -> None:
    found = only(closures.joined_links_collide(bench_of(tmp_path, overlap())))
    assert found.change is not None
    assert found == Finding(
        subjects=("arm", "hand"),
        what="arm and hand collide where joint pin joins them",
        severity=Severity.NOTE if found.safe else Severity.ERROR,
        evidence={"steps in contact": 20, "steps": 20},
        why="the contact pushes against the joint that holds the links together: friction, loads and rows of its own",
        fix="exclude the pair",
        edits=('<contact><exclude body1="arm" body2="hand"/></contact>',),
        safe=found.change <= 1e-9,
        change=found.change,
    )
    # Bodies without names cannot be excluded.
    bare = only(closures.joined_links_collide(bench_of(tmp_path, overlap(two=""))))
    assert (bare.subjects, bare.edits, bare.safe, bare.change) == (("arm", "body 2"), (), False, None)
    # Whoever declares the pair means it.
    named = overlap().replace('<geom size="0.05"', '<geom name="g0" size="0.05"', 1)
    named = named.replace(
        '<geom size="0.05" mass="1"/></body></body>', '<geom name="g1" size="0.05" mass="1"/></body></body>'
    )
    for pair in ('geom1="g0" geom2="g1"', 'geom1="g1" geom2="g0"'):
        declared = named.replace("</mujoco>", f"<contact><pair {pair}/></contact></mujoco>")
        bench = bench_of(tmp_path, declared)
        assert bench.run.touched
        assert list(closures.joined_links_collide(bench)) == []


@pytest.mark.parametrize(("steps", "found"), [(18, 1), (17, 0)])
def test_links_collide_that_touch_in_nine_of_ten_steps(steps: int, found: int, tmp_path: Path) -> None:
    bench = bench_of(tmp_path, overlap())
    assert len(list(closures.joined_links_collide(run_with(bench, touched={(0, 1): steps})))) == found
    assert list(closures.joined_links_collide(run_with(bench, touched={(-1, 1): 20}))) == []


@pytest.mark.parametrize(("equality", "joint"), [
    ('<connect name="tie" body1="a" body2="b" anchor="0.3 0 0"/>', "tie"),
    ('<connect name="tie" body1="b" body2="a" anchor="0.3 0 0"/>', "tie"),
    ('<weld name="tie" body1="a" body2="b"/>', "tie"),
    ('<connect name="tie" body1="a" body2="b" anchor="0.3 0 0" active="false"/>', ""),
    ('<connect name="tie" body1="a" anchor="0.3 0 0"/>', ""),
    (BELT, ""),
])  # fmt: skip
def test_bodies_are_joined_by_a_connect_or_weld_that_acts(equality: str, joint: str) -> None:
    assert closures._joint_between(mujoco.MjModel.from_xml_string(arms(equality)), 1, 2) == joint


def test_bodies_are_joined_by_hinges_balls_and_fixed_parts() -> None:
    kinds = {"": "", '<joint name="j" type="slide"/>': "", '<joint name="j" type="ball"/>': "joint j",
             '<joint name="j"/><joint name="k" axis="1 0 0"/>': "joint j",
             '<joint name="j"/><joint name="k" type="slide"/>': "",
             '<joint axis="1 0 0"/>': "joint joint 1"}  # fmt: skip
    for joints, name in kinds.items():
        text = f"""<mujoco><worldbody><body><joint axis="0 0 1"/><geom size="0.1"/><body><geom size="0.1"/>
          <body>{joints}<geom size="0.1"/><body><geom size="0.1"/></body></body></body></body></worldbody></mujoco>"""
        model = mujoco.MjModel.from_xml_string(text)
        for one in (1, 2):
            for two in (3, 4):
                assert closures._joint_between(model, one, two) == closures._joint_between(model, two, one) == name


def test_parts_that_do_not_meet_are_a_finding_in_all_its_words(tmp_path: Path) -> None:
    bar = '<geom type="capsule" size="0.01" fromto="0 0 0 0.3 0 0" mass="1"/>'
    text = arms("{}").replace('<geom size="0.01" pos="0.3 0 0" mass="1"/>', bar)
    text = text.replace('<geom name="bar" size="0.01" pos="0.3 0 0" mass="1"/>', bar)
    connect = only(closures.parts_do_not_meet(bench_of(
        tmp_path, text.format('<connect name="pin" body1="a" body2="b" anchor="0.3 0 0"/>'))))  # fmt: skip
    bench = bench_of(tmp_path, text.format('<weld name="grip" body1="a" body2="b"/>'))
    weld = only(closures.parts_do_not_meet(bench))
    extent = float(bench.model.stat.extent)
    why = (
        "from the reference pose: where that does not assemble the machine, it is another machine, closed at the "
        "start and of other lengths"
    )
    assert connect == Finding(
        subjects=("pin", "b"),
        what="pin holds b at a point 400 mm from its nearest geom: the parts do not meet",
        severity=Severity.ERROR,
        evidence={"distance [m]": pytest.approx(0.4), "extent of the model [m]": extent},
        why=f"a connect by bodies takes the anchor on the second body {why}",
        fix="put a site on each of the two parts, where they meet, and connect the sites",
    )
    # From surface to surface.
    assert weld == Finding(
        subjects=("grip", "b"),
        what="grip holds b 380 mm apart from a: the parts do not meet",
        severity=Severity.NOTE,
        evidence={"distance [m]": pytest.approx(0.38), "extent of the model [m]": extent},
        why=f"a weld by bodies takes the relative pose {why}",
        fix="give its relpose, or connect sites where the parts meet",
    )


def test_a_soft_closure_is_a_finding_in_all_its_words(tmp_path: Path) -> None:
    # A weight of 2 kg at 0.3 m hangs on a connect at 0.3 m: open by g (1 - d) / (k d) of the documentation.
    text = """<mujoco><option timestep="0.001" integrator="{}"><flag autoreset="disable"/></option><worldbody>
      <body name="a"><joint axis="0 1 0" damping="1"/><geom size="0.01" pos="0.3 0 0" mass="2"/></body></worldbody>
      <equality><connect name="pin" body1="a" body2="world" anchor="0.3 0 0"/></equality></mujoco>"""
    found = only(closures.soft_closure(bench_of(tmp_path, text.format("Euler"), seconds=0.2)))
    opened = float(found.evidence["opening [m]"])
    assert opened > 1e-4
    assert found == Finding(
        subjects=("pin",),
        what=f"closures give way: pin opens by {1000.0 * opened:.3g} mm",
        severity=Severity.ERROR,
        evidence={"opening [m]": opened, "opening when stiff [m]": found.evidence["opening when stiff [m]"],
                  "with a step of [s]": 0.001, "closures": 1},
        why="the loop is not closed: positions are off by the opening, accelerations by far more, and no smaller step "
        "helps",
        fix='solref="0.002 1" solimp="0.9999 0.9999 0.001 0.5 2", unless they are meant to give way; `conrod harden` '
        "takes out what no file can",
        change=found.change,
    )  # fmt: skip
    assert found.change is not None
    assert found.change > 0.5  # nothing else moves
    assert float(found.evidence["opening when stiff [m]"]) < 0.1 * opened
    # RK4 needs eight steps in place of two.
    runge = only(closures.soft_closure(bench_of(tmp_path, text.format("RK4"), seconds=0.2)))
    assert runge.fix.startswith('solref="0.008 1" ')


# -- findings of steps -------------------------------------------------------------------------------------------------


def test_a_reset_is_a_note_and_an_error_where_the_run_broke_off(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, arms(flag='contact="disable"'))
    note = only(stepping.silent_reset(bench))
    assert note == Finding(
        what="when its numbers go wrong the model starts again by itself, and the run goes on",
        severity=Severity.NOTE,
        evidence={"steps made of those asked for": "20 of 20"},
        why="a run that diverged is finite, smooth and wrong: the machine is back in its first pose, and a warning is "
        "the only sign of it",
        fix="autoreset off, and look at the warnings or at the numbers",
        edits=('<option><flag autoreset="disable"/></option>',),
        safe=True,
    )
    broken = only(stepping.silent_reset(run_with(bench, broke="not finite", steps=7)))
    assert broken == replace(note, severity=Severity.ERROR, evidence={"steps made of those asked for": "7 of 20"})
    assert list(stepping.silent_reset(bench_of(tmp_path, arms()))) == []


def test_what_stands_still_is_a_note_that_says_how_to_move_it(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, arms())
    still = only(stepping.nothing_moves(bench))
    assert still == Finding(
        what="nothing moves in its own run",
        severity=Severity.NOTE,
        evidence={"travel [m]": 0.0, "steps": 20, "actuators": 0},
        why="the closures carry nothing but what rests on them: that they are not seen to open says nothing of the "
        "model in motion",
        fix="--keyframe KEY starts from a keyframe with rates (qvel)",  # a drive needs a loop or an actuator
    )
    driven = only(stepping.nothing_moves(bench_of(tmp_path, arms(more=MOTOR))))
    ways = ("--ctrl NAME=VALUE commands a motion", still.fix, "`conrod check --drive JOINT=LAW` moves it")
    assert (driven.evidence["actuators"], driven.fix) == (2, "; ".join(ways))
    # A travel of 1e-9 of the size of 0.5 m is none.
    for travel, count in ((5e-10, 1), (6e-10, 0)):
        assert len(list(stepping.nothing_moves(moved(bench, 0.0, travel)[0]))) == count
    assert list(stepping.nothing_moves(run_with(bench, broke="not finite"))) == []


def test_too_long_step_gives_a_finding_with_half_of_the_longest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = bench_of(tmp_path, arms())
    stable: list[float] = [0.00025]
    monkeypatch.setattr(
        stepping, "is_stable", lambda one, finer: one.step <= stable[0] and finer.step == 0.5 * one.step
    )
    found = only(stepping.step_too_long(run_with(bench, steps=5, broke="bad qpos")))
    assert found == Finding(
        what="the step of 0.001 s is longer than the longest at which the model runs, 0.00025 s",
        severity=Severity.ERROR,
        evidence={"step [s]": 0.001, "longest stable step [s]": 0.00025, "steps made of those asked for": "5 of 20",
                  "the run ended": "by bad qpos"},
        why="the motion is the integrator's, not the machine's",
        fix='timestep="0.00025" or less: half of it leaves a margin',
        edits=('<option timestep="0.000125"/>',),
    )  # fmt: skip
    # Six halvings are tried: 1 ms to 1/32 ms.
    stable[0] = 0.001 / 32
    assert only(stepping.step_too_long(bench)).evidence["longest stable step [s]"] == 0.001 / 32
    stable[0] = 0.001 / 64
    none = only(stepping.step_too_long(bench))
    assert none.what == "the model does not run, at no step that was tried"
    assert none.evidence["longest stable step [s]"] == "none down to 1.563e-05"
    assert none.evidence["the run ended"] == "at its last step"
    assert (none.fix, none.edits) == ("look at the start pose, overlapping geoms, gains, and masses next to zero", ())
    stable[0] = 0.001
    assert list(stepping.step_too_long(bench)) == []


def opened(bench: LintBench, violation: float, travel: float, broke: str = "") -> LintBench:
    made = moved(bench, 0.0, travel)[0]
    made.__dict__["run"] = replace(made.run, broke=broke)
    made.__dict__["constraint_violations"] = np.array([[0.0], [violation]])
    return made


@pytest.mark.parametrize(("own", "finer", "stable"), [
    ((0.0, 0.2), (0.0, 0.2), True),
    ((0.0, 2.0), (0.0, 0.2), True),  # ten times as far
    ((0.0, 2.01), (0.0, 0.2), False),
    ((0.0, 5e-3), (0.0, 0.0), True),  # ten times a thousandth of the size of 0.5 m
    ((0.0, 5.01e-3), (0.0, 0.0), False),
    ((0.05, 0.2), (0.0, 0.2), True),  # a tenth of the size
    ((0.0501, 0.2), (0.0, 0.2), False),
    ((0.0501, 0.2), (0.00502, 0.2), True),  # ten times as wide
    ((0.0503, 0.2), (0.00502, 0.2), False),
    ((0.0, 0.2, "bad"), (0.0, 0.2), False),
    ((0.0, 0.2), (0.0, 0.2, "bad"), False),
])  # fmt: skip
def test_a_run_holds_together_as_the_finer_one_does(own: Any, finer: Any, stable: bool, tmp_path: Path) -> None:
    bench = bench_of(tmp_path, arms(BELT))
    assert stepping.is_stable(opened(bench, *own), opened(bench, *finer)) is stable


def test_a_void_tolerance_is_a_finding_in_all_its_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = bench_of(tmp_path, arms(BELT).replace("<option", '<option solver="CG" iterations="7"'))
    shares: Iterator[float] = iter(())
    change = [0.2]
    monkeypatch.setattr(LintBench, "change_to", lambda *_: change[0])
    monkeypatch.setattr(stepping, "_unsolved_share", lambda *_: next(shares))
    edit = '<option tolerance="0" solver="Newton" iterations="100"/>'

    def found(*left: float) -> list[Finding]:
        nonlocal shares
        shares = iter([*left, *[0.0] * 100])
        return list(stepping.solver_stops_early(bench))

    assert len(bench.run.states) == 21
    assert found(0.5, 0.002) == [Finding(
        what="the solver stops before it is done, perhaps before its first iteration",
        severity=Severity.ERROR,
        evidence={"tolerance": 1e-8, "poses with work left": "2 of 21", "largest share of the work left": 0.5,
                  "mean inertia that the tolerance is scaled by": float(bench.model.stat.meaninertia)},
        why="constraints get a part of their forces, or those of an earlier step, without a warning: MuJoCo scales its "
        "tolerance by the mean inertia, so that a large armature makes it void",
        fix="a solver that goes on until it is done",
        edits=(edit,),
        safe=True,
        change=0.2,
    )]  # fmt: skip
    # One pose of twenty is a hard one; a thousandth of the work is none.
    assert found(0.5) == []
    assert found(1e-3, 1e-3) == []
    assert len(found(1.1e-3, 1.1e-3)) == 1
    change[0] = 1e-7
    assert found(0.5, 0.5) == []
    # What is set right is not edited, nor looked at.
    right = bench_of(tmp_path, arms(BELT).replace("<option", '<option tolerance="0" iterations="100"'))
    monkeypatch.undo()
    assert list(stepping.solver_stops_early(right)) == []


def test_only_wrong_solver_options_are_edited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LintBench, "change_to", lambda *_: 0.2)
    monkeypatch.setattr(stepping, "_unsolved_share", lambda *_: 0.5)
    for wrong, edit in (
        ('tolerance="0" solver="CG"', '<option solver="Newton"/>'),
        ('tolerance="0" iterations="7"', '<option iterations="100"/>'),
        ('tolerance="1e-9"', '<option tolerance="0"/>'),
    ):
        bench = bench_of(tmp_path, arms(BELT).replace("<option", f"<option {wrong}"))
        (found,) = stepping.solver_stops_early(bench)
        assert found.edits == (edit,)


@pytest.mark.parametrize("opening", [0.02, 1e-6])
def test_work_that_a_solver_leaves_is_over_the_work_to_do(opening: float, tmp_path: Path) -> None:
    key = f'<keyframe><key qpos="{opening} 0"/></keyframe>'
    bench = bench_of(tmp_path, arms(BELT, key))
    solved = bench.model
    idle = mujoco.MjModel.from_xml_string(arms(BELT, key).replace("<option", '<option iterations="0"'))
    # Without an iteration all of the work is left: its warm start knows nothing.
    assert stepping._unsolved_share(idle, solved, bench.start) == pytest.approx(1.0, rel=1e-9)
    assert stepping._unsolved_share(solved, solved, bench.start) == 0.0
    free = mujoco.MjModel.from_xml_string(arms("", key))
    assert stepping._unsolved_share(free, free, state(free)) == 0.0


def state(model: mujoco.MjModel) -> Array:
    return state_of(model, mujoco.MjData(model))


# -- reports -----------------------------------------------------------------------------------------------------------


def test_a_report_has_its_file_run_notes_and_fixed_model(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(arms(flag="", more=KEYS + MOTOR), encoding="utf-8")
    report = lint(path, "spun", 0.02, ["nothing-moves"], tmp_path, (("m", 0.5),))
    assert report.model == str(path)
    assert report.run == "an actuated run of 20 steps of 0.001 s from keyframe spun with m = 0.5"
    assert [finding.rule for finding in report.findings] == ["silent-reset"]
    assert report.notes == ("In its own run, what acts besides its loops: the force of actuator m.",)
    edit = '<option><flag autoreset="disable"/></option>'
    assert report.fixed == FixedModel(report.fixed.text if report.fixed else b"", (edit,), 0.0)
    assert report.fixed is not None
    comment = "<!-- With these changes by the lint command of conrod: -->"
    body = path.read_text()
    assert report.fixed.text.decode() == body.replace("</mujoco>", f"  {comment}\n  {edit}\n</mujoco>")
    assert report.document()["fixed"] == {"edits": [edit], "change": 0.0}
    assert replace(report, fixed=None).document()["fixed"] is None
    assert lint(path, "spun", 0.02).fixed is None
    # Nothing to mend: no text.
    path.write_text(arms(more=KEYS), encoding="utf-8")
    assert lint(path, "spun", 0.02, fix_folder=tmp_path).fixed == FixedModel(b"", (), 0.0)


def test_findings_are_judged_in_the_order_of_their_harm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = bench_of(tmp_path, arms())
    note = Finding(what="note", severity=Severity.NOTE, evidence={}, why="", fix="", change=9.0)
    rules: dict[str, Any] = {name: lambda _: iter(()) for name in RULES}
    some = {"small": 0.1, "large": 0.2, "none": None}
    errors = [replace(note, what=what, severity=Severity.ERROR, change=change) for what, change in some.items()]
    rules |= {"parts-apart": lambda _: iter([note]), "silent-reset": lambda _: iter(errors)}
    monkeypatch.setattr("conrod.models.lint.linting.RULES", rules)
    monkeypatch.setattr(stepping, "longest_stable", lambda one: one)
    found, notes, steady = judge_rules(bench, ())
    assert [(one.what, one.rule) for one in found] == [
        ("large", "silent-reset"), ("small", "silent-reset"), ("none", "silent-reset"), ("note", "parts-apart"),
    ]  # fmt: skip
    assert (notes, steady) == ((), bench)
    assert [one.what for one in judge_rules(bench, ["silent-reset"])[0]] == ["note"]
    # With a step that is too long, with none at all, and with a solver that stops early.
    seen: dict[str, LintBench] = {}
    edit = '<option tolerance="0"/>'
    watching: Any = {name: lambda one, name=name: iter([seen.setdefault(name, one)][1:]) for name in RULES}
    monkeypatch.setattr("conrod.models.lint.linting.RULES", watching)
    monkeypatch.setattr(stepping, "longest_stable", lambda one: one.finer)
    _, notes, steady = judge_rules(bench, ())
    assert notes == ("all other rules are judged with a step of 0.00025 s",)
    assert {name: one.step for name, one in seen.items()} == {
        name: 0.001 if name == "step-too-long" else 0.00025 for name in RULES
    }
    seen.clear()
    monkeypatch.setattr(stepping, "longest_stable", lambda _: None)
    assert judge_rules(bench, ())[1:] == (("rules that need a run that holds together are not judged",), bench)
    assert set(RULES) - set(seen) == {"solver-stops-early", "soft-closure"}
    seen.clear()
    monkeypatch.setattr(stepping, "longest_stable", lambda one: one)
    solver = replace(note, edits=(edit,))
    monkeypatch.setattr("conrod.models.lint.linting.RULES", watching | {"solver-stops-early": lambda _: iter([solver])})
    assert judge_rules(bench, ())[1] == ("the rules after it are judged with the solver as it should be",)
    assert {name for name, one in seen.items() if one.edits != (edit,)} == {"step-too-long"}


def test_only_safe_edits_are_made(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, arms())
    note = Finding(what="", severity=Severity.NOTE, evidence={}, why="", fix="", edits=("<option/>",))
    assert fix(bench, (note,), tmp_path) == FixedModel()
    assert fix(bench, (note, replace(note, safe=True, edits=("<size/>", "<visual/>"))), tmp_path).edits == (
        "<size/>", "<visual/>",
    )  # fmt: skip


def test_a_sarif_log_is_that_of_its_schema(tmp_path: Path) -> None:
    path = tmp_path / "a b.xml"
    path.write_text('<mujoco>\n<option/>\n<worldbody>\n<body name="arm"/></worldbody></mujoco>', encoding="utf-8")
    one = Finding(rule="open", subjects=("arm",), what="it \x1b[2J opens\x07", severity=Severity.ERROR, evidence={},
                  why="so", fix="shut", edits=("<option/>",))  # fmt: skip
    log = json.loads(sarif([Report(str(path), "a run", (one,))]))
    assert log == {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "automationDetails": {"id": f"conrod lint/{path.as_uri()}"},
            "tool": {"driver": {
                "name": "conrod lint", "version": version("conrod"),
                "rules": [{"id": "open", "shortDescription": {"text": "so"}}],
            }},
            "results": [{
                "ruleId": "open",
                "level": "error",
                "message": {"text": log["runs"][0]["results"][0]["message"]["text"]},
                "locations": [{"physicalLocation": {
                    "artifactLocation": {"uri": path.as_uri()}, "region": {"startLine": 4},
                }}],
            }],
        }],
    }  # fmt: skip
    text = log["runs"][0]["results"][0]["message"]["text"]
    assert not set(text) & {"\x1b", "\x07"}
    assert text.splitlines()[1:] == ["so", "fix: shut", "<option/>"]
    # A subject that is in no line is at the root, and what is no XML at its first line.
    lost = replace(one, subjects=("leg",), edits=())
    for content, line in (("\n\n<mujoco/>", 3), ("{", 1), ("<mujoco", 1)):
        path.write_text(content, encoding="utf-8")
        (result,) = json.loads(sarif([Report(str(path), "", (lost,))]))["runs"][0]["results"]
        assert result["locations"][0]["physicalLocation"]["region"]["startLine"] == line


def test_four_bars_have_no_finding_of_their_closures(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, four_bar(option='integrator="RK4"'))
    for rule in (closures.open_start, closures.parts_do_not_meet, closures.redundant_closure):
        assert list(rule(bench)) == []
