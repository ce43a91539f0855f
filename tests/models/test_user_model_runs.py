"""How accurate are the settings of a user's own model, and what the drive has to do with it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from command_line import conrod, refusal
from own_model_edits import FILES, HACKSAW, POINTS, ROD_END, TEXTS, judge_text, question, replace_once, replace_settings

from conrod import MuJoCoSettings, compare, run
from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.mjcf.driving import LoopRecording, forward_copy
from conrod.mjcf.loop_results import OWN_SETTINGS
from conrod.models.check import report as words
from conrod.models.check import study as study_module
from conrod.models.check.frame import Frame, PlaneView
from conrod.models.check.results import ModelStudy
from conrod.models.check.study import ModelBench
from conrod.models.check.turning import prepare_turning
from conrod.scenes import SCENES

SAW, SCENE = TEXTS["saw"], SCENES["saw-40rpm"]
ROD_TURN = 2.836899999574396  # of the rod in its reference pose
STOCK = '<option timestep="0.002" gravity="0 -9.81 0"/>'
QUANTITIES = ("position", "velocity", "acceleration")


@pytest.fixture
def no_presets(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their runs would take most of the time, and nothing is asked of them."""
    monkeypatch.setattr("conrod.models.check.study.LABELS", (OWN_SETTINGS,))


def test_looking_at_a_run_changes_no_bit_of_it() -> None:
    text = replace_settings(SAW, '<option timestep="0.002" integrator="RK4"/>')
    model = mujoco.MjModel.from_xml_string(text)
    plain, looked_at, aside = (mujoco.MjData(model) for _ in range(3))
    for data in (plain, looked_at):
        mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(200):
        mujoco.mj_step(model, plain)
        forward_copy(model, looked_at, aside)
        mujoco.mj_step(model, looked_at)
    assert np.array_equal(plain.qpos, looked_at.qpos)
    assert np.array_equal(plain.qvel, looked_at.qvel)
    assert plain.time == looked_at.time


def test_own_file_is_as_accurate_as_its_preset(tmp_path: Path) -> None:
    study = judge_text(tmp_path, "saw", SAW, turns=2.0)
    assert study.passed
    for label in ("tuned", "hardened"):
        settings = getattr(MuJoCoSettings, label)(SCENE, 1000)
        errors = compare(run(SCENE, settings, 2.0), SCENE)
        for quantity in QUANTITIES:
            found = study.runs[label].worst(quantity)
            assert found == pytest.approx(errors.worst(quantity), rel=0.05)
    for quantity in QUANTITIES:
        assert study.runs[OWN_SETTINGS].worst(quantity) == study.runs["tuned"].worst(quantity)


def test_stock_model_is_the_machine_and_is_inaccurate(tmp_path: Path) -> None:
    text = replace_settings(SAW, STOCK)
    # From its keyframe, with rates, nothing keeps it at its speed.
    released = judge_text(tmp_path, "saw", text)
    assert released.strays
    assert not released.passed
    study = judge_text(tmp_path, "saw", text, keyframe="qpos0")
    assert study.is_machine
    assert not study.has_start
    assert study.passed
    own = study.driven_run
    assert own.steps_per_revolution == pytest.approx(750.0)
    own_error, tuned, hardened = (
        study.runs[label].worst("position") or 0.0 for label in (OWN_SETTINGS, "tuned", "hardened")
    )
    assert own_error > 1e-4
    assert 1e-5 > tuned > 1e-8 > hardened > 0.0
    # What was asked for is judged on these settings.
    asked = judge_text(tmp_path, "saw", text, tolerance={"velocity": 1e-6}, keyframe="qpos0")
    assert not asked.passed
    assert set(asked.exceeded_limits()) == {"velocity"}
    assert "out of tolerance: velocity" in words.verdict(asked)


def test_a_length_that_is_off_is_not_held_against_the_settings(tmp_path: Path) -> None:
    text = replace_once(SAW, ROD_END, 'name="slider-pin.rod" pos="0.303 0 0"')
    study = judge_text(tmp_path, "saw", text, points=("C",))
    assert not study.passed
    assert 0.0 < (study.runs["hardened"].worst("position") or 0.0) < 1e-9
    assert "rod is 1 % too long: 303 mm instead of 300 mm" in words.verdict(study)


def moved(run: LoopRecording, by: float) -> LoopRecording:
    """Its points further along x, from the middle of the run on."""
    motion = {name: own.copy() for name, own in run.points.items()}
    for own in motion.values():
        own[0, len(run.times) // 2 + 1 :, 0] += by
    return replace(run, points=motion)


def on_the_other_branch(run: LoopRecording) -> LoopRecording:
    """The rod mirrored at the crank pin, and C where that has it."""
    slide, crank, rod = run.coordinates
    back, pin = SCENE.motion(crank, 1.0).point("C").position[:, 0], SCENE.crank * np.cos(crank)  # type: ignore[attr-defined]
    across = 2.0 * (SCENE.shaft[0] + pin - back)
    mirrored, other = np.array([slide + across, crank, np.pi - rod - 2.0 * (crank + ROD_TURN)]), run.points["C"].copy()
    other[0, :, 0] += across
    return replace(run, coordinates=mirrored, points={"C": other})


@pytest.mark.usefixtures("no_presets")
@pytest.mark.parametrize(("spoil", "outcome"), [
    (lambda run: run, Outcome.COMPLETED),
    (lambda run: moved(run, 100.0), Outcome.EXPLODED),
    (lambda run: replace(run, violations={"slider-pin": np.linspace(0.0, 0.1, len(run.times))}), Outcome.OPENED),
    (on_the_other_branch, Outcome.FLIPPED),
    (lambda run: replace(run, outcome=Outcome.DIVERGED, reason="not finite"), Outcome.DIVERGED),
], ids=["as-it-is", "exploded", "opened", "flipped", "diverged"])  # fmt: skip
def test_how_a_run_ended_is_told_by_the_closed_list(tmp_path: Path, spoil: object, outcome: Outcome) -> None:
    study = judge_text(tmp_path, "saw", SAW, points=("C",), spoil=spoil)
    own = study.driven_run
    assert own.outcome is outcome
    assert (own.errors is None) == (outcome is not Outcome.COMPLETED)
    assert study.passed == (outcome is Outcome.COMPLETED)


def mirrored_at(sample: int, first: float) -> Callable[[LoopRecording], LoopRecording]:
    """Spoil a run: on the other branch at one sample alone, and C off by `first` [m] where it starts."""

    def spoil(run: LoopRecording) -> LoopRecording:
        other, coordinates, point = on_the_other_branch(run), run.coordinates.copy(), run.points["C"].copy()
        coordinates[:, sample], point[:, sample] = other.coordinates[:, sample], other.points["C"][:, sample]
        point[0, 0, 0] += first
        return replace(run, coordinates=coordinates, points={"C": point})

    return spoil


@pytest.mark.usefixtures("no_presets")
@pytest.mark.parametrize(("first", "starts"), [(0.0, ""), (0.005, ""), (0.1, "it starts so, and is ")])
def test_flipped_run_is_told_with_its_angle_and_its_start(first: float, starts: str, tmp_path: Path) -> None:
    # 1000 steps of a turn: sample 123 is at 44.28 deg. The joints may open by 0.05 of 0.211 m.
    own = judge_text(tmp_path, "saw", SAW, points=("C",), spoil=mirrored_at(123, first)).driven_run
    assert own.outcome is Outcome.FLIPPED
    assert own.reason.startswith(f"on another branch with crank at 44.28 deg, {starts}up to ")


@pytest.mark.usefixtures("no_presets")
@pytest.mark.parametrize(("way", "sizes", "exploded"), [(-1.0, 10.5, True), (1.0, 10.5, True), (1.0, 9.5, False)])
def test_run_has_exploded_when_far_from_where_it_starts(
    way: float, sizes: float, exploded: bool, tmp_path: Path
) -> None:
    # M starts half a size to the right of the document's origin.
    def thrown(run: LoopRecording) -> LoopRecording:
        point = run.points["M"].copy()
        point[0, -1] = point[0, 0] + [way * sizes * SCENE.kinematics.size, 0.0, 0.0]
        return replace(run, points={"M": point})

    own = judge_text(tmp_path, "saw", SAW, points=("M",), spoil=thrown).driven_run
    assert (own.outcome is Outcome.EXPLODED) is exploded
    assert own.reason.startswith("beyond 10 sizes of the mechanism from 1.5 s on") is exploded


@pytest.mark.parametrize(("kind", "contact"), [("saw", False), ("cam", True)])
def test_driven_run_has_a_contacts_settings_when_one_is_asked(
    kind: str, contact: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, asked, path = SCENES[FILES[kind]], question(kind), tmp_path / "model.xml"
    path.write_text(TEXTS[kind], encoding="utf-8")
    turning, models = prepare_turning(path, asked), list[mujoco.MjModel]()

    def record(_: object, model: mujoco.MjModel, *__: object, **___: object) -> LoopRecording:
        models.append(model)
        raise InvalidInput("recorded")

    monkeypatch.setattr("conrod.models.check.study.driven_run", record)
    frame = Frame(PlaneView("xy", (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 1), 1, 0.0, 0.0, 1.0, (0.0, 0.0, 0.0), (0.0, 0.0))
    bench = ModelBench(turning, asked, scene, scene.speed, frame, POINTS[kind], 1.0)
    with pytest.raises(InvalidInput, match="recorded"):
        bench.run_driven("tuned")
    integrator = mujoco.mjtIntegrator.mjINT_EULER if contact else mujoco.mjtIntegrator.mjINT_RK4
    assert models[0].opt.integrator == integrator


@pytest.mark.usefixtures("no_presets")
@pytest.mark.parametrize(("kept", "steps"), [(401, [50, 100, 200, 400]), (400, [50, 100, 200]), (200, [50, 100])])
def test_model_is_refined_as_far_as_samples_can_be_kept(
    kept: int, steps: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A turn of 400 steps has 401 samples."""
    monkeypatch.setattr("conrod.models.check.study.MAX_KEPT_SAMPLES", kept)
    coarse = replace_settings(SAW, '<option timestep="0.015" integrator="RK4"/>')
    study = judge_text(tmp_path, "saw", coarse, points=("C",), refine=True)
    assert [point.steps_per_revolution for point in study.refined[OWN_SETTINGS]] == steps


@pytest.mark.usefixtures("no_presets")
@pytest.mark.parametrize(
    "clock",
    [lambda run: run.times + run.times[1], lambda run: run.times * 1.0001],
    ids=["stamps a step late", "steps too short"],
)
@pytest.mark.parametrize("tolerance", [None, {"position": 1e-4}])
def test_a_wrong_clock_is_out_of_tolerance(tmp_path: Path, clock: Any, tolerance: dict[str, float] | None) -> None:
    assert judge_text(tmp_path, "saw", SAW, points=("C",), tolerance=tolerance).passed
    study = judge_text(
        tmp_path, "saw", SAW, points=("C",), tolerance=tolerance, spoil=lambda run: replace(run, times=clock(run))
    )
    assert not study.passed
    assert set(study.exceeded_limits()) == ({"phase", "total"} if tolerance else {"phase"})
    assert "out of tolerance: phase" in words.verdict(study)
    # Who asks for a phase and a total is held to these.
    assert replace(study, tolerance={"position": 1e-4, "total": 0.1, "phase": 0.1}).passed


# -- the run of the file as it is --------------------------------------------------------------------------------------

MOTOR = '<actuator><velocity name="motor" kv="{}" joint="crank"/></actuator></mujoco>'


def servo_at(tmp_path: Path, speed: float, kv: float = 30.0, tolerance: float = 1e-4) -> ModelStudy:
    """The saw with a velocity servo on its crank in place of the flywheel."""
    text = replace_once(replace_once(SAW, ' armature="1e+14"', ""), 'autoreset="disable"', 'autoreset="enable"')
    text, controls = replace_once(text, "</mujoco>", MOTOR.format(kv)), (("motor", speed),) if speed else ()
    return judge_text(tmp_path, "saw", text, points=("C",), tolerance={"position": tolerance}, controls=controls)


@pytest.mark.usefixtures("no_presets")
@pytest.mark.parametrize(("speed", "kv", "said"), [
    # kv over the crank's inertia times the step is 7.5, where RK4 holds up to 2.8.
    (SCENE.speed, 100.0, "Run as the file has it, from keyframe start with motor = 4.18879, it ended as reset"),
    (0.98 * SCENE.speed, 30.0, "strays from the 40 rpm of the scene (by 2 % on average, allowed 0.01 %): it turned"),
    (SCENE.speed, 2.0, "it turned at 39."),  # a soft one: uneven by a sixth
    (0.0, 30.0, "stands still, not at the 40 rpm of the scene, with all controls at 0 (--ctrl NAME=VALUE)"),  # a brake
], ids=["stiff", "slow", "soft", "nothing"])  # fmt: skip
def test_verdict_starts_with_servo_faults_that_the_drive_hides(
    tmp_path: Path, speed: float, kv: float, said: str
) -> None:
    study = servo_at(tmp_path, speed, kv)
    verdict = words.verdict(study)
    assert study.driven_run.outcome is Outcome.COMPLETED
    assert not study.passed
    assert verdict.startswith("Run as the file has it, ")
    assert said in verdict
    assert "Driven by conrod, its own settings are within tolerance" in verdict


@pytest.mark.usefixtures("no_presets")
def test_servo_passes_by_its_own_run_when_it_follows_command(tmp_path: Path) -> None:
    study = servo_at(tmp_path, SCENE.speed)
    assert study.passed
    assert "its crank keeps to the 40 rpm of the scene: it turned at 39.999 rpm on average" in words.verdict(study)
    # What was asked for is asked of both runs: here the file's own is a radian late.
    late = replace(study.own_run, phase=1.0)
    asked = replace(study, tolerance={"phase": 0.1})
    assert asked.passed
    assert replace(asked, own_run=late).exceeded_limits() == {"phase": (1.0, 0.1)}
    assert replace(study, own_run=late).passed
    assert len(study.judged) == 2
    worst = max(run.worst("position") or 0.0 for run in study.judged)
    assert not servo_at(tmp_path, SCENE.speed, tolerance=0.99 * worst).passed


@pytest.mark.usefixtures("no_presets")
@pytest.mark.parametrize(("gaps", "judged"), [((0.0, 0.01, 0.01), False), ((0.01, 0.0, 0.0), True)])
def test_standing_model_is_judged_where_its_start_is_open(
    gaps: tuple[float, ...], judged: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record = study_module.record_run

    def opened(*given: Any, **more: Any) -> Any:
        run, rest = record(*given, **more)
        later = np.full(len(run.times) - 2, gaps[2])
        return replace(run, violations={"slider-pin": np.array([*gaps[:2], *later])}), rest

    monkeypatch.setattr(study_module, "record_run", opened)
    own = servo_at(tmp_path, 0.0).own_run
    assert (own.outcome, own.errors is not None) == (Outcome.COMPLETED, judged)


@pytest.mark.slow
def test_the_cam_by_contact_is_driven_too(tmp_path: Path) -> None:
    study = judge_text(tmp_path, "cam", TEXTS["cam"])
    assert 0.0 < (study.driven_run.worst("position") or 0.0) < 3e-6
    assert study.passed


# -- as a user types it ------------------------------------------------------------------------------------------------

ASKED = ("--scene", "saw-40rpm", "--crank", "motor", "--point", "C=body:bow", "--point", "M=geom:rod")


def check_file(*arguments: object) -> tuple[int, str]:
    done = conrod("check", *map(str, arguments))
    return done.returncode, done.stdout


def test_a_users_model_is_judged_reported_and_left_as_it_is(tmp_path: Path) -> None:
    file = tmp_path / "my saw.xml"
    file.write_text(HACKSAW.read_text())
    out, document = tmp_path / "report", tmp_path / "result.json"
    status, told = check_file(file, *ASKED, "--revolutions", 1, "--out", out, "--json", document)
    assert status == 0, told
    assert "It is saw-40rpm" in told
    assert "plane xz, turned by 0 deg, crank zero at 90 deg, unit m" in told
    assert file.read_text() == HACKSAW.read_text()
    part = json.loads(document.read_text())["parts"]["my saw"]
    assert part["summary"]["passed"]
    assert part["findings"]["identity"]["frame"]["zero"] == pytest.approx(1.5707963267948966)
    assert set(part["findings"]["runs"]) == {"as it is", "tuned", "hardened"}
    assert json.loads((out / "data/my saw.json").read_text()) == part["findings"]
    assert "crank zero at 90 deg" in (out / "README.md").read_text()  # with all digits, as on the console


@pytest.mark.usefixtures("at_once")
def test_axis_that_is_no_number_is_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "saw.xml"
    file.write_text(replace_once(HACKSAW.read_text(), 'axis="0 1 0"', 'axis="nan 1 0"'))
    assert refusal("check", str(file), *ASKED) == f"conrod: {file}: jnt_axis is not finite"


@pytest.mark.usefixtures("at_once")
def test_wrong_model_has_exit_status_1_and_names_the_length(tmp_path: Path) -> None:
    file = tmp_path / "saw.xml"
    file.write_text(replace_once(TEXTS["saw"], ROD_END, 'name="slider-pin.rod" pos="0.30003 0 0"'))
    asked = ("--scene", "saw-40rpm", "--crank", "crank", "--point", "C=C", "--revolutions", 1)
    status, told = check_file(file, *asked)
    assert status == 1
    assert "It is not saw-40rpm as it stands: rod is 0.01 % too long: 300.03 mm instead of 300 mm." in told
    assert "not given, so not judged: M" in told
    # Negative control: a machine with such a rod is what it is.
    status, told = check_file(file, *asked, "--set", "rod=300.03mm")
    assert status == 0, told
