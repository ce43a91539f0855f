"""Kinematic mode of a user's own model: one turn of its crank, held at angle after angle, and what its report names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import mujoco
import numpy as np

from conrod.engines.cam_polygon import convex_hull
from conrod.engines.mobility import independent_rows, jacobian_rank
from conrod.engines.mujoco import older
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.loading import (
    Crank,
    controls_at_start,
    joint_kind,
    keyframe_to_start_from,
    listed,
    name_or_number,
    start_words,
)
from conrod.own.models.request import ModelFacts, OwnSettings, Question, Scan, Touching, Wiring

SAMPLES = 180  # in a turn
# A point that is not back after a turn is away by more than this share of the model.
RETURNED = 1e-6
TURN = 2.0 * np.pi * (1.0 - 1e-9)


def scan(assembly: Assembly, question: Question) -> Scan:
    """Samples at `SAMPLES` angles, and one a turn later, which shows whether all is back.

    Raises:
        InvalidInput: it cannot turn fully, or has not the keyframe or a control that is asked for.
    """
    model, crank, start = assembly.original, assembly.crank, assembly.coordinate()
    controls = controls_at_start(model, question.keyframe, question.controls)
    ranks, samples, gaps = [jacobian_rank(assembly.jacobian())], [], []
    for turn in np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1):
        assembly.go(start + float(turn))
        samples.append(_sample(assembly))
        gaps.append(assembly.gap())
        ranks.append(jacobian_rank(assembly.jacobian()))
    states, rates, positions, slopes, links, spins, anchors, axes = (
        np.array(column) for column in zip(*samples, strict=True)
    )
    off = float(np.linalg.norm(positions[-1] - positions[0], axis=-1).max())
    if off > RETURNED * float(model.stat.extent):
        raise InvalidInput(f"after one turn of its crank a point is {off:.3g} away from where it was")
    wired, pair, again, whole = _wiring(assembly, ranks), assembly.touching, states[-1], slice(0, -1)
    gap, open_closure = max(gaps[whole], key=lambda gap: gap[0])
    facts = ModelFacts(
        name=model.names[: model.names.index(b"\0")].decode(errors="replace"),
        engine_version=mujoco.__version__,
        wiring=wired,
        touching=None if pair is None else _touching(model, pair, axes[0]),
        settings=_own_settings(model),
        gap=gap,
        open_closure=open_closure,
        stops=_stops(model, crank, states[whole]),
        remarks=_remarks(model, crank),
        start=start_words(model, keyframe_to_start_from(model, question.keyframe), controls.values()),
        controls=controls,
    )
    away = np.linalg.norm([anchors[whole] - anchors[0], axes[whole] - axes[0]], axis=-1)
    return Scan(
        facts=facts,
        coordinate=states[whole, crank.coordinate],
        points=tuple(point.name for point in assembly.points),
        positions=positions[whole].swapaxes(0, 1),
        slopes=None if pair else slopes[whole].swapaxes(0, 1),
        turns=_turns(links[whole], axes[whole]).T,
        spins=(spins[whole] @ axes[whole, :, None])[..., 0].T,
        states=states[whole],
        rates=_differences(model, states[whole], again) if pair else rates[whole],
        anchor=anchors[0],
        axis=axes[0],
        wander=float(away.max()),
    )


def _sample(assembly: Assembly) -> tuple[Array, ...]:
    """State, rates, the points' positions, slopes, links (P, 3, 3) and their spins, the crank's anchor and axis."""
    model, data, crank, points, rates = assembly.model, assembly.data, assembly.crank, assembly.points, assembly.rates()
    mujoco.mj_comPos(model, data)
    jacobians = [point.jacobians(model, data) for point in points]
    return (
        data.qpos.copy(),
        rates,
        np.array([point.position(data) for point in points]),
        np.array([along @ rates for along, _ in jacobians]),
        np.array([data.xmat[point.body].reshape(3, 3) for point in points]),
        np.array([about @ rates for _, about in jacobians]),
        data.xanchor[crank.joint].copy(),
        data.xaxis[crank.joint].copy(),
    )


def _turns(links: Array, axes: Array) -> Array:
    """Angles (T, P) [rad] about an axis (T, 3) by which links (T, P, 3, 3) have turned since the first of them."""
    turned = links @ links[0].swapaxes(-1, -2)
    back = turned.swapaxes(-1, -2)
    across = 0.5 * (turned - back)[..., [2, 0, 1], [1, 2, 0]]
    return np.asarray(np.arctan2((across @ axes[:, :, None])[..., 0], 0.5 * (turned.trace(axis1=-2, axis2=-1) - 1.0)))


def _differences(model: mujoco.MjModel, states: Array, again: Array) -> Array:
    """Rates (T, nv) by central differences of a closed turn's states (T, nq); `again` is the first a turn later."""
    count = len(states)
    # The last sample before the first one lies a turn further.
    around = np.vstack([states[-1] - (again - states[0]), states, again])
    rates = np.empty((count, model.nv))
    for k in range(count):
        mujoco.mj_differentiatePos(model, rates[k], 4.0 * np.pi / count, around[k], around[k + 2])
    return rates


# -- facts -------------------------------------------------------------------------------------------------------------


def _wiring(assembly: Assembly, ranks: Sequence[int]) -> Wiring:
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


def _touching(model: mujoco.MjModel, geoms: tuple[int, int], axis: Array) -> Touching:
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


def _own_settings(model: mujoco.MjModel) -> OwnSettings:
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


def _remarks(model: mujoco.MjModel, crank: Crank) -> tuple[str, ...]:
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


def _stops(model: mujoco.MjModel, crank: Crank, states: Array) -> tuple[str, ...]:
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
