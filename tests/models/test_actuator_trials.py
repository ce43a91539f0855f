"""Actuators that are tried: a servo on a slide against its closed form and plain MuJoCo, and planted defects."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from conrod.mjcf.loading import data_at_start
from conrod.models.inspection import actuators
from conrod.models.inspection.actuator_kinds import TriedActuator
from conrod.models.inspection.actuator_results import ActuatorResult
from conrod.models.inspection.actuator_runs import TrialBench
from conrod.models.inspection.actuators import try_actuators
from conrod.models.inspection.moving import count_model_mobility, study_moving
from conrod.models.inspection.results import Moving

MASS, KP, STEP, WEIGHT = 2.0, 2000.0, 0.002, 2.0 * 9.81


def on_slide(actuator: str, option: str = "", limits: str = "-0.5 0.5") -> mujoco.MjModel:
    """A mass on a vertical slide with one actuator."""
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" {option}/><worldbody><body>'
        f'<joint name="lift" type="slide" axis="0 0 1" range="{limits}" limited="true"/>'
        f'<geom size="0.05" mass="{MASS}"/></body></worldbody><actuator>{actuator}</actuator></mujoco>'
    )


def servo(extra: str, option: str = "") -> mujoco.MjModel:
    return on_slide(f'<position name="servo" joint="lift" kp="{KP}" ctrlrange="-0.4 0.4" {extra}/>', option)


def try_one(model: mujoco.MjModel) -> ActuatorResult:
    (found,) = try_actuators(model, data_at_start(model, None)[0])
    return found


def plain_response(model: mujoco.MjModel, first: float, second: float, seconds: float) -> np.ndarray:
    """Coordinates after a jump of the control, after as long a time at the first one; plain MuJoCo."""
    data, values = mujoco.MjData(model), list[float]()
    count = round(seconds / model.opt.timestep)
    for control in (first, second):
        data.ctrl[0] = control
        values = []
        for _ in range(count):
            values.append(float(data.qpos[0]))
            mujoco.mj_step(model, data)
    return np.array(values)


@pytest.fixture(scope="module")
def healthy() -> ActuatorResult:
    return try_one(servo('dampratio="1"'))


def test_healthy_servo_raises_no_alarm(healthy: ActuatorResult) -> None:
    assert healthy.alarms == ()
    assert healthy.responses
    assert all(one.is_reached and one.overshoot < 0.01 for one in healthy.responses)
    assert healthy.steps is not None
    assert healthy.steps.bears_own
    assert healthy.kind == "position"
    assert healthy.drives == "joint lift"


def test_sag_of_servo_is_weight_over_gain(healthy: ActuatorResult) -> None:
    assert healthy.sag == pytest.approx(-WEIGHT / KP, rel=1e-3)
    assert healthy.load == pytest.approx(WEIGHT, rel=1e-9)
    assert healthy.inertia == pytest.approx(MASS, rel=1e-9)
    # Negative control: without weight it does not sag.
    weightless = try_one(servo('dampratio="1"', 'gravity="0 0 0"'))
    assert weightless.sag == pytest.approx(0.0, abs=1e-9)


def test_slow_servo_is_said_to_move_on() -> None:
    # A time constant kv / kp of 2.5 s, in a trial of 4 s: exp(-1.6) of the first move is left.
    slow = try_one(servo(f'kv="{2.5 * KP}"', 'integrator="implicitfast" gravity="0 0 0"'))
    first = slow.responses[0]
    assert first.seconds == pytest.approx(4.0)
    assert first.missing_share == pytest.approx(math.exp(-1.6), rel=0.1)
    (alarm,) = slow.alarms
    assert alarm.startswith("is slow: after 4 s it is still ")
    # Negative control: what its weight holds off its target has ended there.
    weak = try_one(on_slide('<position name="servo" joint="lift" kp="100" kv="28" ctrlrange="-0.4 0.4"/>'))
    assert any("ends" in alarm for alarm in weak.alarms)


def test_servo_that_misses_its_command_does_not_pass() -> None:
    slow = try_one(servo(f'kv="{6.0 * KP}"', 'integrator="implicitfast" gravity="0 0 0"'))
    assert slow.misses_command
    found = Moving(None, (slow,))
    assert not found.passed
    assert found.alarms[0].startswith("actuator servo is slow: after 4 s it is still ")
    # Negative controls: one that arrives, and one that a limit or contact holds off, which is not the servo's fault.
    assert Moving(None, (try_one(servo('dampratio="1"')),)).passed
    blocked = tuple(replace(one, obstacles=("the range of joint lift",)) for one in slow.responses)
    assert Moving(None, (replace(slow, responses=blocked),)).passed


def test_largest_stable_step_says_what_it_is(healthy: ActuatorResult) -> None:
    assert "ms (half of it has the same response within 5.0 %)" in healthy.words()


BOUNCING = """<mujoco><option timestep="0.002"/><worldbody>
  <geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -0.1"/>
  <body><joint name="lift" type="slide" axis="0 0 1"/><geom name="ball" size="0.05" mass="2" solref="-20000 0"/></body>
  </worldbody><actuator><position joint="lift" kp="2000" ctrlrange="-0.4 0.4" DAMPING/></actuator></mujoco>"""


def test_obstacle_is_named_of_a_servo_that_rests_alone() -> None:
    def alarms(damping: str) -> str:
        return " ".join(try_one(mujoco.MjModel.from_xml_string(BOUNCING.replace("DAMPING", damping))).alarms)

    assert "contact of ball and floor in the way" in alarms('dampratio="1"')
    # What swings touches the floor too, now and then.
    swinging = alarms("")
    assert "still swings" in swinging
    assert "in the way" not in swinging


def test_settling_time_is_that_of_plain_mujoco(healthy: ActuatorResult) -> None:
    response = healthy.responses[0]
    values = plain_response(servo('dampratio="1"'), 0.0, response.target, 1.0)
    outside = np.flatnonzero(np.abs(values - values[-1]) > 0.02 * response.move)
    assert response.settling == pytest.approx(STEP * (outside[-1] + 1), abs=1.5 * STEP)
    assert response.final == pytest.approx(values[-1], abs=3e-4)


def test_a_trial_that_breaks_off_is_made_with_free_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    link = '<body name="{0}" pos="0 {1} 0"><joint name="{0}" axis="0 1 0"/><geom size="0.05"/></body>'
    motors = "".join(f'<motor name="{name}" joint="{name}" ctrlrange="-1 1"/>' for name in "ab")
    bodies = link.format("a", 0) + link.format("b", 1)
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{bodies}</worldbody><actuator>{motors}</actuator></mujoco>"
    )
    start, made = data_at_start(model, None)[0], actuators._try_on
    assert try_actuators(model, start)[0].remark == "b held still; neither control nor joint has a range"

    def thrown(bench: TrialBench, one: TriedActuator, *, search: bool) -> ActuatorResult:
        found = made(bench, one, search=search)
        return replace(found, broke="runs away") if bench.held else found

    monkeypatch.setattr(actuators, "_try_on", thrown)
    found = try_actuators(model, start)[0]
    assert not found.broke
    assert found.remark == "neither control nor joint has a range"
    # Control: what breaks off among free joints too keeps its first trial.
    monkeypatch.setattr(actuators, "_try_on", lambda *given, **named: replace(made(*given, **named), broke="runs away"))
    assert try_actuators(model, start)[0].broke == "runs away"


def test_a_step_that_an_actuator_does_not_bear_is_refused() -> None:
    # v' = -(kv / m) v diverges by explicit steps h from h kv / m = 2 on: m = 2 kg, kv = 1000 N s/m, h = 4 ms.
    model = on_slide('<velocity name="servo" joint="lift" kv="200" ctrlrange="-1 1"/>')
    start = data_at_start(model, None)[0]
    bears = actuators.still_bear(model, start, try_actuators(model, start))
    coarse = on_slide('<velocity name="servo" joint="lift" kv="1000" ctrlrange="-1 1"/>')
    coarse.opt.timestep, coarse.opt.integrator = 0.006, mujoco.mjtIntegrator.mjINT_EULER
    assert bears(model)
    assert not bears(coarse)
    coarse.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert bears(coarse)


def test_servo_at_its_limit_against_a_wall_is_not_too_weak() -> None:
    free = mujoco.MjSpec.from_string(
        f'<mujoco><option timestep="{STEP}"/><worldbody><body name="lift"><joint name="lift" type="slide" axis="0 0 1" '
        f'range="-0.5 0.5" limited="true"/><geom name="load" size="0.05" mass="{MASS}"/></body></worldbody>'
        f'<actuator><position name="servo" joint="lift" kp="{KP}" dampratio="1" ctrlrange="-0.4 0.4" '
        f'forcerange="{-3 * WEIGHT} {3 * WEIGHT}"/></actuator></mujoco>'
    )
    strong = try_one(free.compile())
    free.worldbody.add_geom(name="wall", type=mujoco.mjtGeom.mjGEOM_BOX, size=[1, 1, 0.1], pos=[0, 0, 0.3])
    found = try_one(free.compile())
    blocked = next(one for one in found.responses if not one.is_reached)
    assert abs(blocked.last) == pytest.approx(3 * WEIGHT)
    assert not found.is_too_weak
    assert "contact of load and wall in the way" in found.words()
    # Control: without the wall as strong a servo gets there.
    assert all(one.is_reached for one in strong.responses)


def test_servo_ten_times_too_weak_is_named() -> None:
    found = try_one(servo(f'dampratio="1" forcerange="{-0.1 * WEIGHT} {0.1 * WEIGHT}"'))
    assert found.is_too_weak
    assert "too weak" in found.words()
    assert found.limit == pytest.approx(0.1 * WEIGHT)
    assert found.load == pytest.approx(WEIGHT)
    # Negative control: ten times its weight is enough.
    strong = try_one(servo(f'dampratio="1" forcerange="{-10 * WEIGHT} {10 * WEIGHT}"'))
    assert not strong.is_too_weak
    assert strong.alarms == ()


def test_load_of_weak_servo_is_that_where_it_ends() -> None:
    spring, gain = 40.0, 100.0  # [N/m]: the load grows with the displacement, and is the weight alone at the start
    text = f'<position name="servo" joint="lift" kp="{gain}" dampratio="1" ctrlrange="-0.4 0.4"/>'
    model = on_slide(text)
    model.jnt_stiffness[0] = spring
    found = try_one(model)
    worst = max(found.responses, key=lambda one: one.missing_share)
    borne = gain * abs(worst.target - worst.final)
    assert borne == pytest.approx(spring * worst.final + WEIGHT, rel=0.02)
    assert f"under a load of {borne:.0f} N there: its gain is low" in found.words()
    assert f"{abs(found.load):.0f} N" != f"{borne:.0f} N"


def test_servo_that_overshoots_is_named_with_closed_form() -> None:
    ratio = 0.1
    made = f'<position name="servo" joint="lift" kp="{KP}" dampratio="{ratio}" ctrlrange="-0.4 0.4"/>'
    found = try_one(on_slide(made, 'integrator="RK4"', "-2 2"))
    expected = math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio**2))
    # The jump is of the move and of the sag before it, which stays: the response moves by the whole move.
    assert found.overshoot == pytest.approx(expected, rel=0.02)
    assert any("overshoots" in one for one in found.alarms)
    assert found.damping_hint == pytest.approx(2.0 * math.sqrt(KP * MASS))


def test_damper_that_the_step_does_not_bear_is_named() -> None:
    stiff = 3000.0  # 3 m / h: explicit Euler multiplies the speed by 1 - h kv / m = -2
    assert STEP * stiff / MASS == 3.0
    found = try_one(servo(f'kv="{stiff}"'))
    assert found.broke
    assert found.steps is not None
    assert found.steps.diverges
    assert found.steps.largest == pytest.approx(0.5 * STEP)
    assert found.steps.implicitfast is not None
    assert found.steps.implicitfast > STEP
    # Of a stiffer one no step that was tried is small enough: h kv / m > 2 of the least that is named.
    stiffer = try_one(servo('kv="2e4"')).steps
    assert stiffer is not None
    assert "none down to 0.25 ms is small enough" in stiffer.words
    assert stiffer.tried[0] * 2e4 / MASS > 2.0
    # Negative control: with implicitfast the step is borne.
    mended = try_one(servo(f'kv="{stiff}"', 'integrator="implicitfast"'))
    assert not mended.broke
    assert mended.steps is not None
    assert not mended.steps.diverges


@pytest.mark.parametrize("kv", [2500.0, 20.0])
def test_damper_actuator_brakes_if_the_step_bears_it(kv: float) -> None:
    found = try_one(on_slide(f'<damper name="brake" joint="lift" kv="{kv}" ctrlrange="0 1"/>'))
    assert found.kind == "damper"
    assert bool(found.broke) == (STEP * kv / MASS > 2.0) == bool(found.alarms)


def test_speed_servo_drifts_by_weight_over_gain() -> None:
    found = try_one(on_slide('<velocity name="speed" joint="lift" kv="400"/>'))
    assert found.kind == "velocity"
    assert found.sag == pytest.approx(-WEIGHT / 400.0, rel=1e-3)


def test_motor_reaches_no_position_and_holds_its_load() -> None:
    found = try_one(on_slide('<motor name="motor" joint="lift" gear="50" ctrlrange="-1 1"/>'))
    assert found.kind == "motor"
    assert "no position is reached" in found.words()
    assert found.acceleration == pytest.approx((50.0 - WEIGHT) / MASS, rel=1e-9)
    assert found.holds == found.span == (-0.5, 0.5)
    assert found.alarms == ()
    weak = try_one(on_slide('<motor name="motor" joint="lift" gear="10" ctrlrange="-1 1"/>'))
    assert weak.holds is not None
    assert weak.holds[0] == weak.holds[1]


def test_mobility_counts_what_actuators_drive() -> None:
    model = servo("")
    found = count_model_mobility(model, data_at_start(model, None)[0])
    assert found is not None
    assert (found.freedom, found.driven, found.undriven) == (1, 1, ())
    study = study_moving(model, data_at_start(model, None)[0])
    assert study.lines[0] == "1 degree of freedom, driven by 1 actuator"
