"""MuJoCo's own constraints at prescribed crank angles: as a solver (kinematic mode), and counted (mobility)."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.capabilities import KinematicResult
from conrod.engines.engine import Machine
from conrod.engines.mobility import MobilityCount, Row, count_mobility
from conrod.engines.mujoco.law import shape_error
from conrod.engines.mujoco.model import Build, build, constraint_jacobian, equality_jacobian
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


# -- mobility --------------------------------------------------------------------------------------------------------

CONNECT_PARTS = ("x", "y", "z")


def model_mobility(machine: Machine, settings: MuJoCoSettings, angle: Array) -> MobilityCount:
    """The count at the exact poses of crank angles (T,) [rad]: equalities, and the distance of cam and roller."""
    made = build(machine, settings, sensors=False)
    model, data = made.model, mujoco.MjData(made.model)
    contacts = made.tree.mechanism.cam_contacts if model.npair else ()
    # A pair is looked at before it touches, too: in the exact pose the polygon may stand a micrometre off the roller.
    model.pair_margin[:] = [0.1 * contact.roller_radius for contact in contacts]
    jacobians, rows = list[Array](), list[Row]()
    for theta in angle:
        data.qpos[:], data.qvel[:] = made.start_state(machine, float(theta))
        mujoco.mj_fwdPosition(model, data)
        distances = [_distance_row(made, data, contact) for contact in contacts]
        jacobians.append(np.vstack([equality_jacobian(model, data), *distances]))
        rows = [*_equality_rows(model, data), *(Row(contact.name, "distance") for contact in contacts)]
    return count_mobility(rows, np.array(jacobians))


def _equality_rows(model: mujoco.MjModel, data: mujoco.MjData) -> list[Row]:
    """Names of the rows of `equality_jacobian`."""
    rows = list[Row]()
    for index in data.efc_id[: data.ne]:
        equality = model.equality(int(index))
        part = sum(row.constraint == equality.name for row in rows)
        is_connect = equality.type[0] == mujoco.mjtEq.mjEQ_CONNECT
        rows.append(Row(equality.name, CONNECT_PARTS[part] if is_connect else ""))
    return rows


def _distance_row(made: Build, data: mujoco.MjData, contact: CamContact) -> Array:
    """Gradient (1, nv) of the distance of cam and roller, by the engine's own contact point and normal."""
    model, pair = made.model, set(made.geoms(contact))
    found = next(c for c in data.contact if set(c.geom) == pair)
    first, second = np.empty((3, model.nv)), np.empty((3, model.nv))
    mujoco.mj_jac(model, data, first, None, found.pos, model.geom_bodyid[found.geom[0]])
    mujoco.mj_jac(model, data, second, None, found.pos, model.geom_bodyid[found.geom[1]])
    return np.asarray(found.frame[None, :3] @ (second - first))
