"""The file's own run is held to the laws of the drives: another speed, another sense, another branch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from own_model_edits import TEXTS, replace_once

from conrod.mjcf.loop_results import LoopRequest, LoopStudy
from conrod.models.loops import law_comparison, study
from conrod.models.loops.law_comparison import allowed_speed_error, commands_force, is_on_branch_of_laws
from conrod.models.loops.report import finding

CASES = Path(__file__).parents[2] / "data" / "cases"
SAW = TEXTS["saw"]
OMEGA = 4.1887902047863905  # [rad/s], 40 rpm
RATES = (-0.1317313576766063, OMEGA, -2.7251084528240996)  # at crank angle 0, on its motion
KEYFRAME = f'<key name="start" qpos="0 0 0" qvel="{" ".join(map(repr, RATES))}" />'
# The slider beyond the crank's axis, as far from it as on the branch of the reference pose, and the rod mirrored.
BRAKE = 'frictionloss="1e4" solimpfriction="0.9999 0.9999"'
OTHER_POSE = (0.5723635208501674, 0.0, np.pi - 2.0 * 2.836899999574396)


def keyed(factor: float = 1.0, pose: tuple[float, ...] = (0.0, 0.0, 0.0)) -> str:
    """The saw with its start rates times a factor, or at another pose where the rod follows the crank alone."""
    rates = [factor * rate for rate in RATES] if pose == (0.0, 0.0, 0.0) else other_rates()
    texts = (" ".join(map(repr, map(float, one))) for one in (pose, rates))
    return replace_once(SAW, KEYFRAME, '<key name="start" qpos="{}" qvel="{}" />'.format(*texts))


def other_rates() -> list[float]:
    """Rates at the pose on the other branch, where the rod's mirror image moves the slider."""
    # The rod's end at C = A + r e(theta) + l e(phi): r cos(theta) w + l cos(phi) phi' = 0.
    crank, rod, phi = 0.1, 0.3, np.pi - 2.836899999574396
    spin = -crank * OMEGA / (rod * np.cos(phi))
    return [-rod * np.sin(phi) * spin, OMEGA, spin - OMEGA]


def servo(control: float, gain: float = 100.0, actuator: str = "velocity", value: str = "kv") -> str:
    """The saw at rest, whose crank an actuator turns in place of conrod's flywheel."""
    text = replace_once(SAW, ' armature="1e+14"', "").replace('timestep="0.0015"', 'timestep="0.0003"')
    # At a tolerance of 0 MuJoCo iterates on where nothing is gained any more, at fifteen times the cost.
    text = replace_once(text, 'tolerance="0"', 'tolerance="1e-30"')
    text = replace_once(text, KEYFRAME, f'<key name="start" qpos="0 0 0" ctrl="{control!r}" />')
    motor = f'<actuator><{actuator} name="motor" joint="crank" {value}="{gain}" /></actuator>'
    return replace_once(text, "</equality>", f"</equality>{motor}")


@cache
def looped(text: str, law: str = "40rpm", seconds: float | None = None) -> LoopStudy:
    """The study at a single step with the model's own settings alone, nothing timed or searched."""
    with pytest.MonkeyPatch.context() as patch:
        for name, cheap in {"COARSER": (2,), "FINER": (), "CHECKED_INSTANTS": 60, "LABELS": ("as it is",)}.items():
            patch.setattr(study, name, cheap)
        patch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
        # Cheaper settings are no part of a verdict, and the search for them makes more runs than all else.
        patch.setattr(study._LoopBench, "_search", lambda *_: (None, ""))
        question = LoopRequest({"crank": law}, seconds=seconds, tolerance={"position": 1e-3})
        bench = study._LoopBench.from_request(mujoco.MjModel.from_xml_string(text), question)
        return bench.study("model.xml", "model", None)


WRONG = {
    "rates 30 % too fast": (keyed(1.3), "crank turns at 52 rpm, not at the 40 rpm of its law"),
    "rates 0.6 % too fast": (keyed(1.006), "crank turns at 40.24 rpm, not at the 40 rpm of its law"),
    "rates backwards": (keyed(-1.0), "crank turns backwards, at -40 rpm, not at the 40 rpm of its law"),
    "a servo at 41 rpm": (servo(1.03 * OMEGA), "crank turns at 41."),
    "a servo backwards": (servo(-OMEGA), "crank turns backwards, at -40"),
    "a servo that its brake holds": (
        replace_once(
            servo(OMEGA, 1.0),
            'axis="0 0 1" />\n      <inertial pos="0 0 0" mass="4"',
            f'axis="0 0 1" {BRAKE} />\n      <inertial pos="0 0 0" mass="4"',
        ),
        "crank stands still, not at the 40 rpm of its law",
    ),
    "the other branch": (keyed(1.0, OTHER_POSE), "it is on another assembly branch than the motion of the laws"),
}


@pytest.mark.parametrize("name", WRONG)
def test_own_run_is_out_of_tolerance_when_it_leaves_its_law(name: str) -> None:
    text, words = WRONG[name]
    found = looped(text)
    assert found.driven_run.is_within(found.question.tolerance)  # conrod's own drive hides it
    assert not found.passed
    first, _ = finding(found).split(" Driven with its own settings")
    assert first.startswith("Run as the file has it, from keyframe start")
    assert words in first
    assert first.endswith(": OUT OF TOLERANCE.")


@pytest.mark.parametrize(
    ("text", "law"),
    [(keyed(), "40rpm"), (keyed(1.004), "40rpm"), (keyed(-1.0), "-40rpm"), (servo(OMEGA), "40rpm"),
     (keyed(1.0, OTHER_POSE), "40rpm --keyframe")],
    ids=["as it ships", "0.4 % too fast", "backwards as asked", "a servo from rest", "the other branch as asked"],
)  # fmt: skip
def test_an_own_run_that_follows_its_law_passes(text: str, law: str) -> None:
    if law.endswith("--keyframe"):
        bench = study._LoopBench.from_request(
            mujoco.MjModel.from_xml_string(text), LoopRequest({"crank": "40rpm"}, keyframe="start")
        )
        shipped = bench._run_as_shipped(0.2)
        compared = bench._compare_with_laws(shipped, bench.machine.motion(np.linspace(0.0, 1.5, 9)), 0.2)
        assert compared.laws.speeds
        assert not compared.laws.differs
        return
    found = looped(text, law)
    assert found.shipped.laws.speeds
    assert found.passed
    assert "of its law" not in finding(found)


def test_own_run_is_not_judged_without_a_drive_or_a_speed() -> None:
    at_rest = looped(replace_once(SAW, KEYFRAME, ""))
    assert at_rest.passed
    assert ": not judged, nothing drives it" in finding(at_rest)
    assert "whether its own run" not in finding(at_rest)
    rocking = looped(keyed(1.3), "sine:40deg,1Hz")
    assert rocking.passed
    assert "whether its own run moves crank by the laws" in finding(rocking)
    # An actuator that holds a position, or a force that holds the crank, commands no speed.
    held = looped(servo(0.3, 1e4, "position", "kp"), seconds=0.2)
    assert not held.shipped.laws.speeds
    braked = replace_once(servo(1.0, 1.0, "motor", "gear"), 'axis="0 0 1" />\n      <inertial pos="0 0 0" mass="4"',
                      f'axis="0 0 1" {BRAKE} />\n      <inertial pos="0 0 0" mass="4"')  # fmt: skip
    assert not looped(braked, seconds=0.2).shipped.laws.speeds
    assert "whether its own run moves crank by the laws" in finding(looped(braked, seconds=0.2))


def test_speeds_are_held_to_what_their_error_moves_points_by() -> None:
    assert allowed_speed_error({}, 0.2, 1.0) == 0.01
    assert allowed_speed_error({"position": 1e-3}, 0.2, 1.0) == pytest.approx(0.005)
    assert allowed_speed_error({"position": 1.0}, 0.2, 1.0) == 0.01
    assert allowed_speed_error({"position": 1e-3, "velocity": 0.02}, 0.2, 1.0) == pytest.approx(0.02)


def poses() -> Iterator[tuple[str, tuple[float, float, float], bool]]:
    """Poses of the saw at crank angle 0, and whether they are on the reference pose's branch."""
    yield "its reference pose", (0.0, 0.0, 0.0), True
    yield "a thousand turns on", (0.0, 2e3 * np.pi, 0.0), True
    yield "open by a millimetre", (1e-3, 0.0, 0.0), True
    yield "the other branch", OTHER_POSE, False
    yield "the other branch, turns on", (OTHER_POSE[0], -20.0 * np.pi, OTHER_POSE[2]), False


@pytest.mark.parametrize(("name", "pose", "same"), list(poses()))
def test_a_pose_is_told_from_its_mirror_image(name: str, pose: tuple[float, float, float], same: bool) -> None:
    bench = study._LoopBench.from_request(mujoco.MjModel.from_xml_string(SAW), LoopRequest({"crank": "40rpm"}))
    names = [point.name for point in bench.points]
    assert is_on_branch_of_laws(bench.machine, names, np.array(pose), 4e-3) is same, name


def test_a_verdict_needs_both_the_speed_and_the_branch() -> None:
    found = looped(keyed())
    other = replace(found, shipped=replace(found.shipped, laws=replace(found.shipped.laws, other_branch=True)))
    assert not other.passed
    (speed,) = found.shipped.laws.speeds
    faster = replace(speed, own=replace(speed.own, mean=1.1 * OMEGA))
    assert not replace(found, shipped=replace(found.shipped, laws=replace(found.shipped.laws, speeds=(faster,)))).passed


def test_a_part_of_a_turn_is_held_to_what_a_speed_may_swing() -> None:
    # In a tenth of a turn the mean is that of where it is, which an uneven speed moves.
    assert looped(keyed(1.02), seconds=0.15).passed
    off = looped(keyed(1.2), seconds=0.15)
    assert not off.passed
    assert "crank turns at 48 rpm" in finding(off)


@pytest.mark.parametrize(("short", "allowed"), [(1.0 / (1.0 + 1e-9), 0.005), (1.0 - 2e-9, 0.1)])
def test_turn_is_whole_when_short_by_a_billionth(short: float, allowed: float) -> None:
    model = mujoco.MjModel.from_xml_string(keyed())
    turn = study._LoopBench.from_request(model, LoopRequest({"crank": "40rpm"})).period
    asked = LoopRequest({"crank": "40rpm"}, seconds=short * turn, tolerance={"position": 1e-3})
    bench = study._LoopBench.from_request(model, asked)
    motion = bench.machine.motion(np.linspace(0.0, asked.seconds or 0.0, 9))
    (speed,) = bench._compare_with_laws(bench._run_as_shipped(0.2), motion, 0.2).laws.speeds
    # The mean of a whole turn is held to 1 mm in 0.2 m, that of a part to what a speed may swing.
    assert speed.allowed == pytest.approx(allowed)


def test_speed_in_part_of_a_turn_is_that_of_its_last_half() -> None:
    # A soft servo starts the crank from rest; after half of the time it turns steadily.
    (speed,) = looped(servo(OMEGA, 10.0), seconds=0.15).shipped.laws.speeds
    assert 0.97 * OMEGA < speed.own.least < speed.own.mean < speed.own.most < OMEGA


@pytest.mark.parametrize(
    ("answers", "other"), [([True, False], True), ([False], True), ([True, True], False), ([None, None], False)]
)
def test_run_is_named_when_it_changes_to_another_branch(
    answers: list[bool | None], other: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = study._LoopBench.from_request(mujoco.MjModel.from_xml_string(keyed()), LoopRequest({"crank": "40rpm"}))
    shipped, motion, seen = bench._run_as_shipped(0.2), bench.machine.motion(np.linspace(0.0, 1.5, 9)), []

    def branch(_: object, names: object, pose: np.ndarray, near: float) -> bool | None:
        seen.append(float(pose[1]))
        return answers[len(seen) - 1]

    monkeypatch.setattr("conrod.models.loops.law_comparison.is_on_branch_of_laws", branch)
    assert bench._compare_with_laws(shipped, motion, 0.2).laws.other_branch is other
    # At the start, and a turn of the crank further, after the motion of the laws: not after the turn that follows.
    assert seen == pytest.approx([0.0, 2.0 * np.pi][: len(answers)], abs=1e-2)


def test_run_past_a_dead_centre_of_its_drive_keeps_its_branch() -> None:
    # The crank turns by itself, and a law drives the slide: they have nothing to do with each other.
    model = mujoco.MjModel.from_xml_string(replace_once(SAW, ' armature="1e+14"', ""))
    model.opt.tolerance = 1e-30
    bench = study._LoopBench.from_request(model, LoopRequest({"slide": "move:0m,-0.1m,1s"}))
    compared = bench._compare_with_laws(bench._run_as_shipped(0.2), bench.machine.motion(np.linspace(0.0, 1.0, 9)), 0.2)
    assert not compared.laws.differs
    # What commands the crank to a place begins on the other branch.
    held = replace_once(
        servo(0.3, 1e4, "position", "kp"), 'qpos="0 0 0"', f'qpos="{" ".join(map(repr, map(float, OTHER_POSE)))}"'
    )
    for text, other in ((held, True), (servo(0.3, 1e4, "position", "kp"), False)):
        bench = study._LoopBench.from_request(
            mujoco.MjModel.from_xml_string(text), LoopRequest({"crank": "sine:9deg,1Hz"})
        )
        motion = bench.machine.motion(np.linspace(0.0, 1.0, 9))
        assert bench._compare_with_laws(bench._run_as_shipped(0.2), motion, 0.2).laws.other_branch is other


def test_run_has_no_speeds_when_it_breaks_off_after_the_laws(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = study._LoopBench.from_request(mujoco.MjModel.from_xml_string(keyed(1.3)), LoopRequest({"crank": "40rpm"}))
    shipped, motion = bench._run_as_shipped(0.2), bench.machine.motion(np.linspace(0.0, 1.5, 9))
    assert bench._compare_with_laws(shipped, motion, 0.2).laws.differs
    monkeypatch.setattr("conrod.models.loops.law_comparison.break_off_reason", lambda *_: "not finite")
    assert not bench._compare_with_laws(shipped, motion, 0.2).laws.speeds


def test_held_base_is_no_other_branch_when_it_moves_in_own_run() -> None:
    base = '<body name="base"><freejoint name="base"/><inertial pos="0 0 0" mass="1e6" diaginertia="1e6 1e6 1e6"/>'
    text = replace_once(SAW, "<worldbody>", f"<worldbody>{base}")
    text = replace_once(replace_once(text, "</worldbody>", "</body></worldbody>"), KEYFRAME, "")
    bench = study._LoopBench.from_request(mujoco.MjModel.from_xml_string(text), LoopRequest({"crank": "40rpm"}))
    assert bench.machine.held == ("base",)
    names = [point.name for point in bench.points]
    at_start = np.array(bench.machine.knots[0].coordinates[:, 0])
    fallen, mirrored = at_start.copy(), at_start.copy()
    fallen[2] -= 3.0
    mirrored[7:] = OTHER_POSE
    assert is_on_branch_of_laws(bench.machine, names, fallen, 4e-3) is True
    assert is_on_branch_of_laws(bench.machine, names, mirrored, 4e-3) is False


@pytest.mark.parametrize(("actuator", "control", "commanded"), [
    ("motor", 0.0, False), ("motor", 1.0, True), ("motor", -2.0, True), ("velocity", 0.0, False),
    ("velocity", 2.0, False), ("position", 2.0, False),
])  # fmt: skip
def test_force_is_commanded_by_a_motor_with_a_control(actuator: str, control: float, commanded: bool) -> None:
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body><joint name="j"/><geom size="0.1"/></body></worldbody><actuator><{actuator} '
        'joint="j"/></actuator></mujoco>'
    )
    data = mujoco.MjData(model)
    data.ctrl[:] = control
    assert commands_force(model, data) is commanded


def test_run_has_its_pose_after_the_laws_and_a_rate_per_step() -> None:
    model = mujoco.MjModel.from_xml_string(keyed())
    data, alone = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_step(model, alone, nstep=3)
    (first, last), rates = law_comparison._run_on(model, data, 3, 2)
    assert (first.tolist(), last.tolist()) == ([0.0] * 3, alone.qpos.tolist())
    assert rates[2].tolist() == alone.qvel.tolist()
    assert len(rates) == 5


def test_hinge_is_led_the_shorter_way_or_all_its_turns() -> None:
    joints = SimpleNamespace(name="crank", unit="rad", coordinate=0), SimpleNamespace(name="s", unit="m", coordinate=1)
    machine: Any = SimpleNamespace(driven=joints)
    start, end = np.array([[1.0], [2.0]]), np.array([[1.5 + 20.0 * np.pi], [12.0]])
    for around, led in ((True, 1.5), (False, 1.5 + 20.0 * np.pi)):
        laws = law_comparison._laws_between(machine, start, end, around)
        ends = {name: law.derivatives(np.array([0.0, 1.0]))[0].tolist() for name, law in laws.items()}
        assert ends == {"crank": pytest.approx([1.0, led]), "s": pytest.approx([2.0, 12.0])}
