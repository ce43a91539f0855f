"""Verdicts on a user's model name what acts besides its loops, in each mode, and do not judge it as the engine's."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import mujoco
import pytest
from four_bars import four_bar
from own_model_edits import TEXTS, judge_text, replace_once

from conrod.mjcf.loop_results import OWN_SETTINGS, LoopRequest, LoopStudy
from conrod.models.check.report import verdict
from conrod.models.check.results import ModelStudy
from conrod.models.harden.study import harden_file
from conrod.models.lint.linting import lint
from conrod.models.loops import study
from conrod.models.loops.report import exactness_facts, finding

CASES = Path(__file__).parents[2] / "data" / "cases"
TENDON, CONTACTS = ((CASES / f"saw-{name}.xml").read_text(encoding="utf-8") for name in ("tendon-limit", "contacts"))
SAW = TEXTS["saw"]
NOT_ALONE = "the exact motion has no limits or contacts, so errors are not the engine's alone"
# A pair of discs on a parabola: MuJoCo's acceleration of the second lacks p'' times the rate squared.
CURVED = """<mujoco><option timestep="0.001" gravity="0 0 0"/><default><geom contype="0" conaffinity="0"/></default>
<worldbody><body name="a"><joint name="a" axis="0 0 1"/><geom size="0.05"/></body>
<body name="b" pos="0.2 0 0"><joint name="b" axis="0 0 1"/><geom size="0.05"/>
  <site name="rim" pos="0.05 0 0"/></body></worldbody>
<equality><joint name="cam" joint1="b" joint2="a" polycoef="0 1 {} 0 0"/></equality>
<keyframe><key qvel="{} {}"/></keyframe></mujoco>"""  # fmt: skip


@cache
def looped(text: str, drive: str, seconds: float = 0.2, coarser: int = 1) -> LoopStudy:
    """The study of a model at its own step and one that is coarser by a factor, with nothing timed."""
    with pytest.MonkeyPatch.context() as patch:
        for name, cheap in {"COARSER": (coarser,), "FINER": (), "CHECKED_INSTANTS": 60}.items():
            patch.setattr(study, name, cheap)
        patch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
        joint, _, law = drive.partition("=")
        bench = study._LoopBench.from_request(
            mujoco.MjModel.from_xml_string(text), LoopRequest({joint: law}, seconds=seconds)
        )
        return bench.study("model.xml", "model", None)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., ModelStudy]:
    """The study of a model of the saw by its own settings, each once for all tests."""
    folder = tmp_path_factory.mktemp("scene")

    @cache
    def judged(text: str, turns: float = 1.0, kind: str = "saw") -> ModelStudy:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("conrod.models.check.study.LABELS", (OWN_SETTINGS,))
            return judge_text(folder, kind, text, turns)

    return judged


# -- limits and contacts -----------------------------------------------------------------------------------------------


def test_tendon_limit_is_named_and_spoils_no_torque_with_a_drive() -> None:
    found = looped(TENDON, "crank=40rpm", 1.5, coarser=2)
    assert re.search(
        rf"What acts besides its loops: the limit of tendon t \(up to 3\.\de\+04 N\); {NOT_ALONE}\.", finding(found)
    )
    # Plain MuJoCo reports the same force in the row of the limit.
    model = mujoco.MjModel.from_xml_string(TENDON)
    data, largest = mujoco.MjData(model), 0.0
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(1000):
        mujoco.mj_step(model, data)
        rows = data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON
        largest = max(largest, float(data.efc_force[: data.nefc][rows].max(initial=0.0)))
    assert largest == pytest.approx(next(one.largest for one in found.driven_run.acting), rel=0.01)
    assert "Not judged: forces: torques of drives and reactions bear the limit of tendon t too, which the" in finding(
        found
    )
    assert found.remarks[0].startswith("the length of tendon t is up to 0.103 beyond its limits, -0.1 to 9")
    assert found.unmodelled == ("the limit of tendon t",)
    assert not any("torque" in line for line in exactness_facts(found))
    assert all(not run.drives for run in (*found.runs, *found.steps))
    # Without the limit torques are compared, and nothing is said to act.
    free = looped(replace_once(TENDON, 'limited="true"', 'limited="false"'), "crank=40rpm", 0.6)
    assert "What acts" not in finding(free)
    assert "Not judged" not in finding(free)
    assert free.driven_run.drives["crank"] < 1e-2


def test_limit_of_a_tendon_keeps_a_saw_from_its_turn(scene: Callable[..., ModelStudy]) -> None:
    found = scene(TENDON)
    assert not found.passed
    assert "limits keep it from its turn: tendon t is held to -0.1 to 9, needs -0.2035" in verdict(found)
    assert "What acts besides its loops: the limit of tendon t" in verdict(found)
    off = scene(replace_once(TENDON, 'autoreset="disable"', 'autoreset="disable" limit="disable"'))
    assert off.passed
    assert "limit" not in verdict(off)


def test_contacts_are_named_with_a_scene_and_in_the_own_run(scene: Callable[..., ModelStudy]) -> None:
    found = scene(CONTACTS)
    assert f"What acts besides its loops: contact of rod and slider (up to 3.4e+03 N); {NOT_ALONE}." in verdict(found)
    assert [one.title for one in found.own_run.acting] == ["contact of rod and slider"]
    # What acts in the own run alone is said of it.
    model = replace_once(CONTACTS, '<joint name="crank-pin" type="hinge" axis="0 0 1" />',
                     '<joint name="crank-pin" type="hinge" axis="0 0 1" frictionloss="3"/>')  # fmt: skip
    assert "dry friction of joint crank-pin (up to 3 N m)" in verdict(scene(model, 0.1))
    assert "What acts" not in verdict(scene(SAW))


def test_contact_that_is_a_part_of_the_machine_is_not_named(scene: Callable[..., ModelStudy]) -> None:
    found = scene(TEXTS["cam"], 0.1, "cam")
    assert "contact" not in "".join(one.kind for run in (found.driven_run, found.own_run) for one in run.acting)


@pytest.mark.parametrize("preset", ["tuned", "hardened"])
def test_run_that_ends_says_what_stood_in_its_way(preset: str) -> None:
    limited = four_bar().replace('<joint name="rocker"', '<joint name="rocker" range="-0.5 0.5"')
    found = looped(limited, "crank=60rpm", 1.0)
    run = next(run for run in found.runs if run.label == preset)
    assert run.reason == "" or "; in its way: the limit of joint rocker (up to " in run.reason


# -- what MuJoCo's acceleration lacks, and gravity ---------------------------------------------------------------------


def test_polynomial_is_named_with_the_acceleration_that_it_lacks(tmp_path: Path) -> None:
    text, engine = CURVED.format(0.25, 2.0, 2.0), f"MuJoCo {mujoco.__version__}"
    words = f"{engine} lacks the part of the velocity in the acceleration of cam: up to 20 rad/s²"
    assert words in finding(looped(text, "a=60rpm"))  # 2 x 0.25 (2 pi)^2 = 19.7
    path = tmp_path / "curved.xml"
    path.write_text(text, encoding="utf-8")
    linted, hardened = lint(path, seconds=0.1), harden_file(path, seconds=0.1, force=True)
    assert any("lacks the part of the velocity in the acceleration of cam" in note for note in linted.notes)
    assert any("lacks the part of the velocity" in note for note in hardened.warnings)
    # A straight line lacks nothing; what lacks is MuJoCo's, and forces are compared with it.
    assert "lacks" not in finding(looped(CURVED.format(0.0, 2.0, 2.0), "a=60rpm"))
    assert looped(text, "a=60rpm").unmodelled == ()


@pytest.mark.parametrize(("gravity", "words"), [
    ("0 -9.81 0.00981", "A share of 0.001 of gravity acts across the plane of motion."),
    ("0 0 -9.81", "Gravity acts across the plane of motion."),
    ("0 -9.81 0", ""),
])  # fmt: skip
def test_gravity_across_the_plane_is_named_in_all_modes(
    gravity: str, words: str, scene: Callable[..., ModelStudy], tmp_path: Path
) -> None:
    text = replace_once(SAW, 'gravity="0 -9.81 0"', f'gravity="{gravity}"')
    path = tmp_path / "saw.xml"
    path.write_text(text, encoding="utf-8")
    said = [verdict(scene(text, 0.1 if words else 1.0)), finding(looped(text, "crank=40rpm")), *map(
        " ".join, (lint(path, seconds=0.1).notes, harden_file(path, seconds=0.1).warnings))]  # fmt: skip
    assert all((words in text) if words else ("plane" not in text) for text in said)


def test_limits_and_contacts_are_named_by_lint_and_harden(tmp_path: Path) -> None:
    for text, words in ((TENDON, "the limit of tendon t"), (CONTACTS, "contact of rod and slider")):
        path = tmp_path / "saw.xml"
        path.write_text(text, encoding="utf-8")
        for notes in (lint(path, seconds=0.6).notes, harden_file(path, seconds=0.6).warnings):
            (said,) = (note for note in notes if "what acts besides its loops" in note)
            assert words in said
            assert "exact motion" not in said
