"""Actuators whose control follows a law, and joints outside loops that a law drives: motion and force."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput, list_names, unknown_choice
from conrod.exact.motion import Array
from conrod.exact.space.drive_laws import DriveLaw, parse_drive_law
from conrod.mjcf.driving import break_off_reason
from conrod.mjcf.loading import joint_kind, name_or_number, names_of
from conrod.models.inspection.actuator_kinds import TriedActuator, read_actuators
from conrod.models.inspection.actuator_results import SERVOS, SPEEDS
from conrod.models.inspection.actuator_runs import held_model
from conrod.models.inspection.moving_results import LawResponse

PERIODS = 3  # of a law that repeats; the last one is compared
REST = 0.5  # of a movement's time, that is looked at after its end
MAX_STEPS, INSTANTS = 40_000, 200
RANGE_ROUNDING = 1e-9


def follow_laws(
    model: mujoco.MjModel, start: mujoco.MjData, drives: Mapping[str, str],
    watch: Callable[[mujoco.MjData], object] = lambda data: None,
) -> tuple[LawResponse, ...]:  # fmt: skip
    """Let the controls of actuators follow laws in one run, and compute the forces that the laws of joints need.

    A joint's law commands the servo of the joint, where it has one. Other servos stay where they are.

    Args:
        start: data at the start; it is not changed.
        drives: law of each actuator or joint, as text (`conrod.exact.space.drive_laws`).
        watch: called with the data before each step.

    Raises:
        InvalidInput: nothing has the name, or the actuator cannot follow a law; says what can.
    """
    every, asked = read_actuators(model), dict[str, tuple[TriedActuator | None, int | None, DriveLaw]]()
    data = copy.copy(start)
    with silence_warnings():
        mujoco.mj_forward(model, data)
    for name, text in drives.items():
        asked[name] = _parse_drive(model, data, every, name, text)
    followed = {n: (one, law) for n, (one, _, law) in asked.items() if one is not None and law.duration < math.inf}
    found = _run_with_laws(model, data, every, followed, watch) if followed else {}
    needed = _required_forces(
        model, data, {n: (joint, law) for n, (_, joint, law) in asked.items() if joint is not None}
    )
    return tuple(
        _add_required_force(model, every, name, asked[name], found.get(name), needed.get(name)) for name in asked
    )


def drives_of_joints(model: mujoco.MjModel, drives: Mapping[str, str]) -> dict[str, str]:
    """Laws by joint, from drives of joints or of their actuators; drives without a joint are dropped."""
    joints, found = names_of(model, "joint"), dict[str, str]()
    for name, law in drives.items():
        joint = next((one.joint for one in read_actuators(model) if one.name == name), None)
        if name in joints:
            found[name] = law
        elif joint is not None:
            found[name_or_number(model, "joint", joint)] = law
    return found


def _parse_drive(
    model: mujoco.MjModel, data: mujoco.MjData, every: list[TriedActuator], name: str, text: str
) -> tuple[TriedActuator | None, int | None, DriveLaw]:
    """Return the actuator that follows a law, the joint that it moves, and the law."""
    joints, actuators = names_of(model, "joint"), {one.name: one for one in every}
    if name in joints:
        joint = joints.index(name)
        if (kind := joint_kind(model, joint)) not in ("hinge", "slide"):
            raise InvalidInput(f"--drive {name}: it is a {kind} joint; hinges and slides are driven")
        servo = next((one for one in every if one.joint == joint and one.kind in SERVOS and not one.untried), None)
        unit = "m" if kind == "slide" else "rad"
        law = parse_drive_law(text, unit, float(data.qpos[model.jnt_qposadr[joint]]), name)
        return servo, joint, law
    if name not in actuators:
        raise unknown_choice("joint or actuator", name, [*filter(None, joints), *actuators])
    one = actuators[name]
    if one.untried or one.kind not in (*SERVOS, *SPEEDS):
        why = one.untried or f"it is a {one.kind}, whose control is no position and no speed"
        others = [n for n, other in actuators.items() if other.kind in (*SERVOS, *SPEEDS)]
        joint_words = f"; drive its joint: --drive {name_or_number(model, 'joint', one.joint)}={text}" if (
            one.joint is not None
        ) else ""  # fmt: skip
        raise InvalidInput(f"--drive {name}: {why}{joint_words}{f'; servos: {list_names(others)}' if others else ''}")
    law = parse_drive_law(text, one.unit, float(data.actuator_length[one.output]) / one.gear, name)
    _check_controls(model, one, law)
    return one, one.joint, law


def _check_controls(model: mujoco.MjModel, one: TriedActuator, law: DriveLaw) -> None:
    """Refuse a law that an actuator's controls cannot follow, as MuJoCo would clamp them."""
    if not model.actuator_ctrllimited[one.control] or law.duration == math.inf:
        return
    controls = _controls(one, law, np.linspace(0.0, law.duration, 1001))
    low, high = model.actuator_ctrlrange[one.control]
    slack = RANGE_ROUNDING * max(1.0, float(high - low))
    if controls.min() < low - slack or controls.max() > high + slack:
        raise InvalidInput(
            f"--drive {one.name}={law.text}: its control goes from {controls.min():.4g} to {controls.max():.4g}, and "
            f"MuJoCo clamps it to its ctrlrange, {low:g} to {high:g}"
        )


def _controls(one: TriedActuator, law: DriveLaw, times: Array) -> Array:
    """Controls (T,) that follow a law: by its coordinate for a position servo, its rate for a speed one."""
    coordinate, rate, *_ = law.derivatives(times)
    if one.kind in SERVOS:
        return np.asarray((one.stiffness * one.gear * coordinate - one.offset) / one.gain)
    per_control = one.gain / (one.gear * (one.stiffness if one.kind == "intvelocity" else one.damping))
    return np.asarray(rate / per_control)


def _run_seconds(law: DriveLaw) -> float:
    """Length of the run [s] for comparing a response with its law."""
    if law.text.startswith("sine:"):
        return PERIODS * law.duration
    return (1.0 + REST) * law.duration if law.text.startswith(("move:", "table:")) else law.duration


def _run_with_laws(
    model: mujoco.MjModel, start: mujoco.MjData, every: list[TriedActuator],
    followed: Mapping[str, tuple[TriedActuator, DriveLaw]], watch: Callable[[mujoco.MjData], object],
) -> dict[str, LawResponse]:  # fmt: skip
    """Run a model with controls that follow laws, watched before each step; return each response."""
    step, first = float(model.opt.timestep), next(iter(followed.values()))[0]
    made, held = held_model(model, first, every)
    data = copy.copy(start)
    data.qvel[np.isin(model.dof_jntid, held)] = 0.0
    for other in every:
        if other.holds_position and not other.untried and all(other is not one for one, _ in followed.values()):
            at = float(data.actuator_length[other.output]) / other.gear
            target = data.act if other.kind == "intvelocity" else data.ctrl
            target[other.activation if other.kind == "intvelocity" else other.control] = other.control_for(at)
    count = round(max(_run_seconds(law) for _, law in followed.values()) / step)
    if not 2 <= count <= MAX_STEPS:
        raise InvalidInput(f"its laws take {count} of its time steps of {step:g} s: 2 to {MAX_STEPS:,} can be run")
    times: Array = np.asarray(step * np.arange(count), dtype=float)
    controls = {name: _controls(one, law, times) for name, (one, law) in followed.items()}
    rows, broke, done = {name: np.empty((2, count)) for name in followed}, "", count
    with silence_warnings():
        for k in range(count):
            for name, (one, _) in followed.items():
                data.ctrl[one.control] = controls[name][k]
                if one.joint is not None:
                    dof = one.kind in SPEEDS
                    rows[name][0, k] = data.qvel[model.jnt_dofadr[one.joint]] if dof else data.qpos[
                        model.jnt_qposadr[one.joint]
                    ]  # fmt: skip
            watch(data)
            mujoco.mj_step(made, data)
            for name, (one, _) in followed.items():
                if one.joint is None:
                    source = data.actuator_velocity if one.kind in SPEEDS else data.actuator_length
                    rows[name][0, k] = source[one.output] / one.gear
                rows[name][1, k] = data.actuator_force[one.output]
            if k % 20 == 0 and (reason := break_off_reason(made, data)):
                broke, done = f"{reason} at {float(data.time):.3g} s", k + 1
                break
    return {
        name: _compare_with_law(name, one, law, times[:done], rows[name][:, :done], broke)
        for name, (one, law) in followed.items()
    }


def _compare_with_law(
    name: str, one: TriedActuator, law: DriveLaw, times: Array, rows: Array, broke: str
) -> LawResponse:
    """Compare a motion (T,) with its law: the last period of a sine, all of another law.

    The lag of a law u is the least-squares one, y(t) = u(t - lag): with e = y - u, lag = -sum(e u') / sum(u'^2). A sine
    of angular frequency w is fitted, y = c + a sin(w t) + b cos(w t); its lag is -atan2(b, a) / w.
    """
    speed = one.kind in SPEEDS
    unit, derivatives = f"{one.unit}/s" if speed else one.unit, law.derivatives(times)
    wanted, rate = derivatives[1 if speed else 0], derivatives[2 if speed else 1]
    result = LawResponse(name, law.text, one.drives, unit, float(times[-1]), broke=broke)
    if broke:
        return result
    sine = law.text.startswith("sine:")
    last = times >= times[-1] - law.duration if sine else times >= 0.0
    moved, off, gain = rows[0], rows[0] - wanted, None
    lag = -float(off[last] @ rate[last]) / max(float(rate[last] @ rate[last]), 1e-300)
    if sine:
        omega = 2.0 * math.pi / law.duration
        basis = np.column_stack([np.ones(int(last.sum())), np.sin(omega * times[last]), np.cos(omega * times[last])])
        (_, a, b), (_, c, d) = (np.linalg.lstsq(basis, y[last], rcond=None)[0] for y in (moved, wanted))
        gain = math.hypot(a, b) / max(math.hypot(c, d), 1e-300)
        lag = -math.remainder(math.atan2(b, a) - math.atan2(d, c), 2.0 * math.pi) / omega
    return replace(
        result, error=float(np.abs(off[last]).max()), end_error=float(off[-1]), gain=gain, lag=float(lag),
        size=float(np.ptp(wanted)) or float(np.abs(wanted).max()), peak=float(np.abs(rows[1]).max()),
    )  # fmt: skip


def _required_forces(
    model: mujoco.MjModel, start: mujoco.MjData, laws: Mapping[str, tuple[int, DriveLaw]]
) -> dict[str, float]:
    """Largest force [N or N m] at each driven joint along the laws, all others at rest, by inverse dynamics.

    Empty of a model with loops, whose forces this does not know, and for joints that laws hold.
    """
    moving = {name: (joint, law) for name, (joint, law) in laws.items() if law.duration < math.inf}
    if np.any(model.eq_active0) or not moving:
        return {}
    made = copy.copy(model)
    for flag in ("CONTACT", "LIMIT", "ACTUATION"):
        made.opt.disableflags |= compat.disable_bit(flag)
    times = np.linspace(0.0, max(law.duration for _, law in moving.values()), INSTANTS)
    data, largest = mujoco.MjData(made), dict.fromkeys(moving, 0.0)
    values = {name: law.derivatives(times) for name, (_, law) in laws.items() if name in moving}
    for k in range(INSTANTS):
        data.qpos[:], data.qvel[:], data.qacc[:] = start.qpos, 0.0, 0.0
        for name, (joint, _) in moving.items():
            dof = int(model.jnt_dofadr[joint])
            data.qpos[model.jnt_qposadr[joint]], data.qvel[dof], data.qacc[dof] = values[name][:3, k]
        with silence_warnings():
            mujoco.mj_inverse(made, data)
        for name, (joint, _) in moving.items():
            largest[name] = max(largest[name], abs(float(data.qfrc_inverse[model.jnt_dofadr[joint]])))
    return largest


def _add_required_force(
    model: mujoco.MjModel, every: list[TriedActuator], name: str,
    asked: tuple[TriedActuator | None, int | None, DriveLaw], response: LawResponse | None, needed: float | None,
) -> LawResponse:  # fmt: skip
    """Complete a response by the force that its law requires, and the force of its joint's actuators."""
    _, joint, law = asked
    if response is None:
        kind = "rad" if joint is None or joint_kind(model, joint) == "hinge" else "m"
        response = LawResponse(name, law.text, f"joint {name}", kind, follows=False)
    of_joint = [one for one in every if joint is not None and one.joint == joint and not one.untried]
    given = sum(one.limit * abs(one.gear) for one in of_joint)
    return replace(response, needed=needed, available=given if of_joint and math.isfinite(given) else None)
