"""Kinematic mode of a user's own model: one turn of its crank, held at angle after angle, and what its report names."""

from __future__ import annotations

from collections import Counter

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from conrod.engines.numerics import jacobian_rank
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.loading import (
    Crank,
    controls_at_start,
    joint_kind,
    keyframe_to_start_from,
    name_or_number,
    start_words,
)
from conrod.own.models.request import ModelFacts, Question, Scan

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
    active, rank, samples = np.flatnonzero(assembly.data.eq_active).tolist(), jacobian_rank(assembly.jacobian()), []
    for turn in np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1):
        assembly.go(start + float(turn))
        samples.append(_sample(assembly))
    states, rates, positions, links, anchors, axes = (np.array(column) for column in zip(*samples, strict=True))
    off = float(np.linalg.norm(positions[-1] - positions[0], axis=-1).max())
    if off > RETURNED * float(model.stat.extent):
        raise InvalidInput(f"after one turn of its crank a point is {off:.3g} away from where it was")
    pair, again, whole = assembly.touching, states[-1], slice(0, -1)
    facts = ModelFacts(
        name=model.names[: model.names.index(b"\0")].decode(errors="replace"),
        engine_version=mujoco.__version__,
        joints=dict(Counter(joint_kind(model, joint) for joint in range(model.njnt))),
        closures=dict(Counter(mujoco.mjtEq(int(model.eq_type[e])).name.removeprefix("mjEQ_").lower() for e in active)),
        coordinates=int(model.nv),
        rank=rank,
        touching=(name_or_number(model, "geom", pair[0]), name_or_number(model, "geom", pair[1])) if pair else None,
        timestep=float(model.opt.timestep),
        settings=_settings(model),
        stops=_stops(model, crank, states[whole]),
        start=start_words(model, keyframe_to_start_from(model, question.keyframe), controls.values()),
        controls=controls,
    )
    away = np.linalg.norm([anchors[whole] - anchors[0], axes[whole] - axes[0]], axis=-1)
    return Scan(
        facts=facts,
        coordinate=states[whole, crank.coordinate],
        points=tuple(point.name for point in assembly.points),
        positions=positions[whole].swapaxes(0, 1),
        turns=_turns(links[whole], axes[whole]).T,
        states=states[whole],
        rates=_differences(model, states[whole], again) if pair else rates[whole],
        anchor=anchors[0],
        axis=axes[0],
        wander=float(away.max()),
        shape_error=max((_shape_error(model, geom, axes[0]) for geom in pair or ()), default=0.0),
    )


def _sample(assembly: Assembly) -> tuple[Array, ...]:
    """State, rates, the points' positions and links (P, 3, 3), the crank's anchor and axis."""
    data, crank, points, rates = assembly.data, assembly.crank, assembly.points, assembly.rates()
    return (
        data.qpos.copy(),
        rates,
        np.array([point.position(data) for point in points]),
        np.array([data.xmat[point.body].reshape(3, 3) for point in points]),
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


def _shape_error(model: mujoco.MjModel, geom: int, axis: Array) -> float:
    """Depth of a mesh's facets under the smooth curve through its corners, seen along an axis, in the model's unit.

    A chord of length e whose ends turn by t is e tan(t / 4) / 2 away from the arc over it.
    """
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        return 0.0
    mesh, data = int(model.geom_dataid[geom]), mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.asarray(model.mesh_vert[first : first + count], dtype=float) @ data.geom_xmat[geom].reshape(3, 3).T
    across = np.linalg.svd(axis[None])[2][1:]  # two directions at right angles to the axis
    flat = vertices @ across.T
    outline = flat[ConvexHull(flat).vertices] @ np.array([1.0, 1.0j])
    edges = np.roll(outline, -1) - outline
    turns = np.angle(np.roll(edges, -1) / edges)  # at the end of each edge
    share = 0.5 * (turns + np.roll(turns, 1))
    single = float(np.finfo(np.float32).eps) * float(np.abs(outline).max())
    return float((0.5 * np.abs(edges) * np.tan(share / 4.0)).max()) + single


# -- facts -------------------------------------------------------------------------------------------------------------


def _settings(model: mujoco.MjModel) -> str:
    """Options of the model, in words."""
    option = model.opt
    integrator = mujoco.mjtIntegrator(int(option.integrator)).name.removeprefix("mjINT_")
    solver = mujoco.mjtSolver(int(option.solver)).name.removeprefix("mjSOL_")
    return (
        f"timestep {option.timestep:g} s, integrator {integrator}, solver {solver}, {option.iterations} iterations, "
        f"tolerance {option.tolerance:g}"
    )


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
