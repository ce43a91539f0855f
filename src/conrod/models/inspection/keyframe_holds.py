"""Keyframes that are held: a model run from each keyframe with the keyframe's own controls."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.mjcf.driving import break_off_reason
from conrod.mjcf.loading import joint_kind, name_or_number, names_of, names_or_numbers
from conrod.models.inspection.actuator_kinds import TriedActuator, read_actuators
from conrod.models.inspection.moving_results import STAYS, KeyframeHold

SECONDS, MAX_STEPS = 1.0, 4000  # length of a run
MAX_KEYFRAMES = 8


def hold_keyframes(model: mujoco.MjModel) -> tuple[KeyframeHold, ...]:
    """Run a model from each keyframe that has nonzero controls, or from all if it has position servos."""
    every, found = [one for one in read_actuators(model) if not one.untried], list[KeyframeHold]()
    for k, name in enumerate(names_or_numbers(names_of(model, "key"))[:MAX_KEYFRAMES]):
        if np.any(model.key_ctrl[k]) or any(one.kind == "position" for one in every):
            found.append(_hold_keyframe(model, k, name, every))
    return tuple(found)


def _hold_keyframe(model: mujoco.MjModel, k: int, name: str, every: list[TriedActuator]) -> KeyframeHold:
    made, broke = copy.copy(model), ""
    made.opt.disableflags |= compat.disable_bit("AUTORESET")
    data = mujoco.MjData(made)
    mujoco.mj_resetDataKeyframe(made, data, k)
    with silence_warnings():
        mujoco.mj_forward(made, data)
        places, start, pulled = data.xpos.copy(), data.qpos.copy(), tuple(_displaced_servos(made, data, every))
        steps = max(2, min(MAX_STEPS, round(SECONDS / float(made.opt.timestep))))
        for done in range(steps):
            mujoco.mj_step(made, data)
            if (done % 20 == 0 or done == steps - 1) and (reason := break_off_reason(made, data)):
                broke = f"{reason} at {float(data.time):.3g} s"
                break
        mujoco.mj_kinematics(made, data)
    moved = 0.0 if broke else float(np.linalg.norm(data.xpos - places, axis=1).max())
    change = {j: float((data.qpos - start)[model.jnt_qposadr[j]]) for j in range(model.njnt)
              if joint_kind(model, j) in ("hinge", "slide")}  # fmt: skip
    worst = max(change, key=lambda j: abs(change[j]), default=None)
    joint, unit = ("", "rad") if worst is None else (
        name_or_number(model, "joint", worst), "m" if joint_kind(model, worst) == "slide" else "rad"
    )  # fmt: skip
    return KeyframeHold(
        name, steps * float(made.opt.timestep), bool(np.any(model.key_ctrl[k])), moved,
        moved / float(model.stat.extent), joint, 0.0 if worst is None or broke else change[worst], unit, pulled, broke,
    )  # fmt: skip


def _displaced_servos(model: mujoco.MjModel, data: mujoco.MjData, every: list[TriedActuator]) -> Iterator[str]:
    """Yield the names of position servos that are not where their command would have them."""
    for one in every:
        if one.kind == "position":
            control = data.ctrl[one.control] if one.activation is None else data.act[one.activation]
            at = float(data.actuator_length[one.output]) / one.gear
            size = 1.0 if one.unit == "rad" else float(model.stat.extent)
            if abs(one.value_for(float(control)) - at) > STAYS * size:
                yield one.name
