"""One turn of the crank of a user's own model: how it moves by its closures, or by a contact, and what it is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from conrod.engines.numerics import close_gap
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint, moved
from conrod.exact.space.laws import law_of
from conrod.exact.space.mobility import Mobility, check_drives, loose, mobility
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.loops.reading import check_rigid, tree_of
from conrod.own.models.loading import (
    FoundPoint,
    check_finite,
    data_at_start,
    find_crank,
    find_point,
    keyframe_to_start_from,
    load_model,
    name_or_number,
    names_of,
    numbered,
    start_words,
)
from conrod.own.models.request import ModelFacts, Question, Scan

SAMPLES = 180  # in a turn
# A point that is not back after a turn is away by more than this share of the model.
RETURNED = 1e-6
TURN = 2.0 * np.pi * (1.0 - 1e-9)
# Of the model's extent: how far the distance of two geoms is looked for, how far a follower is nudged to see it
# change (the single precision of meshes makes it rough below), and what is no distance.
FAR, NUDGE, TOUCHING = 1e3, 1e-6, 1e-12
# Half of the way between two places of a follower, to take its rate from [rad of the crank].
BESIDE = 1e-4


@dataclass(frozen=True, eq=False)
class Turning:
    """A model whose crank turns at 1 rad/s from where it is assembled.

    Attributes:
        crank: as one of the machine's joints.
        start: closed coordinates (nq, 1) at time 0.
        touching: two geoms whose contact places what the closures leave free; None where they leave nothing.
    """

    model: mujoco.MjModel
    machine: DrivenTree
    crank: SpatialJoint
    points: tuple[FoundPoint, ...]
    start: Array
    freedom: Mobility
    touching: tuple[int, int] | None = None

    @property
    def first(self) -> float:
        """Coordinate of the crank at time 0 [rad]."""
        return float(self.start[self.crank.coordinate, 0])

    def coordinates(self, times: Array) -> Array:
        """All joint coordinates (nq, T) at rising times (T,), at each of which the contact is found anew."""
        if self.touching is None:
            return self.machine.motion(times, order=1).coordinates
        poses = [self.start]
        for time in times:
            poses.append(self._touched(poses[-1], float(time)))
        return np.concatenate(poses[1:], axis=1)

    def state(self, time: float) -> tuple[Array, Array]:
        """Coordinates (nq,) and rates (nv,) at a time; where a contact places them, rates by a central difference."""
        if self.touching is None:
            found = self.machine.motion(np.array([time]), order=1)
            return found.coordinates[:, 0], found.rates[0, :, 0]
        steps = np.linspace(0.0, time, 2 + int(SAMPLES * time / TURN))
        around = self.coordinates(np.array([*steps, time + BESIDE, time - BESIDE])).T[-3:]
        rates = np.empty(self.model.nv)
        mujoco.mj_differentiatePos(self.model, rates, 2.0 * BESIDE, around[2], around[1])
        return around[0], rates

    def _touched(self, coordinates: Array, time: float) -> Array:
        """The closed pose (nq, 1) near another in which the two geoms just touch.

        Raises:
            InvalidInput: they cannot be brought to touch.
        """
        machine, data, extent = self.machine, mujoco.MjData(self.model), float(self.model.stat.extent)
        base = machine.closed(coordinates, time)[0]
        way = np.zeros((self.model.nv, 1))
        way[machine.free] = machine.weights[:, None] * loose(machine, base)[:, :1]

        def moved_by(size: float) -> float:
            data.qpos[:] = machine.closed(moved(machine.tree, base, size * way), time)[0][:, 0]
            mujoco.mj_kinematics(self.model, data)
            return distance(self.model, data, geoms)

        geoms = self.touching or (0, 0)
        close_gap(moved_by, 0.0, NUDGE * extent, TOUCHING * extent)
        if abs(distance(self.model, data, geoms)) > NUDGE * extent:
            names = " and ".join(name_or_number(self.model, "geom", geom) for geom in geoms)
            raise InvalidInput(f"{names} cannot be brought to touch {machine.where(time)}")
        return np.array(data.qpos)[:, None]


def distance(model: mujoco.MjModel, data: mujoco.MjData, geoms: tuple[int, int]) -> float:
    """Signed distance of two geoms, in the model's unit of length."""
    return float(mujoco.mj_geomDistance(model, data, *geoms, FAR * model.stat.extent, None))


# -- from a file -------------------------------------------------------------------------------------------------------


@np.errstate(all="ignore")  # of numbers that are nearly none, which are refused
def prepare(path: Path, question: Question) -> Turning:
    """Load a model, find what was asked for and assemble it from the pose that is asked for, or its first that closes.

    Raises:
        InvalidInput: the model cannot be loaded, has not what was asked for, is of another mobility than the machine
            or cannot be assembled and turned.
    """
    model = load_model(path)
    check_finite(model)
    check_rigid(model)
    find_crank(model, question.crank)
    points, poses = tuple(find_point(model, place) for place in question.places), [model.qpos0, *model.key_qpos]
    if question.keyframe is not None:
        index = keyframe_to_start_from(model, question.keyframe)
        poses = poses[:1] if index is None else [model.key_qpos[index]]
    for pose in poses:
        tree = tree_of(model, pose)
        crank = next(joint for joint in tree.joints if joint.name == question.crank)
        machine = DrivenTree(tree, {crank.name: law_of("1rad/s", "rad", float(pose[crank.coordinate]), crank.name)})
        try:
            start = machine.closed(tree.start[:, None], 0.0)[0]
            break
        except InvalidInput as error:
            if pose is poses[-1]:  # the model's unit of length is not known yet
                raise InvalidInput(str(error).partition(" stays open")[0]) from None
    machine.knots = [machine.knot(start, 0.0)]
    made = Turning(model, machine, crank, points, start, mobility(machine))
    _check_freedom(made, question)
    if question.contacts and made.freedom.left > question.mobility:
        return replace(made, touching=_geoms(made))
    machine.go(start, 2.0 * np.pi)
    return made


def _check_freedom(made: Turning, question: Question) -> None:
    """Refuse a model of another mobility than the machine's, and name what moves or is held.

    A higher pair takes one freedom, when it touches: the closures alone may leave so many more.
    """
    found, least = made.freedom, question.mobility
    if found.left > least + question.contacts:
        by_contact = f", or {least + question.contacts} where it is closed by contact" if question.contacts else ""
        raise InvalidInput(
            f"its mobility is {found.left} ({found.freedom} degrees of freedom of its joints, of which its closures "
            f"take {found.rank}), that of the machine is {least}{by_contact}: with the crank held, "
            f"{', '.join(found.idle)} can still move; is a closure missing?"
        )
    if found.left <= least:
        check_drives(made.machine, made.start)


def _geoms(made: Turning) -> tuple[int, int]:
    """The nearest pair of a geom that turns with the crank and a movable one that does not.

    Raises:
        InvalidInput: there is no pair that may collide.
    """
    model, data = made.model, mujoco.MjData(made.model)
    data.qpos[:] = made.start[:, 0]
    mujoco.mj_kinematics(model, data)
    above = made.machine.tree.above
    turning = [g for g in range(model.ngeom) if made.crank in above[int(model.geom_bodyid[g])]]
    others = [g for g in range(model.ngeom) if g not in turning and above[int(model.geom_bodyid[g])]]
    paired = {frozenset(pair) for pair in zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)}
    masks = list(zip(model.geom_contype.tolist(), model.geom_conaffinity.tolist(), strict=True))
    pairs = [
        (a, b)
        for a in turning
        for b in others
        if frozenset((a, b)) in paired or masks[a][0] & masks[b][1] or masks[b][0] & masks[a][1]
    ]
    if not pairs:
        raise InvalidInput("nothing that turns with the crank may collide with what it is to move")
    return min(pairs, key=lambda pair: abs(distance(model, data, pair)))


# -- a turn ------------------------------------------------------------------------------------------------------------


def scan(turning: Turning, question: Question) -> Scan:
    """Samples at `SAMPLES` angles, and one a turn later, which shows whether all is back.

    Raises:
        InvalidInput: it cannot turn fully, or has not the keyframe or a control that is asked for.
    """
    model, crank, data = turning.model, turning.crank, mujoco.MjData(turning.model)
    facts, samples = facts_of(turning, question), []
    states = turning.coordinates(np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1)).T
    joint = find_crank(model, question.crank)
    for state in states:
        data.qpos[:] = state
        mujoco.mj_kinematics(model, data)
        places = np.array([point.position(data) for point in turning.points])
        links = np.array([data.xmat[point.body].reshape(3, 3) for point in turning.points])
        samples.append((places, links, data.xanchor[joint].copy(), data.xaxis[joint].copy()))
    positions, links, anchors, axes = (np.array(column) for column in zip(*samples, strict=True))
    off = float(np.linalg.norm(positions[-1] - positions[0], axis=-1).max())
    if off > RETURNED * float(model.stat.extent):
        raise InvalidInput(f"after one turn of its crank a point is {off:.3g} away from where it was")
    whole = slice(0, -1)
    away = np.linalg.norm([anchors[whole] - anchors[0], axes[whole] - axes[0]], axis=-1)
    return Scan(
        facts=replace(facts, stops=tuple(_stops(turning, states[whole].T))),
        coordinate=states[whole, crank.coordinate],
        points=tuple(point.name for point in turning.points),
        positions=positions[whole].swapaxes(0, 1),
        turns=_about(axes[0], links[whole] @ links[0].swapaxes(-1, -2)).T,
        anchor=anchors[0],
        axis=axes[0],
        wander=float(away.max()),
        shape_error=max((_shape_error(model, geom, axes[0]) for geom in turning.touching or ()), default=0.0),
    )


def _about(axis: Array, turned: Array) -> Array:
    """Angles (T, P) [rad] of turns (T, P, 3, 3) about an axis (3,)."""
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


def facts_of(turning: Turning, question: Question) -> ModelFacts:
    """What a model is, but for its stops; raises InvalidInput where it lacks a keyframe or a control."""
    model, tree, pair = turning.model, turning.machine.tree, turning.touching
    data, key = data_at_start(model, question.keyframe, question.controls)
    controls, option = data.ctrl.tolist(), model.opt
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
        controls=dict(zip(numbered(names_of(model, "actuator")), controls, strict=True)),
    )


def _stops(turning: Turning, states: Array) -> Iterator[str]:
    """Joints whose limits keep the model from its turn, along which its coordinates (nq, T) are made without limits."""
    if turning.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_LIMIT:
        return
    for joint in turning.machine.tree.joints:
        if joint.range is None:
            continue
        unit, factor = ("deg", float(np.degrees(1.0))) if joint.unit == "rad" else ("units of length", 1.0)
        low, high = (factor * value for value in joint.range)
        way = factor * states[joint.coordinate]
        # A crank may begin its turn at the lower of its limits.
        is_crank = joint is turning.crank
        if high - low < factor * TURN if is_crank else way.min() < low or way.max() > high:
            needs = "a full turn" if is_crank else f"{way.min():.6g} to {way.max():.6g}"
            yield f"{joint.name} is held to {low:.6g} to {high:.6g} {unit}, needs {needs}"
