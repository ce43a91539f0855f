"""The verdict on a user's model is on its file as it stands: its own start, rates, speed and limits come first."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from own_model_edits import TEXTS, judge_text, question, replace_once, replace_settings, scan_text

from conrod.comparison.trajectory import Outcome
from conrod.exact.motion import Array
from conrod.mjcf.crank_speed import CrankSpeed
from conrod.mjcf.driving import LoopRecording
from conrod.mjcf.loop_results import OWN_SETTINGS
from conrod.models.check import report as words
from conrod.models.check.results import CLOSURE, ModelStudy
from conrod.scenes import SCENES

SAW, SCENE, CASES = TEXTS["saw"], SCENES["saw-40rpm"], Path(__file__).parents[1] / "data" / "cases"
POSE, RATES = np.zeros(3), np.array([-0.1317313576766063, SCENE.speed, -2.7251084528240996])
ROD_TURN = 2.836899999574396  # of the rod in its reference pose
ALLOWED = {"position": 1e-4}

pytestmark = pytest.mark.usefixtures("no_presets")


@pytest.fixture
def no_presets(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their runs would take most of the time, and nothing is asked of them."""
    monkeypatch.setattr("conrod.models.check.study.LABELS", (OWN_SETTINGS,))


def with_keyframe(pose: Array | None = None, rates: Array | None = None, digits: int = 17) -> str:
    """The saw with another keyframe."""
    parts = {"qpos": pose, "qvel": rates}
    text = [f'{name}="{" ".join(f"{x:.{digits}g}" for x in some)}"' for name, some in parts.items() if some is not None]
    return re.sub(r'<key name="start".*?/>', f'<key name="start" {" ".join(text)}/>', SAW)


def without_keyframe() -> str:
    return re.sub(r"<keyframe>.*?</keyframe>", "", SAW, flags=re.DOTALL)


def other_branch() -> Array:
    """The closed pose at crank angle 0 with the slider on the other side of the shaft."""
    along = SCENE.shaft[0] + SCENE.crank  # type: ignore[attr-defined]
    return np.array([2.0 * along, 0.0, math.pi - 2.0 * ROD_TURN])


def judged_saw(folder: Path, text: str, tolerance: dict[str, float] | None = None, **asked: object) -> ModelStudy:
    return judge_text(folder, "saw", text, turns=2.0, tolerance=tolerance, **asked)


# -- starts and speeds that are wrong ----------------------------------------------------------------------------------

# The keyframe, what its verdict begins with and says, and its error of position [mm]; None where that says nothing.
WRONG: dict[str, tuple[Callable[[], str], str, str, float | None]] = {
    "open by 5 mm": (
        lambda: with_keyframe(np.array([5e-3, 0, 0]), RATES), "It begins 5 mm open: slider-pin",
        "loops open 0.024 (5.0 mm)", 5.0),
    "rod's rate not given": (
        lambda: with_keyframe(POSE, RATES * [1, 1, 0]), "Run as the file has it, from keyframe start",
        "the rates of its start open its loops: crank-pin at 0, they ask for -2.725 rad/s", 1.8),
    "slider's rate not given": (
        lambda: with_keyframe(POSE, RATES * [0, 1, 1]), "Run as the file has it",
        "slide at 0, they ask for -0.1317 m/s", 0.58),
    "other branch": (
        lambda: with_keyframe(other_branch()), "Run as the file has it, from keyframe start, it ended as flipped",
        "on another branch with crank at 0 deg, it starts so", None),
    "backwards": (
        lambda: with_keyframe(POSE, -RATES), "Run as the file has it", "its crank turns backwards", 8.9e-5),
    "41 rpm": (
        lambda: with_keyframe(POSE, 1.025 * RATES), "Run as the file has it",
        "strays from the 40 rpm of the scene (by 2.5 % on average, allowed 0.01 %)", 9.8e-5),
    "0.1 % fast": (
        lambda: with_keyframe(POSE, 1.001 * RATES), "Run as the file has it", "(by 0.1 % on average", 9.4e-5),
    "rates of 0": (
        lambda: with_keyframe(POSE, 0.0 * RATES), "Run as the file has it", "its crank stands still", None),
    "no rates": (
        lambda: with_keyframe(POSE), "Run as the file has it", "with no rates and no actuator", None),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_file_that_runs_otherwise_is_out_of_tolerance_first(what: str, tmp_path: Path) -> None:
    text, begins, said, off = WRONG[what]
    study = judged_saw(tmp_path, text(), ALLOWED)
    verdict = words.verdict(study)
    assert not study.passed
    assert verdict.startswith(begins)
    assert said in verdict
    # conrod's drive does not see it, and comes after it.
    assert "It is saw-40rpm. Driven by conrod, its own settings are within tolerance" in verdict
    found = study.own_run.worst("position")
    assert (found is None) == (off is None)
    if off is not None:
        assert 1e3 * found * max(SCENE.lengths.values()) == pytest.approx(off, rel=0.05)


@pytest.mark.parametrize(
    "what", ["open by 5 mm", "rod's rate not given", "other branch", "backwards", "41 rpm", "no rates"]
)
def test_what_is_badly_off_fails_without_a_tolerance_too(what: str, tmp_path: Path) -> None:
    study = judged_saw(tmp_path, WRONG[what][0]())
    assert not study.passed
    assert words.verdict(study).startswith(WRONG[what][1])


def test_open_keyframe_is_wrong_by_the_snap_to_a_closed_pose(tmp_path: Path) -> None:
    for name, off, acceleration in (("saw-keyframe-open", 30.0, 58.0), ("saw-keyframe-other-branch", 370.0, 800.0)):
        study = judged_saw(tmp_path, (CASES / f"{name}.xml").read_text(), ALLOWED)
        assert not study.passed
        assert 1e3 * study.own_run.worst("position") * max(SCENE.lengths.values()) == pytest.approx(off, rel=0.03)
        assert study.own_run.worst("acceleration") == pytest.approx(acceleration, rel=0.02)
        assert f"position {'0.15 (30' if off == 30.0 else '1.8 (370'} mm) > 1.0e-4" in words.verdict(study)


# -- what is healthy ---------------------------------------------------------------------------------------------------


def exact_start(folder: Path, crank: float) -> tuple[Array, Array]:
    """Exact coordinates and rates of the saw at a crank angle [rad]."""
    _, turning, _ = scan_text(folder, SAW, question("saw"))
    coordinates, rates = turning.state(crank)
    return coordinates, SCENE.speed * rates


@pytest.mark.parametrize("digits", [17, 6])
@pytest.mark.parametrize("crank", [0.0, 2.0])
def test_a_start_of_the_machine_raises_no_alarm(digits: int, crank: float, tmp_path: Path) -> None:
    study = judged_saw(tmp_path, with_keyframe(*exact_start(tmp_path, crank), digits), ALLOWED)
    assert study.passed
    verdict = words.verdict(study)
    assert verdict.startswith(
        "It is saw-40rpm. Run as the file has it, from keyframe start, its crank keeps to the 40 rpm"
    )
    assert "within tolerance. Driven by conrod, its own settings are within tolerance" in verdict
    assert "rates" not in verdict
    assert "begins" not in verdict
    # The clock of its own run counts from where it starts.
    assert study.own_run.worst("total") < 1e-4


def test_undriven_model_is_judged_by_conrods_drive(tmp_path: Path) -> None:
    study = judged_saw(tmp_path, without_keyframe(), ALLOWED)
    assert study.passed
    assert not study.has_start
    assert study.own_run.errors is None  # what stands still has no errors
    verdict = words.verdict(study)
    assert "Its own run is not judged: nothing drives it, from its own pose with no rates and no actuator" in verdict
    assert "it does not turn by itself" in verdict
    # Its loops are open there all the same, where they are.
    opened = replace_once(
        without_keyframe(), 'pos="0.1861817604250837 -0.09 0"', 'pos="0.1861817604250837 -0.09 0" euler="0 0 0.3"'
    )
    assert not judged_saw(tmp_path, opened, ALLOWED).passed


def test_a_free_machine_with_rates_does_not_keep_its_speed(tmp_path: Path) -> None:
    free = replace_settings(SAW, '<option timestep="0.0005" integrator="RK4"/>')
    study = judged_saw(tmp_path, free)
    assert study.strays
    assert "strays from the 40 rpm of the scene" in words.verdict(study)


# -- rules -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("tolerance", "allowed"), [
    (None, 0.01), ({"position": 1e-4}, 1e-4), ({"position": 0.1}, 0.01), ({"velocity": 0.05}, 0.05),
    ({"position": 1e-6, "velocity": 1e-3}, 1e-3), ({"acceleration": 1e-6}, 0.01),
])  # fmt: skip
def test_mean_speed_is_held_to_the_tolerance_of_velocities(
    tolerance: dict[str, float] | None, allowed: float, tmp_path: Path
) -> None:
    study = replace(judged_saw(tmp_path, SAW), tolerance=tolerance)
    assert study.speed_tolerance == allowed
    for share, strays in ((0.9 * allowed, False), (1.1 * allowed, True)):
        for speed in (SCENE.speed * (1.0 + share), SCENE.speed * (1.0 - share)):
            assert replace(study, crank=CrankSpeed(speed, speed, speed)).strays == strays
    uneven = CrankSpeed(SCENE.speed, 0.85 * SCENE.speed, 1.15 * SCENE.speed)
    assert replace(study, crank=uneven).strays
    assert replace(study, crank=CrankSpeed(math.nan, math.nan, math.nan)).strays


def test_the_position_bounds_how_far_loops_open(tmp_path: Path) -> None:
    study = judged_saw(tmp_path, SAW, ALLOWED)
    for spoilt in (
        replace(study, own_run=replace(study.own_run, opening=2e-4)),
        replace(study, runs={OWN_SETTINGS: replace(study.driven_run, opening=2e-4)}),
    ):
        assert spoilt.exceeded_limits() == {CLOSURE: (2e-4, 1e-4)}
        assert not spoilt.passed
        assert "out of tolerance" in words.verdict(spoilt).lower()
        assert replace(spoilt, tolerance={"velocity": 1e-2}).passed


@pytest.mark.parametrize(("first", "last", "outcome"), [
    (0.0, 0.05, Outcome.OPENED), (0.05, 0.05, Outcome.OPENED), (0.05, 0.0, Outcome.COMPLETED),
], ids=["opens", "stays open", "snaps shut"])  # fmt: skip
def test_a_run_whose_loops_stay_open_is_opened(first: float, last: float, outcome: Outcome, tmp_path: Path) -> None:
    def with_gaps(run: LoopRecording) -> LoopRecording:
        gaps = np.full(len(run.times), last)
        gaps[0] = first
        return replace(run, violations={"slider-pin": gaps})

    study = judge_text(tmp_path, "saw", SAW, tolerance=ALLOWED, spoil=with_gaps)
    assert study.driven_run.outcome is outcome
    assert not study.passed  # a run that snaps shut was open all the same


FOOT = '<body name="foot"><freejoint/><geom size="0.1"/></body></worldbody>'
SOFT_WELD = '<weld name="fast" body1="foot" solref="0.012 1"/></equality>'  # sags by 0.15 mm under the foot's weight


def test_a_weld_that_the_crank_does_not_move_is_not_judged(tmp_path: Path) -> None:
    unstarted = re.sub(r"(?s)<keyframe>.*</keyframe>", "", SAW)
    foot = replace_once(replace_once(unstarted, "</worldbody>", FOOT), "</equality>", SOFT_WELD)
    study = judged_saw(tmp_path, foot, ALLOWED)
    assert study.passed
    assert study.driven_run.opening < 1e-5
    # Negative control: the same softness in the loop counts.
    soft = re.sub(
        r'(<connect name="slider-pin"[^>]*?)solref="[^"]*"( solimp="[^"]*")?', r'\1solref="0.012 1"', unstarted
    )
    assert soft != unstarted
    assert judged_saw(tmp_path, soft, ALLOWED).driven_run.opening > 1e-4


# -- limits, contacts and points ---------------------------------------------------------------------------------------


def test_a_tendons_limit_keeps_a_model_from_its_turn(tmp_path: Path) -> None:
    text = (CASES / "saw-tendon-limit.xml").read_text()
    study = judged_saw(tmp_path, text, {"position": 1e-3})
    assert not study.passed
    held = "limits keep it from its turn: tendon t is held to -0.1 to 9, needs -0.203541 to 0.00756977"
    assert held in words.verdict(study)
    for off in (
        replace_once(text, 'range="-0.1 9"', 'range="-0.3 9"'),
        replace_once(text, 'contact="disable"', 'contact="disable" limit="disable"'),
    ):
        assert judged_saw(tmp_path, off, {"position": 1e-3}).passed


def test_contacts_pass_as_far_as_they_keep_to_the_tolerance(tmp_path: Path) -> None:
    text = (CASES / "saw-contacts.xml").read_text()
    assert judged_saw(tmp_path, text, {"position": 1e-4}).passed
    assert not judged_saw(tmp_path, text, {"position": 1e-5}).passed


def test_verdict_names_loops_not_judged_by_a_point_on_the_crank(tmp_path: Path) -> None:
    press = TEXTS["press"]
    study = judge_text(tmp_path, "press", press, tolerance=ALLOWED)
    assert study.model.rigid == ()
    rigid = replace(study, model=replace(study.model, rigid=study.points))
    assert f"Not judged: what moves by its loops: {', '.join(study.points)} are rigid with the crank" in words.verdict(
        rigid
    )


def test_what_is_not_judged_stands_in_the_verdict(tmp_path: Path) -> None:
    study = judged_saw(tmp_path, SAW, ALLOWED, points=("C",))
    assert "Not judged: M (not given); velocity and acceleration; forces" in words.verdict(study)
