"""Facts about a model that its report names: joints and closures, its cam's shape, settings, limits, what else acts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import mujoco
import numpy as np

from conrod.engines.cam_polygon import convex_hull
from conrod.engines.mobility import independent_rows
from conrod.engines.mujoco import older
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.loading import Crank, joint_kind, listed, name_or_number
from conrod.own.models.request import OwnSettings, Touching, Wiring

TURN = 2.0 * np.pi * (1.0 - 1e-9)


def wiring(assembly: Assembly, ranks: Sequence[int]) -> Wiring:
    """Joints and closures of the model; `ranks` are those of the closures along the turn."""
    model, switched = assembly.model, assembly.data.eq_active
    active, inactive = np.flatnonzero(switched).tolist(), np.flatnonzero(switched == 0).tolist()
    # A closure that takes no freedom which those before it have left has no row of its own.
    needed = assembly.owners()[independent_rows(assembly.jacobian())]
    kinds = (str(mujoco.mjtEq(int(model.eq_type[e])).name).removeprefix("mjEQ_").lower() for e in active)
    return Wiring(
        joints=dict(Counter(joint_kind(model, joint) for joint in range(model.njnt))),
        closures=dict(Counter(kinds)),
        inactive=tuple(name_or_number(model, "equality", e) for e in inactive),
        coordinates=int(model.nv),
        rank=(min(ranks), max(ranks)),
        idle=tuple(name_or_number(model, "equality", e) for e in active if e not in needed),
    )


# -- the shape of a cam ------------------------------------------------------------------------------------------------


def touching(model: mujoco.MjModel, geoms: tuple[int, int], axis: Array) -> Touching:
    """A higher pair in words, with the error of its shapes.

    Args:
        axis: of the crank, across which the shapes are flat.
    """
    shapes = [_shape_error(model, geom, axis) for geom in geoms]
    first, second = (name_or_number(model, "geom", geom) for geom in geoms)
    return Touching((first, second), max(e for e, _ in shapes), sum(count for _, count in shapes))


def _shape_error(model: mujoco.MjModel, geom: int, axis: Array) -> tuple[float, int]:
    """Depth of a mesh's facets under the smooth curve through its corners, seen along an axis; and their number.

    A chord of length e whose ends turn by t is e tan(t / 4) / 2 away from the arc over it.
    """
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        return 0.0, 0
    mesh, data = int(model.geom_dataid[geom]), mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.asarray(model.mesh_vert[first : first + count], dtype=float) @ data.geom_xmat[geom].reshape(3, 3).T
    aside = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    aside /= np.linalg.norm(aside)
    outline = convex_hull(vertices @ np.column_stack([aside, np.cross(axis, aside)])) @ np.array([1.0, 1.0j])
    edges = np.roll(outline, -1) - outline
    turns = np.angle(np.roll(edges, -1) / edges)  # at the end of each edge
    share = 0.5 * (turns + np.roll(turns, 1))
    single = float(np.finfo(np.float32).eps) * float(np.abs(outline).max())
    return float((0.5 * np.abs(edges) * np.tan(share / 4.0)).max()) + single, len(outline)


# -- settings and limits -----------------------------------------------------------------------------------------------


def own_settings(model: mujoco.MjModel) -> OwnSettings:
    """Options of the model, and all softnesses that its closures have."""
    option = model.opt
    off = bool(option.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    x, y, z = (0.0, 0.0, 0.0) if off else option.gravity.tolist()
    return OwnSettings(
        timestep=float(option.timestep),
        integrator=mujoco.mjtIntegrator(int(option.integrator)).name.removeprefix("mjINT_"),
        solver=mujoco.mjtSolver(int(option.solver)).name.removeprefix("mjSOL_"),
        iterations=int(option.iterations),
        tolerance=float(option.tolerance),
        gravity=(x, y, z),
        closure_solref=tuple(dict.fromkeys((a, b) for a, b, *_ in model.eq_solref.tolist())),
        closure_impedance=tuple(dict.fromkeys((a, b) for a, b, *_ in model.eq_solimp.tolist())),
    )


def remarks(model: mujoco.MjModel, crank: Crank) -> tuple[str, ...]:
    """Parts of the model that act on the crank beside the drive, or are treated otherwise than in the file."""
    found, joint, dof = list[str](), crank.joint, crank.rate
    if model.dof_armature[dof] > 0.0:
        found.append(f"the crank has an armature of {model.dof_armature[dof]:g} by itself")
    by_joint = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    on_crank = np.flatnonzero(np.isin(model.actuator_trntype, by_joint) & (model.actuator_trnid[:, 0] == joint))
    if len(on_crank):
        names = listed(name_or_number(model, "actuator", int(a)) for a in on_crank)
        found.append(f"on the crank acts {names}: with conrod's drive its control is 0, and the drive overcomes it")
    elif model.nu:
        found.append("with conrod's drive all controls are 0")
    if model.jnt_limited[joint]:
        low, high = np.degrees(model.jnt_range[joint])
        found.append(f"the crank has limits, {low:g} to {high:g} deg: the drive turns it through them")
    for what, value in (("damping", model.dof_damping[dof]), ("friction", model.dof_frictionloss[dof])):
        size = float(abs(value).max())
        if size > 0.0:
            found.append(f"the crank has a {what} of {size:g}, which the drive overcomes")
    if not model.opt.disableflags & older.flag("AUTORESET"):
        found.append("autoreset is on: a run that fails starts again in silence; with conrod's drive it is off")
    return tuple(found)


def stops(model: mujoco.MjModel, crank: Crank, states: Array) -> tuple[str, ...]:
    """Joints whose limits keep the model from its turn.

    Args:
        states: all joint coordinates along the turn (T, nq), made without limits.
    """
    found = list[str]()
    limits_act = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_LIMIT
    for joint in np.flatnonzero(model.jnt_limited).tolist() if limits_act else ():
        known = {"hinge": ("deg", float(np.degrees(1.0))), "slide": ("units of length", 1.0)}
        if (shown := known.get(joint_kind(model, joint))) is None:
            continue
        unit, factor = shown
        low, high = (factor * float(value) for value in model.jnt_range[joint])
        way = factor * states[:, model.jnt_qposadr[joint]]
        # A crank may begin its turn at the lower of its limits.
        is_crank = joint == crank.joint
        if high - low < factor * TURN if is_crank else way.min() < low or way.max() > high:
            needs = "a full turn" if is_crank else f"{way.min():.6g} to {way.max():.6g}"
            name = name_or_number(model, "joint", joint)
            found.append(f"{name} is held to {low:.6g} to {high:.6g} {unit}, needs {needs}")
    return tuple(found)
