"""Scan one turn of a user's own model: its paths, whether points return, and facts of the model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint
from conrod.exact.space.mobility import rigid_points
from conrod.mjcf.causes import describe_closures
from conrod.mjcf.driven_runs import tendons_beyond_limits
from conrod.mjcf.loading import data_at_start, find_crank, name_or_number, names_of, names_or_numbers, start_words
from conrod.mjcf.request import ModelFacts, ModelRequest, Scan
from conrod.mjcf.start import open_start, start_rate_violation
from conrod.models.check.turning import ALMOST_REVOLUTION, TURN_SAMPLES, Turning

# A point that is not back after a turn is away by more than this share of the model.
RETURN_TOLERANCE = 1e-6


def scan(turning: Turning, question: ModelRequest) -> Scan:
    """Sample a model at `TURN_SAMPLES` angles of a turn, or along a pass; check that its points return.

    Raises:
        InvalidInput: the model cannot turn fully, or lacks a requested keyframe or control.
    """
    model, crank, data = turning.model, turning.crank, mujoco.MjData(turning.model)
    facts, samples, lengths = model_facts(turning, question), [], list[Array]()
    states = turning.coordinates(sampled_times(turning, question)).T
    joint = find_crank(model, question.crank)
    for state in states:
        data.qpos[:] = state
        mujoco.mj_kinematics(model, data)
        if model.ntendon:
            mujoco.mj_comPos(model, data)
            mujoco.mj_tendon(model, data)
            lengths.append(data.ten_length.copy())
        places = np.array([point.position(data) for point in turning.points])
        links = np.array([data.xmat[point.body].reshape(3, 3) for point in turning.points])
        samples.append((places, links, data.xanchor[joint].copy(), data.xaxis[joint].copy()))
    positions, links, anchors, axes = (np.array(column) for column in zip(*samples, strict=True))
    off = float(np.linalg.norm(positions[-1] - positions[0], axis=-1).max())
    if turning.reach is None and question.returns and off > RETURN_TOLERANCE * float(model.stat.extent):
        raise InvalidInput(f"after one turn of its crank a point is {off:.3g} away from where it was")
    whole = slice(0, -1) if turning.reach is None else slice(None)
    away = np.linalg.norm([anchors[whole] - anchors[0], axes[whole] - axes[0]], axis=-1)
    return Scan(
        facts=replace(facts, stops=tuple(_all_stops(turning, question, states[whole].T, np.array(lengths)))),
        coordinate=states[whole, crank.coordinate],
        points=tuple(point.name for point in turning.points),
        positions=positions[whole].swapaxes(0, 1),
        turns=_rotation_angles(axes[0], links[whole] @ links[0].swapaxes(-1, -2)).T,
        anchor=anchors[0],
        axis=axes[0],
        wander=float(away.max()),
        shape_error=max((_shape_error(model, geom, axes[0]) for geom in turning.touching or ()), default=0.0),
    )


def sampled_times(turning: Turning, question: ModelRequest) -> Array:
    """Times (T,) [s] of the samples of a turn with its end, or along the whole travel of a one-pass crank."""
    if turning.reach is None:
        return np.linspace(0.0, 2.0 * np.pi, TURN_SAMPLES + 1)
    spacing, (back, ahead) = question.width / TURN_SAMPLES, turning.reach
    before, after = (int(way / spacing + 1e-6) for way in turning.reach)
    if before + after < TURN_SAMPLES:  # a pass that does not have the start among its samples
        return np.linspace(0.0, question.width, TURN_SAMPLES + 1)
    return np.clip(back + spacing * np.arange(-before, after + 1), 0.0, back + ahead)


def _rotation_angles(axis: Array, turned: Array) -> Array:
    """Angles (T, P) [rad] of rotations (T, P, 3, 3) about an axis (3,)."""
    vectors = Rotation.from_matrix(turned.reshape(-1, 3, 3)).as_rotvec()
    return np.asarray((vectors @ axis).reshape(turned.shape[:2]))


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


def model_facts(turning: Turning, question: ModelRequest) -> ModelFacts:
    """Collect the facts of a model, all but `stops`, which need its motion.

    Raises:
        InvalidInput: the model lacks a keyframe or a control.
    """
    model, tree, pair = turning.model, turning.machine.tree, turning.touching
    data, key = data_at_start(model, question.keyframe, question.controls)
    controls, option = data.ctrl.tolist(), model.opt
    begins = open_start(model, data, tree.extent, start_words(model, key))
    integrator = mujoco.mjtIntegrator(int(option.integrator)).name.removeprefix("mjINT_")
    solver = mujoco.mjtSolver(int(option.solver)).name.removeprefix("mjSOL_")
    return ModelFacts(
        name=model.names[: model.names.index(b"\0")].decode(errors="replace"),
        engine_version=mujoco.__version__,
        joints=dict(Counter(joint.kind for joint in tree.joints)),
        closures=dict(Counter(closure.kind for closure in tree.closures)),
        coordinates=turning.freedom.freedom,
        rank=turning.freedom.rank,
        touching=(name_or_number(model, "geom", pair[0]), name_or_number(model, "geom", pair[1])) if pair else None,
        timestep=float(option.timestep),
        settings=f"timestep {option.timestep:g} s, integrator {integrator}, solver {solver}, {option.iterations} "
        f"iterations, tolerance {option.tolerance:g}",
        start=start_words(model, key, controls),
        controls=dict(zip(names_or_numbers(names_of(model, "actuator")), controls, strict=True)),
        begins=begins,
        about=describe_closures(model),
        from_keyframe=key is not None,
        moves=bool(np.any(data.qvel)),
        rates=None if begins else start_rate_violation(turning.machine, data),
        rigid=_rigid_points(turning),
    )


def _all_stops(turning: Turning, question: ModelRequest, states: Array, lengths: Array) -> Iterator[str]:
    """Yield joint and tendon limits that keep the model from its turn or pass."""
    if turning.reach is not None:  # a pass from where it is assembled, or back to there
        first = min(int(turning.reach[0] / question.width * TURN_SAMPLES + 1e-6), states.shape[1] - TURN_SAMPLES - 1)
        rows = slice(first, first + TURN_SAMPLES + 1)
        states, lengths = states[:, rows], lengths[rows]
    yield from _stops(turning, states)
    yield from _tendon_stops(turning.model, lengths)


def _tendon_stops(model: mujoco.MjModel, lengths: Array) -> Iterator[str]:
    """Yield tendons whose limits keep the model from its turn, given their lengths (T, ntendon)."""
    for name, length, (low, high) in tendons_beyond_limits(model, lengths):
        yield f"tendon {name} is held to {low:.6g} to {high:.6g}, needs {length.min():.6g} to {length.max():.6g}"


def _rigid_points(turning: Turning) -> tuple[str, ...]:
    """Names of observed points that are rigid with the crank."""
    data, points = mujoco.MjData(turning.model), dict[str, SpatialPoint]()
    mujoco.mj_kinematics(turning.model, data)
    for one in turning.points:
        offset = data.xmat[one.body].reshape(3, 3).T @ (one.position(data) - data.xpos[one.body])
        points[one.name] = SpatialPoint(one.body, offset)
    return rigid_points(turning.machine, points)


def _stops(turning: Turning, states: Array) -> Iterator[str]:
    """Yield joints whose limits keep the model from its turn, given coordinates (nq, T) without limits."""
    for joint in turning.machine.tree.joints:
        if joint.range is None:
            continue
        unit, factor = ("deg", float(np.degrees(1.0))) if joint.unit == "rad" else ("units of length", 1.0)
        low, high = (factor * value for value in joint.range)
        way = factor * states[joint.coordinate]
        # A crank may begin its turn at the lower of its limits.
        is_crank = joint is turning.crank
        turns = is_crank and turning.reach is None
        if high - low < factor * ALMOST_REVOLUTION if turns else way.min() < low or way.max() > high:
            needs = "a full turn" if turns else f"{way.min():.6g} to {way.max():.6g}"
            yield f"{joint.name} is held to {low:.6g} to {high:.6g} {unit}, needs {needs}"
