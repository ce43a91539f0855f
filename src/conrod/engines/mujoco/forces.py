"""Forces in a machine by MuJoCo's own account, at the states of a run.

The run is stepped as any other, by a flywheel of its own (`force_settings`), and the engine solves each of its states
again (`mj_forward`), so that state, accelerations and forces are of one instant.

Drive: a flywheel gives what it loses. A pin that closes a loop: the force of its equality. A joint of the tree: what
MuJoCo's recursive Newton-Euler algorithm tells of the link beyond it (`mj_rnePostConstraint`, `cfrc_int`). That knows
no actuators of sites and no fixed tendons, so constant forces and loads are given to it a second time, as forces on
bodies, after the accelerations are found; those along distances only to an engine that does not count them itself
(`spatial_tendons_count`). Contact: `mj_contactForce`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np

from conrod.engines.capabilities import ExpectedForces
from conrod.engines.engine import Machine
from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.mujoco.dynamics import advance
from conrod.engines.mujoco.law import LEFT_OUT, has_law, moved_states, predicted_gaps
from conrod.engines.mujoco.model import Build, build, laws_acting
from conrod.engines.numerics import NO_BOUND_AT_CHANGE_POINT
from conrod.engines.spanning_tree import Branch
from conrod.engines.tracks import EDITED_MODEL_REASON, ForceTracks, applied_forces, unreported_forces
from conrod.exact.dynamics.inverse import component_names, joint_forces_of_motion
from conrod.exact.motion import Array
from conrod.mechanism.loads import Distance
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Point, Prismatic, Revolute, to_world
from conrod.runs.outcome import judge
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, Outcome

Reader = Callable[[Array], Array]  # poses (3 n,) of the state that was solved -> components (2,)

EQUALITY = int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
# MuJoCo's Newton solver ends where its next correction of the accelerations is shorter than 1e-15 in SI units
# (mjMINVAL), whatever they are. With a run's flywheel and slow links its second one already is, and of what the first
# leaves closures with 1e-13 of their inertia as regularisation make 7e-3 of the drive torque (saw, 40 rpm). With less
# of a flywheel it goes on, but for single poses of slow links; there closures that are less hard lose less, and the
# state is solved a second time, see `_settle`.
LIGHTER = 1e-8
LEAST_HARDENING = 1e-6
SETTLED_ITERATIONS = 2  # of the solver: the first one leaves its own rounding, and the second removes that
WARM_SHIFT = 1e-9  # of the way to free links: far above mjMINVAL, and its rounding far below that of the whole way
LOOKS = 721  # for change points, over a turn
NO_DRIVE = "without a flywheel there is no drive"
ROLLING = "MuJoCo couples the joint coordinates of what rolls by a tendon: no force acts where the bodies meet"


def force_settings(settings: MuJoCoSettings) -> MuJoCoSettings:
    """Settings to measure forces with: a lighter flywheel, loops hardened no further than they bear, calm contact.

    The crank's speed then varies, by up to 1e-5 of itself as the flywheel is chosen, and is reported as it is. A
    contact that answers faster than an edge of the cam's polygon passes has a force that follows the edges (at 62832
    steps a turn, 4000 edges and a time constant of two steps the cam's is 2.7 % off, rms), so its time constant is
    raised to that time.
    """
    hardening = None if settings.hardening is None else max(settings.hardening, LEAST_HARDENING)
    constant, damping = settings.contact_solref
    if constant > 0.0:
        constant = max(constant, settings.timestep * settings.steps_per_revolution / settings.cam_vertices)
    return replace(
        settings, armature=LIGHTER * settings.armature, hardening=hardening, contact_solref=(constant, damping)
    )


def forces(machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float) -> ForceTracks:
    """Drive torque and reactions of a run at constant crank speed, at every step."""
    mechanism = machine.kinematics.mechanism
    for reason, holds in (
        (NO_DRIVE, settings.armature == 0.0), (EDITED_MODEL_REASON, settings.dressing), (ROLLING, mechanism.meshes)
    ):  # fmt: skip
        if holds:
            return unreported_forces(mechanism, reason)
    used, looks = force_settings(settings), np.linspace(*machine.kinematics.span, LOOKS)
    if machine.kinematics.near_change(looks, math.tau / LOOKS).any():
        # There softer closures do not bring a run past: with 1e-6 a parallelogram's crank is lost.
        used = replace(used, hardening=settings.hardening)
    made = build(machine, used)
    steps = round(used.steps_per_revolution * revolutions)
    times, states, _ = advance(made, machine, used, steps, start_angle)
    nq, nv = made.model.nq, made.model.nv
    coordinates, speeds = states[:, 1 : 1 + nq], states[:, 1 + nq : 1 + nq + nv]
    with np.errstate(all="ignore"):
        poses, rates = made.forward_kinematics(coordinates, speeds)
        where = Instants(times, coordinates[:, made.crank_coordinate], speeds[:, made.crank_dof], np.zeros(len(times)))
        kept = BodyStates(where, poses, rates, np.zeros_like(poses))
        verdict = judge(machine.kinematics, BodyTracks(kept, kept, kept), machine.speed)
    if verdict.outcome is not Outcome.COMPLETED:
        return unreported_forces(mechanism, verdict)
    with laws_acting(made.model, made.tree):
        acceleration, components = _Reading(made).read(times, coordinates, speeds, poses, rates)
    drive = -used.armature * acceleration
    return ForceTracks(replace(where, acceleration=acceleration), drive, components, {})


FORCE_LAW = "forces of the states and accelerations that the closures' predicted gaps leave"


def expected_forces(
    machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0
) -> ExpectedForces | None:
    """Forces at the states with the gaps that the law of the closures predicts; None where there is none.

    MuJoCo solves M q'' - Q = J^T lambda for the accelerations that its closures ask for, g'' of the gaps g they have,
    so that its forces are those that the state beside the exact one takes with these accelerations.
    """
    del revolutions  # the law follows a run until it repeats itself
    mechanism, kinematics = machine.kinematics.mechanism, machine.kinematics
    if mechanism.cam_contacts or mechanism.meshes or settings.armature == 0.0:
        return None
    if kinematics.change_angles.size:
        return ExpectedForces(None, 0.0, NO_BOUND_AT_CHANGE_POINT)
    used = force_settings(settings)
    if not has_law(used):
        return None
    course, _, gaps = predicted_gaps(machine, used, build(machine, used), start_angle)
    rate = abs(machine.speed)
    poses, rates, accelerations = (values * rate**k for k, values in enumerate(moved_states(course, gaps)))
    times = course.angles / machine.speed
    found = joint_forces_of_motion(kinematics, poses, rates, accelerations, times)
    rest = np.zeros_like(times)
    return ExpectedForces(
        ForceTracks(
            Instants(times, course.angles, rest + machine.speed, rest), found.drive_torque, found.components, {}
        ),
        LEFT_OUT,
        FORCE_LAW,
    )


@cache
def spatial_tendons_count() -> bool:
    """True where this version of MuJoCo counts the forces of spatial tendons in what its joints carry.

    MuJoCo 4.0.0 does; according to their documentation, earlier ones do not.
    """
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><site name="a"/><body pos="0 0 2"><joint type="slide"/><inertial pos="0 0 0" mass="1" '
        'diaginertia="1 1 1"/><site name="b"/></body></worldbody><tendon><spatial stiffness="1" springlength="1">'
        '<site site="a"/><site site="b"/></spatial></tendon></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    return bool(abs(data.cfrc_ext[1, 5]) > 0.5)


def _settle(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Solve a state once more where the solver ended after its first iteration.

    A closure's force is D (aref - J qacc) with D = 1 / R, 1e8 and more where it is hardened, so an error of 1e-15 in
    the accelerations is 1e-7 N: little beside the pins' forces, and 1e-3 of the moment that a light slide carries. The
    solver does not correct it, being shorter than mjMINVAL; it does where it begins a little beside the solution.
    """
    if int(data.solver_niter[0]) < SETTLED_ITERATIONS:
        data.qacc_warmstart[:] = data.qacc + WARM_SHIFT * (data.qacc_smooth - data.qacc)
        mujoco.mj_fwdConstraint(model, data)


class _Reading:
    """Reading of the crank and of all joints, state by state."""

    def __init__(self, made: Build) -> None:
        self._made, self._model, self._data = made, made.model, mujoco.MjData(made.model)
        self._mechanism = made.tree.mechanism
        uncounted_loads = [
            x for x in self._mechanism.loads if not (isinstance(x.along, Distance) and spatial_tendons_count())
        ]
        self._uncounted = replace(self._mechanism, loads=tuple(uncounted_loads))
        # Names are looked up once: in a model with a large mesh that takes longer than a step.
        self._bodies = [int(made.model.body(body.name).id) for body in self._mechanism.bodies]
        branches = {branch.joint.name: branch for branch in made.tree.branches}
        self._readers = {joint.name: self._reader(joint, branches) for joint in self._mechanism.joints}

    def read(
        self, times: Array, coordinates: Array, speeds: Array, poses: Array, rates: Array
    ) -> tuple[Array, dict[str, dict[str, Array]]]:
        """Solve every state, (T, ..) each: acceleration of the crank and components of all joints, by name."""
        model, data, crank = self._model, self._data, self._made.crank_dof
        acceleration = np.zeros(len(times))
        components = {name: np.zeros((len(times), 2)) for name in self._readers}
        pushes = applied_forces(self._uncounted, poses, rates, times)
        for k, time in enumerate(times):
            data.time, data.qpos[:], data.qvel[:] = time, coordinates[k], speeds[k]
            data.qacc_warmstart[:] = 0.0  # the solution of a state depends on it alone
            mujoco.mj_forward(model, data)
            _settle(model, data)
            acceleration[k] = data.qacc[crank]
            data.xfrc_applied[self._bodies, :2] = pushes[k, :, :2]
            data.xfrc_applied[self._bodies, 5] = pushes[k, :, 2]
            mujoco.mj_rnePostConstraint(model, data)
            data.xfrc_applied[:] = 0.0
            for name, reader in self._readers.items():
                components[name][k] = reader(poses[k])
        return acceleration, {
            joint.name: dict(zip(component_names(joint), components[joint.name].T, strict=False))
            for joint in self._mechanism.joints
        }

    def _reader(self, joint: Joint, branches: dict[str, Branch]) -> Reader:
        """Reader of the components of a joint in solved data."""
        match joint:
            case CamContact():
                return self._pusher(joint)
            case Revolute() if joint.name not in branches:
                return self._holder(joint)
            case Revolute() | Prismatic():
                return self._carrier(joint, branches[joint.name])
            case _:
                raise TypeError(f"{joint.name!r} rolls")

    def _holder(self, joint: Revolute) -> Reader:
        """Of a pin that closes a loop."""
        data, equality = self._data, int(self._model.equality(joint.name).id)

        def read(_: Array) -> Array:
            row = int(np.argmax((data.efc_id == equality) & (data.efc_type == EQUALITY)))
            # A connect holds the first body against the second one with this force on the first.
            return np.asarray(-data.efc_force[row : row + 2])

        return read

    def _carrier(self, joint: Revolute | Prismatic, branch: Branch) -> Reader:
        """Of a joint of the tree: what its parent gives its child, reported on the joint's second body."""
        data, child = self._data, int(self._model.body(branch.child).id)
        sense, root = (1.0 if branch.child == joint.b else -1.0), int(self._model.body_rootid[child])
        if isinstance(joint, Revolute):
            return lambda _: np.asarray(sense * data.cfrc_int[child, 3:5])

        def read(poses: Array) -> Array:
            moment, fx, fy = sense * data.cfrc_int[child, 2:5]
            # MuJoCo reports the moment about the centre of gravity of the whole tree, a joint has it about its point.
            x, y = data.subtree_com[root, :2] - self._place(joint.b, joint.point_b, poses)
            turn = joint.direction + self._pose(joint.a, poses)[2]
            return np.array([np.cos(turn) * fy - np.sin(turn) * fx, moment + x * fy - y * fx])

        return read

    def _pusher(self, joint: CamContact) -> Reader:
        """Push between cam and roller; 0 where they do not touch."""
        model, data, wrench = self._model, self._data, np.zeros(6)
        pair = sorted(self._made.geoms(joint))

        def read(_: Array) -> Array:
            total = 0.0
            for k in np.flatnonzero((np.sort(data.contact.geom, axis=1) == pair).all(axis=1)):
                mujoco.mj_contactForce(model, data, int(k), wrench)
                total += float(wrench[0])
            return np.array([total, 0.0])

        return read

    def _pose(self, body: str, poses: Array) -> Array:
        if body == GROUND:
            return np.zeros(3)
        i = 3 * self._mechanism.body_index[body]
        return np.asarray(poses[i : i + 3])

    def _place(self, body: str, point: Point, poses: Array) -> Array:
        x, y, phi = self._pose(body, poses)
        return np.array(to_world((x, y, phi), point))
