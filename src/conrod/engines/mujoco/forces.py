"""Forces in a machine as MuJoCo computes them, at the states of a run.

The run is stepped with a lighter flywheel (`force_settings`), and the engine solves each of its states again
(`mj_forward`), so that state, accelerations and forces belong to one instant.

Drive: a flywheel gives what it loses. A pin that closes a loop: the force of its equality. A joint of the tree: the
force on the link beyond it by MuJoCo's recursive Newton-Euler algorithm (`mj_rnePostConstraint`, `cfrc_int`). That
algorithm ignores actuators on sites and fixed tendons, so constant forces and loads are passed to it a second time, as
forces on bodies, after the accelerations are found; those along distances only to releases that do not count spatial
tendons (`spatial_tendons_count`). Contact: `mj_contactForce`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from conrod.comparison.outcome import judge_outcome
from conrod.comparison.trajectory import BodyStates, BodyTracks, Outcome
from conrod.engines.capabilities import ExpectedForces
from conrod.engines.engine import DeferredLibrary, Machine
from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.mujoco.dynamics import simulate
from conrod.engines.mujoco.error_bound import PREDICTION_MARGIN, has_error_law, predicted_gaps, states_with_gaps
from conrod.engines.mujoco.model import MuJoCoModel, apply_load_laws, build
from conrod.engines.numerics import NO_BOUND_AT_CHANGE_POINT
from conrod.engines.spanning_tree import Branch
from conrod.engines.tracks import EDITED_MODEL_REASON, ForceTracks, applied_forces, unreported_forces
from conrod.exact.dynamics.inverse import component_names, joint_forces_of_motion
from conrod.exact.motion import Array, Instants
from conrod.mechanism.loads import Distance
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Point, Prismatic, Revolute, to_world

if TYPE_CHECKING:
    import mujoco
else:
    mujoco = DeferredLibrary("mujoco")

Reader = Callable[[Array], Array]  # poses (3 n,) of the state that was solved -> components (2,)

# MuJoCo's Newton solver stops when its next correction of the accelerations is shorter than 1e-15 in SI units
# (mjMINVAL), whatever their size. With a run's flywheel and slow links the second correction is; the residual of the
# first, in closures with a regularisation of 1e-13 of their inertia, makes 7e-3 of the drive torque (saw, 40 rpm). With
# a lighter flywheel the solver goes on, except at single poses of slow links; there less hardened closures lose less,
# and the state is solved a second time, see `_iterate_again`.
FORCE_ARMATURE_FACTOR = 1e-8
MIN_FORCE_HARDENING = 1e-6
MIN_SOLVER_ITERATIONS = 2  # the second one removes the rounding of the first
# Of the difference to unconstrained accelerations: far above mjMINVAL, with rounding far below that of the difference.
WARM_START_SHIFT = 1e-9
CHANGE_POINT_SAMPLES = 721  # crank angles over a revolution at which change points are looked for
NO_DRIVE_REASON = "without a flywheel there is no drive"
ROLLING_REASON = "MuJoCo couples the joint coordinates of what rolls by a tendon: no force acts where the bodies meet"


def force_settings(settings: MuJoCoSettings) -> MuJoCoSettings:
    """Settings to measure forces with: lighter flywheel, less hardening, and no faster contact than facets pass.

    The crank's speed then varies, by up to 1e-5 of itself with the flywheel as chosen, and is reported as it is. A
    contact that responds faster than facets of the cam's polygon pass has a force that follows the facets (2.7 % rms at
    62832 steps per revolution, 4000 facets and a time constant of two steps), so its time constant is raised to that of
    a facet.
    """
    hardening = None if settings.hardening is None else max(settings.hardening, MIN_FORCE_HARDENING)
    constant, damping = settings.contact_solref
    if constant > 0.0:
        constant = max(constant, settings.timestep * settings.steps_per_revolution / settings.cam_vertices)
    return replace(
        settings,
        armature=FORCE_ARMATURE_FACTOR * settings.armature,
        hardening=hardening,
        contact_solref=(constant, damping),
    )


def forces(machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float) -> ForceTracks:
    """Drive torque and reactions of a run at constant crank speed, at every step."""
    mechanism = machine.kinematics.mechanism
    if settings.armature == 0.0:
        return unreported_forces(mechanism, NO_DRIVE_REASON)
    if settings.dressing:
        return unreported_forces(mechanism, EDITED_MODEL_REASON)
    if mechanism.meshes:
        return unreported_forces(mechanism, ROLLING_REASON)
    used, looks = force_settings(settings), np.linspace(*machine.kinematics.span, CHANGE_POINT_SAMPLES)
    if machine.kinematics.near_change(looks, math.tau / CHANGE_POINT_SAMPLES).any():
        # There softer closures do not bring a run past: with 1e-6 a parallelogram's crank is lost.
        used = replace(used, hardening=settings.hardening)
    made = build(machine, used)
    steps = round(used.steps_per_revolution * revolutions)
    times, states, _ = simulate(made, machine, used, steps, start_angle)
    nq, nv = made.model.nq, made.model.nv
    coordinates, speeds = states[:, 1 : 1 + nq], states[:, 1 + nq : 1 + nq + nv]
    with np.errstate(all="ignore"):
        poses, rates = made.forward_kinematics(coordinates, speeds)
        where = Instants(times, coordinates[:, made.crank_coordinate], speeds[:, made.crank_dof], np.zeros(len(times)))
        kept = BodyStates(where, poses, rates, np.zeros_like(poses))
        verdict = judge_outcome(machine.kinematics, BodyTracks(kept, kept, kept), machine.speed)
    if verdict.outcome is not Outcome.COMPLETED:
        return unreported_forces(mechanism, verdict)
    with apply_load_laws(made.model, made.tree):
        acceleration, components = _ForceReader(made).solve_states(times, coordinates, speeds, poses, rates)
    drive = -used.armature * acceleration
    return ForceTracks(replace(where, acceleration=acceleration), drive, components, {})


FORCE_LAW = "forces of the states and accelerations that the closures' predicted gaps leave"


def expected_forces(
    machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0
) -> ExpectedForces | None:
    """Forces at states with the gaps that the error law predicts; None without an error law.

    MuJoCo solves M q'' - Q = J' lambda for the accelerations that its closures prescribe, g'' of the gaps g they have,
    so its forces are those of the state with gaps at these accelerations.
    """
    del revolutions  # the law follows a run until it repeats itself
    mechanism, kinematics = machine.kinematics.mechanism, machine.kinematics
    if mechanism.cam_contacts or mechanism.meshes or settings.armature == 0.0:
        return None
    if kinematics.change_angles.size:
        return ExpectedForces(None, 0.0, NO_BOUND_AT_CHANGE_POINT)
    used = force_settings(settings)
    if not has_error_law(used):
        return None
    course, _, gaps = predicted_gaps(machine, used, build(machine, used), start_angle)
    rate = abs(machine.speed)
    poses, rates, accelerations = (values * rate**k for k, values in enumerate(states_with_gaps(course, gaps)))
    times = course.angles / machine.speed
    found = joint_forces_of_motion(kinematics, poses, rates, accelerations, times)
    rest = np.zeros_like(times)
    return ExpectedForces(
        ForceTracks(
            Instants(times, course.angles, rest + machine.speed, rest), found.drive_torque, found.components, {}
        ),
        PREDICTION_MARGIN,
        FORCE_LAW,
    )


@cache
def spatial_tendons_count() -> bool:
    """Return True if this MuJoCo release includes the forces of spatial tendons in its joint forces.

    MuJoCo 4.0.0 does; according to their documentation, earlier releases do not.
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


def _iterate_again(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Solve a state once more if the solver stopped after its first iteration.

    A closure's force is D (aref - J qacc) with D = 1 / R, 1e8 and more where it is hardened, so an error of 1e-15 in
    the accelerations is 1e-7 N: little compared with the pins' forces, but 1e-3 of the moment of a light slide. The
    solver does not correct an error shorter than mjMINVAL, unless it starts at a small distance from the solution.
    """
    if int(data.solver_niter[0]) < MIN_SOLVER_ITERATIONS:
        data.qacc_warmstart[:] = data.qacc + WARM_START_SHIFT * (data.qacc_smooth - data.qacc)
        mujoco.mj_fwdConstraint(model, data)


class _ForceReader:
    """Reads the crank's acceleration and the forces of all joints from solved states."""

    def __init__(self, made: MuJoCoModel) -> None:
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

    def solve_states(
        self, times: Array, coordinates: Array, speeds: Array, poses: Array, rates: Array
    ) -> tuple[Array, dict[str, dict[str, Array]]]:
        """Solve the dynamics at T recorded states; all arguments are (T, ...).

        Returns:
            The crank's acceleration (T,), and the components (T,) of joint forces, by joint and by component.
        """
        model, data, crank = self._model, self._data, self._made.crank_dof
        acceleration = np.zeros(len(times))
        components = {name: np.zeros((len(times), 2)) for name in self._readers}
        pushes = applied_forces(self._uncounted, poses, rates, times)
        for k, time in enumerate(times):
            data.time, data.qpos[:], data.qvel[:] = time, coordinates[k], speeds[k]
            data.qacc_warmstart[:] = 0.0  # the solution of a state depends on it alone
            mujoco.mj_forward(model, data)
            _iterate_again(model, data)
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
        """Return the reader of a joint's force components in solved data."""
        match joint:
            case CamContact():
                return self._contact_reader(joint)
            case Revolute() if joint.name not in branches:
                return self._closure_reader(joint)
            case Revolute() | Prismatic():
                return self._tree_joint_reader(joint, branches[joint.name])
            case _:
                raise TypeError(f"{joint.name!r} rolls")

    def _closure_reader(self, joint: Revolute) -> Reader:
        """Return the reader of a pin that closes a loop."""
        data, equality = self._data, int(self._model.equality(joint.name).id)
        kind = int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)

        def read_closure(_: Array) -> Array:
            row = int(np.argmax((data.efc_id == equality) & (data.efc_type == kind)))
            # A connect holds the first body against the second one with this force on the first.
            return np.asarray(-data.efc_force[row : row + 2])

        return read_closure

    def _tree_joint_reader(self, joint: Revolute | Prismatic, branch: Branch) -> Reader:
        """Return the reader of a joint of the tree: the force of its parent on its child, as on the joint's body b."""
        data, child = self._data, int(self._model.body(branch.child).id)
        sense, root = (1.0 if branch.child == joint.b else -1.0), int(self._model.body_rootid[child])
        if isinstance(joint, Revolute):
            return lambda _: np.asarray(sense * data.cfrc_int[child, 3:5])

        def read_slide(poses: Array) -> Array:
            moment, fx, fy = sense * data.cfrc_int[child, 2:5]
            # MuJoCo reports the moment about the centre of gravity of the whole tree, a joint has it about its point.
            x, y = data.subtree_com[root, :2] - self._place(joint.b, joint.point_b, poses)
            turn = joint.direction + self._pose(joint.a, poses)[2]
            return np.array([np.cos(turn) * fy - np.sin(turn) * fx, moment + x * fy - y * fx])

        return read_slide

    def _contact_reader(self, joint: CamContact) -> Reader:
        """Return the reader of the contact force of cam and roller; 0 without contact."""
        model, data, wrench = self._model, self._data, np.zeros(6)
        pair = sorted(self._made.cam_and_roller_geoms(joint))

        def read_contact(_: Array) -> Array:
            total = 0.0
            for k in np.flatnonzero((np.sort(data.contact.geom, axis=1) == pair).all(axis=1)):
                mujoco.mj_contactForce(model, data, int(k), wrench)
                total += float(wrench[0])
            return np.array([total, 0.0])

        return read_contact

    def _pose(self, body: str, poses: Array) -> Array:
        """Pose (3,) of one body in poses of all (3 n,)."""
        if body == GROUND:
            return np.zeros(3)
        i = 3 * self._mechanism.body_index[body]
        return np.asarray(poses[i : i + 3])

    def _place(self, body: str, point: Point, poses: Array) -> Array:
        """Position (2,) [m] of a point of a body."""
        x, y, phi = self._pose(body, poses)
        return np.array(to_world((x, y, phi), point))
