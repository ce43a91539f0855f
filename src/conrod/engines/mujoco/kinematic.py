"""Kinematic mode: MuJoCo's own constraints as a solver at prescribed crank angles."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.capabilities import KinematicResult
from conrod.engines.engine import Machine
from conrod.engines.mujoco.law import shape_error
from conrod.engines.mujoco.model import Build, build, constraint_jacobian
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.numerics import StraightAhead, approached, close_gap
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact

NEWTON_STEPS = 20


def solve_kinematics(machine: Machine, angle: Array) -> KinematicResult:
    """The crank held at each angle, the rest placed by the engine's own equations."""
    settings = MuJoCoSettings.tuned(machine, 1000)
    made = build(machine, settings)
    data = mujoco.MjData(made.model)
    contacts = made.tree.mechanism.cam_contacts
    rows, course = [], StraightAhead()
    for theta, asked in approached(machine.kinematics, angle):
        # Only where assemblies meet does it matter where the iteration begins.
        ahead = course.at(theta) if machine.kinematics.change_angles.size else None
        data.qpos[:] = data.qpos if ahead is None else ahead
        data.qpos[made.crank_dof] = theta
        if contacts:
            _place_follower(made, data, contacts[0])
        else:
            _close_loops(made, data)
        course.found(theta, data.qpos)
        if not asked:
            continue
        mujoco.mj_forward(made.model, data)
        rows.append((data.qpos.copy(), data.qvel.copy(), data.sensordata.copy()))
        data.qvel[made.crank_dof] = machine.speed
        if not contacts:
            _close_rates(made, data, machine.speed)
            mujoco.mj_forward(made.model, data)
            rows[-1] = (data.qpos.copy(), data.qvel.copy(), data.sensordata.copy())
    coordinates, rates, sensors = (np.array(column) for column in zip(*rows, strict=True))
    poses, _ = made.forward(coordinates, rates)
    points = {
        p.name: (
            made.sensor(sensors, f"{p.name}.position")[:, :2],
            None if contacts else made.sensor(sensors, f"{p.name}.velocity")[:, :2],
        )
        for p in made.tree.mechanism.observed
    }
    error = shape_error(machine, settings) if contacts else None
    return KinematicResult(angle, poses, points, error)


def _free(made: Build) -> NDArray[np.int_]:
    """Indices of the coordinates that are not the crank's."""
    return np.array([i for i in range(made.model.nv) if i != made.crank_dof], dtype=int)


def _close_loops(made: Build, data: mujoco.MjData) -> None:
    """Newton iteration on the engine's own constraint violation and Jacobian."""
    free = _free(made)
    for _ in range(NEWTON_STEPS):
        mujoco.mj_fwdPosition(made.model, data)
        step = np.linalg.lstsq(constraint_jacobian(made.model, data)[:, free], data.efc_pos[: data.nefc], rcond=None)[0]
        data.qpos[free] -= step
        if np.abs(step).max(initial=0.0) < 1e-15:  # nothing to close where the crank is all there is
            break


def _close_rates(made: Build, data: mujoco.MjData, speed: float) -> None:
    """Rates that the engine's constraint Jacobian leaves at the crank's speed."""
    free = _free(made)
    jacobian = constraint_jacobian(made.model, data)
    data.qvel[free] = np.linalg.lstsq(jacobian[:, free], -jacobian[:, made.crank_dof] * speed, rcond=None)[0]


def _place_follower(made: Build, data: mujoco.MjData, contact: CamContact) -> None:
    """The follower where the engine's own distance of cam and roller is zero (secant iteration)."""
    (cam, roller), slide = made.geoms(contact), int(_free(made)[0])

    def gap(position: float) -> float:
        data.qpos[slide] = position
        mujoco.mj_kinematics(made.model, data)
        return float(mujoco.mj_geomDistance(made.model, data, cam, roller, 1.0, None))

    # Single-precision vertices make the distance rough below this.
    close_gap(gap, float(data.qpos[slide]), 1e-4 * contact.roller_radius, 1e-13)
