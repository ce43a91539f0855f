"""Degrees of freedom of a compiled model: those of its joints minus the rank of its closures."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.mobility import MobilityCount, Row, count_mobility
from conrod.engines.mujoco.model import Build, build, constraint_jacobian
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact


def equality_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Jacobian (rows, nv) of the active equality constraints."""
    rows = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    return constraint_jacobian(model, data)[rows]


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
    for i in np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY):
        equality = model.equality(int(data.efc_id[i]))
        part = sum(row.constraint == equality.name for row in rows)
        is_connect = equality.type[0] == mujoco.mjtEq.mjEQ_CONNECT
        rows.append(Row(equality.name, CONNECT_PARTS[part] if is_connect else ""))
    return rows


def _distance_row(made: Build, data: mujoco.MjData, contact: CamContact) -> Array:
    """Gradient (1, nv) of the distance of cam and roller, by the engine's own contact point and normal."""
    model = made.model
    cam, roller = model.geom(f"{contact.a}.profile").id, model.geom(f"{contact.b}.roller").id
    found = next(c for c in data.contact if set(c.geom) == {cam, roller})
    first, second = np.empty((3, model.nv)), np.empty((3, model.nv))
    mujoco.mj_jac(model, data, first, None, found.pos, model.geom_bodyid[found.geom[0]])
    mujoco.mj_jac(model, data, second, None, found.pos, model.geom_bodyid[found.geom[1]])
    return np.asarray(found.frame[None, :3] @ (second - first))
