"""What the actuators of a compiled model are: their kinds, what they act on, gains and ranges."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.loading import joint_kind, name_or_number

MAX_TURN = math.pi  # [rad] to each side of the start, of a hinge that no range bounds more
DEFAULT_TURN, DEFAULT_SHARE = math.pi / 4.0, 0.1  # move to each side without any range [rad], and share of the extent
JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
OF = {mujoco.mjtTrn.mjTRN_TENDON: "tendon", mujoco.mjtTrn.mjTRN_SITE: "site", mujoco.mjtTrn.mjTRN_SLIDERCRANK: "site"}
UNTRIED = {
    mujoco.mjtTrn.mjTRN_BODY: "it presses contacts of its body, and moves no joint",
    "outputs": "it has several controls or forces",
    "joint": "it acts on a joint of more than one freedom",
    "plugin": "its force is a plugin's or a callback's",
    "group": "its group is switched off",
    "free": "what it moves is not determined by its length",
}


@dataclass(frozen=True, eq=False)
class TriedActuator:
    """An actuator of a compiled model, in its joint's coordinate, or in its length without a joint.

    The force before the gear is gain u + offset - kp length - kd rate, with length = gear times the coordinate.

    Attributes:
        number, control, output: indices of the actuator, of its control and of its force.
        unit: rad or m.
        gear: length over coordinate.
        joint: the joint that it acts on; None for tendons and sites.
        gain, offset: force by unit control, and without control [N or N m].
        stiffness, damping: kp [N/m or N m/rad] and kd [N s/m or N m s/rad] of its length.
        delay: time constant of its activation [s]; 0 without.
        activation: index of its activation; None where it has none.
        limit: largest force to either side; infinite without one.
        untried: why it cannot be tried, in words; empty if it can.
    """

    number: int
    name: str
    kind: str
    control: int
    output: int
    drives: str
    unit: str
    gear: float
    joint: int | None
    gain: float
    offset: float
    stiffness: float
    damping: float
    delay: float
    activation: int | None
    limit: float
    untried: str = ""

    @property
    def holds_position(self) -> bool:
        """True if the actuator is a servo that holds a position."""
        return self.kind in ("position", "intvelocity")

    def control_for(self, value: float) -> float:
        """Return the control (or activation) that commands a servo to a value of its coordinate."""
        return (self.stiffness * self.gear * value - self.offset) / self.gain

    def value_for(self, control: float) -> float:
        """Return the value of its coordinate that a control (or activation) commands a servo to."""
        return (self.gain * control + self.offset) / (self.stiffness * self.gear)


def read_actuators(model: mujoco.MjModel) -> list[TriedActuator]:
    """Read all actuators of a model, in order."""
    return [_read_actuator(model, k) for k in range(len(model.actuator_trntype))]


def _read_actuator(model: mujoco.MjModel, k: int) -> TriedActuator:
    transmission, dynamics = mujoco.mjtTrn(model.actuator_trntype[k]), mujoco.mjtDyn(model.actuator_dyntype[k])
    control, output = (_address(model, f"actuator_{what}adr", k) for what in ("ctrl", "out"))
    joint = int(model.actuator_trnid[k, 0]) if transmission in JOINTS else None
    gear = float(model.actuator_gear[output, 0]) if joint is not None else 1.0
    gain, bias = np.array(model.actuator_gainprm[k]), np.array(model.actuator_biasprm[k])
    affine = model.actuator_biastype[k] == int(mujoco.mjtBias.mjBIAS_AFFINE)
    offset, stiffness, damping = (bias[0], -bias[1], -bias[2]) if affine else (0.0, 0.0, 0.0)
    filters = (mujoco.mjtDyn.mjDYN_FILTER, mujoco.mjtDyn.mjDYN_FILTEREXACT, mujoco.mjtDyn.mjDYN_MUSCLE)
    delay = float(model.actuator_dynprm[k, 0]) if dynamics in filters else 0.0
    activation = int(model.actuator_actadr[k]) if model.actuator_actadr[k] >= 0 else None
    kind = _actuator_kind(model, k, float(stiffness), float(damping))
    return TriedActuator(
        k, name_or_number(model, "actuator", k), kind, control, output,
        _transmission_words(model, k, transmission, joint),
        _coordinate_unit(model, k, output, transmission, joint), gear or 1.0, joint, float(gain[0]), float(offset),
        float(stiffness), float(damping), delay, activation, _force_limit(model, k, joint, gear),
        _untried_reason(model, k, transmission, joint, kind),
    )  # fmt: skip


def _address(model: mujoco.MjModel, field: str, k: int) -> int:
    """Index of an actuator's first control or force; before MuJoCo 4 each has one of both."""
    addresses = getattr(model, field, None)
    return k if addresses is None else int(addresses[k])


def _actuator_kind(model: mujoco.MjModel, k: int, stiffness: float, damping: float) -> str:
    """Classify an actuator by its gain, bias and dynamics; kinds are named after MJCF's shortcuts."""
    gain, dynamics = mujoco.mjtGain(model.actuator_gaintype[k]), mujoco.mjtDyn(model.actuator_dyntype[k])
    if mujoco.mjtTrn(model.actuator_trntype[k]) == mujoco.mjtTrn.mjTRN_BODY:
        return "adhesion"
    if gain != mujoco.mjtGain.mjGAIN_FIXED:
        of_rate = gain == mujoco.mjtGain.mjGAIN_AFFINE and model.actuator_gainprm[k, 2] < 0.0
        known = gain.name.removeprefix("mjGAIN_").lower()
        return "damper" if of_rate and not stiffness else "general" if known == "affine" else known
    if stiffness > 0.0:
        return "intvelocity" if dynamics == mujoco.mjtDyn.mjDYN_INTEGRATOR else "position"
    if damping > 0.0 and dynamics == mujoco.mjtDyn.mjDYN_NONE:
        return "velocity" if abs(float(model.actuator_gainprm[k, 0]) - damping) <= 1e-6 * damping else "general"
    if dynamics == mujoco.mjtDyn.mjDYN_NONE:
        return "motor"
    return "cylinder" if dynamics == mujoco.mjtDyn.mjDYN_FILTER else "general"


def _transmission_words(model: mujoco.MjModel, k: int, transmission: mujoco.mjtTrn, joint: int | None) -> str:
    """Name the driven object of an actuator, such as 'joint crank'."""
    kind = "joint" if joint is not None else OF.get(transmission, "body")
    name = name_or_number(model, kind, int(model.actuator_trnid[k, 0]))
    return name if name.startswith(f"{kind} ") else f"{kind} {name}"


def _coordinate_unit(model: mujoco.MjModel, k: int, output: int, transmission: mujoco.mjtTrn, joint: int | None) -> str:
    if joint is not None:
        return "m" if joint_kind(model, joint) == "slide" else "rad"
    if transmission == mujoco.mjtTrn.mjTRN_TENDON:
        tendon = int(model.actuator_trnid[k, 0])
        wraps = slice(int(model.tendon_adr[tendon]), int(model.tendon_adr[tendon] + model.tendon_num[tendon]))
        of_joints = model.wrap_type[wraps] == int(mujoco.mjtWrap.mjWRAP_JOINT)
        hinges = model.jnt_type[model.wrap_objid[wraps][of_joints]] == int(mujoco.mjtJoint.mjJNT_HINGE)
        return "rad" if of_joints.all() and hinges.all() else "m"
    return "rad" if np.any(model.actuator_gear[output, 3:]) and not np.any(model.actuator_gear[output, :3]) else "m"


def _force_limit(model: mujoco.MjModel, k: int, joint: int | None, gear: float) -> float:
    """Largest force of an actuator in its weaker direction, by its ranges and its joint's limit."""
    found = [math.inf]
    if model.actuator_forcelimited[k]:
        found.append(float(np.abs(model.actuator_forcerange[k]).min() or np.abs(model.actuator_forcerange[k]).max()))
    if joint is not None and model.jnt_actfrclimited[joint] and gear:
        found.append(float(np.abs(model.jnt_actfrcrange[joint]).min()) / abs(gear))
    if model.actuator_gaintype[k] == int(mujoco.mjtGain.mjGAIN_FIXED) and not model.actuator_biastype[k]:
        control = _address(model, "actuator_ctrladr", k)
        if model.actuator_ctrllimited[control]:
            found.append(
                abs(float(model.actuator_gainprm[k, 0])) * float(np.abs(model.actuator_ctrlrange[control]).max())
            )
    return min(found)


def _untried_reason(model: mujoco.MjModel, k: int, transmission: mujoco.mjtTrn, joint: int | None, kind: str) -> str:
    """Say why an actuator cannot be tried; empty if it can."""
    numbers = (getattr(model, f"actuator_{what}num", None) for what in ("ctrl", "out"))
    group = int(model.actuator_group[k])
    if transmission in UNTRIED:
        return UNTRIED[transmission]
    if any(number is not None and int(number[k]) != 1 for number in numbers):
        return UNTRIED["outputs"]
    if joint is not None and joint_kind(model, joint) not in ("hinge", "slide"):
        return UNTRIED["joint"]
    if model.actuator_plugin[k] >= 0 or kind == "user":
        return UNTRIED["plugin"]
    if 0 <= group < 31 and model.opt.disableactuator & (1 << group):
        return UNTRIED["group"]
    return ""


def value_range(
    model: mujoco.MjModel, one: TriedActuator, start: float, extent: float
) -> tuple[tuple[float, float], str]:
    """Range of a servo's coordinate for its trial, and its origin in words (empty: the model file).

    Args:
        start: value of its coordinate at the start.
        extent: size of the model [m].
    """
    low, high, known = -math.inf, math.inf, False
    if one.holds_position and one.kind != "intvelocity" and model.actuator_ctrllimited[one.control]:
        ends = sorted(one.value_for(float(end)) for end in model.actuator_ctrlrange[one.control])
        low, high, known = ends[0], ends[1], True
    if one.kind == "intvelocity" and model.actuator_actlimited[one.number]:
        ends = sorted(one.value_for(float(end)) for end in model.actuator_actrange[one.number])
        low, high, known = ends[0], ends[1], True
    limits: Array | None = None
    if one.joint is not None and model.jnt_limited[one.joint]:
        limits = model.jnt_range[one.joint]
    elif one.drives.startswith("tendon") and model.tendon_limited[model.actuator_trnid[one.number, 0]]:
        limits = model.tendon_range[model.actuator_trnid[one.number, 0]]
    if limits is not None and max(low, float(limits[0])) < min(high, float(limits[1])):
        low, high, known = max(low, float(limits[0])), min(high, float(limits[1])), True
    if known and one.unit == "rad" and high - low > 2.0 * MAX_TURN:
        low, high = max(low, start - MAX_TURN), min(high, start + MAX_TURN)
    if known and low < high:
        return (low, high), ""
    size = DEFAULT_TURN if one.unit == "rad" else DEFAULT_SHARE * extent
    return (start - size, start + size), "neither control nor joint has a range"
