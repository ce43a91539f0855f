"""What moves a model: laws that actuators follow, keyframes that are held, energy of a free swing, mobility."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from four_bars import four_bar

from conrod.errors import InvalidInput
from conrod.mjcf.loading import data_at_start
from conrod.models.inspection.energy import free_energy
from conrod.models.inspection.following import drives_of_joints, follow_laws
from conrod.models.inspection.keyframe_holds import hold_keyframes
from conrod.models.inspection.moving import count_model_mobility, study_moving
from conrod.models.inspection.moving_results import FreeEnergy, LawResponse

MASS, GRAVITY, KP, KV, STEP = 2.0, 9.81, 2000.0, 120.0, 0.002
SERVO = f'<position name="servo" joint="lift" kp="{KP}" kv="{KV}" ctrlrange="-0.4 0.4"/>'


def on_slide(actuator: str, keys: str = "") -> mujoco.MjModel:
    """A mass on a vertical slide."""
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}"/><worldbody><body><joint name="lift" type="slide" axis="0 0 1"/>'
        f'<geom size="0.05" mass="{MASS}"/></body></worldbody><actuator>{actuator}</actuator>'
        f"<keyframe>{keys}</keyframe></mujoco>"
    )


def pendulums(step: float, option: str = "") -> mujoco.MjModel:
    """A double pendulum that starts level."""
    rod = '<joint name="{}" axis="0 1 0" damping="0.1"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>'
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" {option}/><worldbody><body>{rod.format("one")}'
        f'<body pos="0.5 0 0">{rod.format("two")}</body></body></worldbody></mujoco>'
    )


def follow(model: mujoco.MjModel, **drives: str) -> LawResponse:
    (found,) = follow_laws(model, data_at_start(model, None)[0], drives)
    return found


# -- laws --------------------------------------------------------------------------------------------------------------


def test_servo_lags_behind_its_law_as_closed_form_says() -> None:
    found, omega = follow(on_slide(SERVO), servo="sine:50mm,1Hz"), 2.0 * math.pi
    # m y'' + kv y' + kp y = kp u - m g, so that y / u = kp / (kp - m w^2 + i kv w).
    transfer = KP / complex(KP - MASS * omega**2, KV * omega)
    assert found.gain == pytest.approx(abs(transfer), rel=5e-3)  # the step of Euler's method
    assert found.lag == pytest.approx(-np.angle(transfer) / omega, abs=STEP)
    assert found.drives == "joint lift"
    # Negative control: a servo with a tenth of the gain lags by more.
    assert follow(on_slide(SERVO.replace(f"{KP}", f"{KP / 10}")), servo="sine:50mm,1Hz").lag > 2.0 * found.lag


def test_law_of_a_joint_needs_weight_and_inertia() -> None:
    found = follow(on_slide(SERVO), lift="sine:50mm,1Hz")
    needed = MASS * (GRAVITY + 0.05 * (2.0 * math.pi) ** 2)
    assert found.needed == pytest.approx(needed, rel=1e-3)
    assert found.follows
    assert not found.is_too_weak
    alone = follow(on_slide(""), lift="sine:50mm,1Hz")
    assert not alone.follows
    assert alone.needed == found.needed
    # Negative control: a force limit below it.
    weak = follow(
        on_slide(SERVO.replace("/>", f' forcerange="{-0.5 * needed} {0.5 * needed}"/>')), lift="sine:50mm,1Hz"
    )
    assert weak.is_too_weak
    assert weak.available == pytest.approx(0.5 * needed)


def test_speed_servo_is_commanded_the_rate_of_its_law() -> None:
    found = follow(on_slide('<velocity name="speed" joint="lift" kv="1000"/>'), speed="0.1m/s")
    assert found.unit == "m/s"
    assert found.end_error == pytest.approx(-MASS * GRAVITY / 1000.0, rel=1e-2)


@pytest.mark.parametrize(
    ("actuator", "drives", "words"),
    [
        (
            '<motor name="push" joint="lift"/>',
            {"push": "sine:50mm,1Hz"},
            "it is a motor, .* --drive lift=sine:50mm,1Hz",
        ),
        (SERVO, {"servo": "move:0,0.9m,1s"}, "clamps it to its ctrlrange, -0.4 to 0.4"),
        (SERVO, {"sevro": "0.1m/s"}, "unknown joint or actuator 'sevro': did you mean 'servo'?"),
    ],
)
def test_law_that_cannot_be_followed_is_refused(actuator: str, drives: dict[str, str], words: str) -> None:
    model = on_slide(actuator)
    with pytest.raises(InvalidInput, match=words):
        follow_laws(model, data_at_start(model, None)[0], drives)


def test_joint_of_a_drive_is_that_of_its_actuator() -> None:
    model = on_slide(SERVO)
    assert drives_of_joints(model, {"servo": "hold", "other": "hold"}) == {"lift": "hold"}
    assert drives_of_joints(model, {"lift": "0.1m/s"}) == {"lift": "0.1m/s"}


# -- keyframes ---------------------------------------------------------------------------------------------------------


def test_keyframe_stays_where_its_control_holds_it() -> None:
    sag = MASS * GRAVITY / KP
    held, forgotten = hold_keyframes(
        on_slide(SERVO, f'<key name="held" qpos="0.2" ctrl="{0.2 + sag}"/><key name="forgotten" qpos="0.2"/>')
    )
    assert held.stays
    assert held.moved < 1e-6
    # Negative control: without a control the servo goes to 0, less the sag.
    assert not forgotten.stays
    assert forgotten.moved == pytest.approx(0.2 + sag, rel=1e-3)
    assert forgotten.pulled == ("servo",)
    assert "servo is told to go elsewhere" in forgotten.words
    # Where it is in the end, not how far it swings on its way.
    away = f"{1e3 * forgotten.moved:.0f}"
    assert f"with all controls 0 it is {away} mm (lift by {away} mm) away after 1 s" in forgotten.words
    assert "after 1 s)" in held.words


# -- energy ------------------------------------------------------------------------------------------------------------


def test_energy_that_a_step_adds_is_named_with_a_finer_step() -> None:
    model = pendulums(0.02)
    found = free_energy(model, data_at_start(model, None)[0])
    assert found is not None
    assert found.grows
    assert found.damped  # of the joints, which its own runs have: no alarm
    assert found.steady_step is not None
    # Negative control: at the step that is named, and with RK4, none is added.
    for mended in (pendulums(found.steady_step), pendulums(0.005, 'integrator="RK4"')):
        less = free_energy(mended, data_at_start(mended, None)[0])
        assert less is not None
        assert not less.grows


def test_energy_that_breaks_off_only_grows_at_finer_steps() -> None:
    found = FreeEnergy(0.002, "implicitfast", 4.0, None, "not finite (BADQACC) at 2.2 s", rk4=2.5e-4)
    assert found.grows
    assert found.words == (
        "swinging freely for 4 s without loads it breaks off: not finite (BADQACC) at 2.2 s at its step of 2 ms "
        "(implicitfast), and grows by more than 1 % at all smaller ones that were tried; with RK4 at 2 ms its energy "
        "changes by 0.025 %"
    )
    # Control: a step at which it stays is named.
    assert (
        "its energy grows by 4.4 % at its step of 2 ms (Euler), not at 0.25 ms"
        in replace(found, integrator="Euler", growth=0.044, broke="", steady_step=2.5e-4).words
    )


def test_energy_is_not_followed_where_a_loop_is_closed() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar())
    assert free_energy(model, data_at_start(model, None)[0]) is None


# -- mobility ----------------------------------------------------------------------------------------------------------


def test_redundant_equations_and_drive_of_a_four_bar_are_counted() -> None:
    model = mujoco.MjModel.from_xml_string(
        four_bar(more='<actuator><position name="m" joint="crank" kp="9"/></actuator>')
    )
    found = count_model_mobility(model, data_at_start(model, None)[0])
    assert found is not None
    assert (found.freedom, found.rank, found.driven, found.redundant) == (1, 2, 1, {"pin": 1})
    assert "driven by 1 actuator" in found.words
    assert "redundant equations: 1 of pin" in found.words


def test_study_of_a_driven_model_follows_the_law_alone() -> None:
    model = on_slide(SERVO)
    study = study_moving(model, data_at_start(model, None)[0], {"servo": "sine:50mm,1Hz"})
    assert study.passed
    assert study.actuators == ()
    assert study.lines[1].startswith("servo = sine:50mm,1Hz: joint lift follows within")


def test_study_does_not_pass_with_a_servo_that_is_too_weak() -> None:
    weight = MASS * GRAVITY
    weak, strong = (
        on_slide(SERVO.replace("/>", f' forcerange="{-share * weight} {share * weight}"/>')) for share in (0.1, 10.0)
    )
    assert not study_moving(weak, data_at_start(weak, None)[0]).passed
    # Negative control.
    assert study_moving(strong, data_at_start(strong, None)[0]).passed


def test_model_without_joints_is_not_stuck() -> None:
    model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
    study = study_moving(model, data_at_start(model, None)[0])
    assert study.lines == ("nothing: it has no joint",)
    assert study.passed
