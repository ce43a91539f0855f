"""Runs of a model with one of its actuators commanded, the others held where they are."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.engines.mujoco.compiled_edits import set_armature
from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.engines.mujoco.model import constraint_jacobian, equality_jacobian
from conrod.exact.motion import Array
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.mjcf.driving import break_off_reason
from conrod.mjcf.force_watch import geom_name
from conrod.mjcf.loading import joint_kind, name_or_number
from conrod.models.inspection.actuator_kinds import TriedActuator

HOLDING_RATIO = 1e6  # of the armature of a joint that is held still, over the inertia of the whole model
STEPS_BETWEEN_CHECKS = 16
RUNAWAY = 1e3  # displacement over the range that a run is meant for, from which on it has run away
OBSTACLE_SHARE = 0.1  # of the actuator's force, that a contact or limit bears at least to be in the way


@dataclass(frozen=True, eq=False)
class TrialBench:
    """A model ready for the trial of an actuator, at its start.

    Attributes:
        model: copy of the model, with joints held still that nothing else would hold.
        data: start, with the controls that hold it.
        direction: motion (nv,) of all joints for a unit rate of the actuator's coordinate.
        inertia: inertia along it [kg m^2 or kg].
        load: force [N or N m] at the actuator's coordinate that holds the start against weight and springs.
        held: names of the held joints.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    actuator: TriedActuator
    direction: Array
    inertia: float
    load: float
    held: tuple[str, ...]

    def value(self, data: mujoco.MjData) -> float:
        """Value of the actuator's coordinate [rad or m]."""
        if (joint := self.actuator.joint) is not None:
            return float(data.qpos[self.model.jnt_qposadr[joint]])
        return float(data.actuator_length[self.actuator.output])

    @property
    def start(self) -> float:
        """Value of the actuator's coordinate at the start [rad or m]."""
        return self.value(self.data)

    @property
    def step(self) -> float:
        """Time step [s]."""
        return float(self.model.opt.timestep)


def prepare_trial(
    model: mujoco.MjModel,
    start: mujoco.MjData,
    one: TriedActuator,
    every: Iterable[TriedActuator],
    *,
    hold: bool = True,
) -> TrialBench:
    """Prepare a model for the trial of an actuator.

    The other servos hold what they hold at the start. A joint that another force drives, and that no loop ties to
    others, is held still, as is a floating base: nothing else would hold them. Without `hold` none is.
    """
    data = copy.copy(start)
    made, held = held_model(model, one, every, hold=hold)
    fresh = mujoco.MjData(made)
    size_of_state = mujoco.mj_stateSize(made, mujoco.mjtState.mjSTATE_INTEGRATION)
    state = np.empty(size_of_state)
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    mujoco.mj_setState(made, fresh, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    fresh.qvel[:] = 0.0
    with silence_warnings():
        mujoco.mj_forward(made, fresh)
        _hold_servos(made, fresh, every)
        mujoco.mj_forward(made, fresh)
    direction, inertia = actuated_direction(made, fresh, one)
    load = float(direction @ (fresh.qfrc_bias - fresh.qfrc_passive)) if inertia else 0.0
    return TrialBench(
        made, fresh, one, direction, inertia, load, tuple(name_or_number(model, "joint", j) for j in held)
    )


def held_model(
    model: mujoco.MjModel, one: TriedActuator, every: Iterable[TriedActuator], *, hold: bool = True
) -> tuple[mujoco.MjModel, list[int]]:
    """Copy a model for runs of an actuator, with joints held still that nothing else holds; name these joints."""
    made, held = copy.copy(model), _joints_to_hold(model, one, every) if hold else []
    made.opt.disableflags |= compat.disable_bit("AUTORESET")
    if held:
        dofs = np.flatnonzero(np.isin(model.dof_jntid, held))
        size = float(model.body_mass.sum()) * max(float(model.stat.extent), 1e-6) ** 2
        set_armature(made, dofs.tolist(), HOLDING_RATIO * max(size, float(model.dof_M0.max(initial=1e-9))))
    return made, held


def _joints_to_hold(model: mujoco.MjModel, one: TriedActuator, every: Iterable[TriedActuator]) -> list[int]:
    """Joints to hold in a trial: floating bases and, without loops, joints of other force actuators."""
    found = [j for j in range(model.njnt) if joint_kind(model, j) == "free" and _carries_joints(model, j)]
    if np.any(model.eq_active0):
        return found
    servos = {other.joint for other in every if other.holds_position and not other.untried}
    forces = {other.joint for other in every if not other.holds_position and other.joint is not None}
    return found + sorted(j for j in forces - servos - {one.joint, None} if j is not None and j not in found)


def _carries_joints(model: mujoco.MjModel, joint: int) -> bool:
    """True if other bodies of the same kinematic tree as a joint's body have joints."""
    base = int(model.jnt_bodyid[joint])
    below = np.flatnonzero(model.body_rootid == model.body_rootid[base])
    return any(model.body_jntnum[body] and body != base for body in below.tolist())


def _hold_servos(model: mujoco.MjModel, data: mujoco.MjData, every: Iterable[TriedActuator]) -> None:
    """Command all servos to their present positions, and all other actuators to no force."""
    for other in every:
        if other.untried:
            continue
        data.ctrl[other.control] = 0.0
        if other.holds_position:
            at = float(data.actuator_length[other.output]) / other.gear
            set_command(model, data, other, at)


def set_command(model: mujoco.MjModel, data: mujoco.MjData, one: TriedActuator, value: float) -> None:
    """Command a servo to hold a value of its coordinate, and set its activation to match."""
    control = one.control_for(value)
    if one.kind != "intvelocity" and model.actuator_ctrllimited[one.control]:
        control = float(np.clip(control, *model.actuator_ctrlrange[one.control]))
    if one.kind == "intvelocity":
        data.act[one.activation] = control
        return
    data.ctrl[one.control] = control
    if one.activation is not None:
        data.act[one.activation] = control


def moment(model: mujoco.MjModel, data: mujoco.MjData, one: TriedActuator) -> Array:
    """Derivatives (nv,) of an actuator's coordinate's rate by the rates of all joints."""
    start, size = int(data.moment_rowadr[one.output]), int(data.moment_rownnz[one.output])
    row = np.zeros(model.nv)
    row[data.moment_colind[start : start + size]] = data.actuator_moment[start : start + size]
    return row / one.gear


def free_motions(model: mujoco.MjModel, jacobian: Array) -> Array:
    """Basis (nv, k) of the rates that closures with a Jacobian (rows, nv) allow."""
    if not jacobian.size or not np.any(jacobian):
        return np.eye(model.nv)
    _, values, right = np.linalg.svd(jacobian)
    return np.asarray(right[int(np.sum(values > RANK_TOLERANCE * values[0])) :].T)


def actuated_direction(model: mujoco.MjModel, data: mujoco.MjData, one: TriedActuator) -> tuple[Array, float]:
    """Motion (nv,) for a unit rate of an actuator's coordinate when it alone pushes, and the inertia along it.

    With p the moment, N the motions that closures allow and M the mass matrix: n = N w / p'N w, w = (N'MN)^-1 N'p, and
    the inertia is 1 / p'N w. Both are 0 where the actuator cannot move anything.
    """
    row, basis = moment(model, data, one), free_motions(model, equality_jacobian(model, data))
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    pushed = basis.T @ row
    if not basis.shape[1] or np.abs(pushed).max(initial=0.0) <= 1e-9 * max(np.abs(row).max(initial=0.0), 1e-300):
        return np.zeros(model.nv), 0.0
    response = basis @ np.linalg.solve(basis.T @ mass @ basis, pushed)
    compliance = float(row @ response)
    return (response / compliance, 1.0 / compliance) if compliance > 0.0 else (np.zeros(model.nv), 0.0)


@dataclass(frozen=True, eq=False)
class TrialRun:
    """Values, rates and forces (T,) of an actuator at each step of a run, and why it broke off."""

    values: Array
    rates: Array
    forces: Array
    broke: str


def run_trial(
    bench: TrialBench, data: mujoco.MjData, steps: int, span: float, act: Callable[[int], None] | None = None
) -> TrialRun:
    """Advance data by some steps; record the actuator's coordinate, rate and force at each step.

    Args:
        span: range of the coordinate that the run is meant for [rad or m]; far beyond it the run has run away.
        act: called with the number of each step before it is made.
    """
    model, one, broke = bench.model, bench.actuator, ""
    joint, gear = one.joint, one.gear
    place, dof = (int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])) if joint is not None else (-1, -1)
    rows, qpos, qvel = np.empty((3, steps)), data.qpos, data.qvel
    lengths, speeds, forces, output, first = (
        data.actuator_length, data.actuator_velocity, data.actuator_force, one.output, bench.start,
    )  # fmt: skip
    done = steps
    with silence_warnings():
        for k in range(steps):
            if act is not None:
                act(k)
            if joint is not None:
                rows[0, k], rows[1, k] = qpos[place], qvel[dof]
            mujoco.mj_step(model, data)
            if joint is None:
                rows[0, k], rows[1, k] = lengths[output] / gear, speeds[output] / gear
            rows[2, k] = forces[output]
            if k % STEPS_BETWEEN_CHECKS == 0 or k == steps - 1:
                if broke := break_off_reason(model, data):
                    broke = f"{broke} at {quantity_of_time(data.time)}"
                elif abs(rows[0, k] - first) > RUNAWAY * span:
                    broke = f"runs away by {quantity_of_time(data.time)}"
                if broke:
                    done = k + 1
                    break
    return TrialRun(rows[0, :done], rows[1, :done], rows[2, :done], broke)


def quantity_of_time(seconds: float) -> str:
    """Return a time in words, such as '0.12 s'."""
    return f"{seconds:.3g} s"


def obstacles(bench: TrialBench, data: mujoco.MjData) -> tuple[str, ...]:
    """Limits and contacts that bear a notable part of an actuator's force, by name."""
    model, one = bench.model, bench.actuator
    with silence_warnings():
        mujoco.mj_forward(model, data)
    rows = np.arange(data.ne, data.nefc)
    if not len(rows):
        return ()
    direction, inertia = actuated_direction(model, data, one)
    borne = (
        (constraint_jacobian(model, data)[rows] @ direction) * data.efc_force[rows] if inertia else np.zeros(len(rows))
    )
    least, found = OBSTACLE_SHARE * abs(float(data.actuator_force[one.output]) * one.gear), dict[str, float]()
    for row, share in zip(rows.tolist(), borne.tolist(), strict=True):
        name = _row_name(model, data, row)
        found[name] = found.get(name, 0.0) + share
    return tuple(name for name, share in found.items() if abs(share) > max(least, 1e-9))


def _row_name(model: mujoco.MjModel, data: mujoco.MjData, row: int) -> str:
    """Name of the limit, friction or contact that a constraint row belongs to."""
    kind, owner = mujoco.mjtConstraint(data.efc_type[row]), int(data.efc_id[row])
    match kind:
        case mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT:
            return f"the range of joint {name_or_number(model, 'joint', owner)}"
        case mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON:
            return f"the range of tendon {name_or_number(model, 'tendon', owner)}"
        case mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF:
            return f"dry friction of joint {name_or_number(model, 'joint', int(model.dof_jntid[owner]))}"
        case mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON:
            return f"dry friction of tendon {name_or_number(model, 'tendon', owner)}"
    geoms = [int(geom) for geom in data.contact.geom[owner]]
    return f"contact of {' and '.join(sorted(geom_name(model, geom) for geom in geoms))}"
