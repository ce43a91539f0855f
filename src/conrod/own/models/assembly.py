"""A compiled model with its crank held: its own constraints, solved by Newton iteration, place everything else."""

from __future__ import annotations

import copy
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.model import equality_jacobian
from conrod.engines.numerics import close_gap, jacobian_rank
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.loading import (
    Crank,
    FoundPoint,
    check_finite,
    find_crank,
    find_point,
    keyframe_to_start_from,
    listed,
    load_model,
    name_or_number,
)
from conrod.own.models.request import Question

NEWTON_STEPS = 40
# A step of the iteration this small, against the largest coordinate, is rounding.
CLOSED = 1e-13
# The crank goes on by two degrees; where the rest does not follow its tangent within a fifth of the way, by less.
STEP, LEAST_STEP, STRAYED = np.radians(2.0), 1e-7, 0.2
# Below this a movement is rounding, whatever share of the way it is.
NOTHING = 1e-9
# Of the model's extent: how far the distance of two geoms is looked for, how far a follower is nudged to see it
# change (the single precision of meshes makes it rough below), and what is no distance.
FAR, NUDGE, TOUCHING = 1e3, 1e-6, 1e-12
# A joint that takes less than this share of a free direction does not move in it.
MOVES = 1e-6

NOT_KINEMATIC = (
    mujoco.mjtDisableBit.mjDSBL_CONTACT
    | mujoco.mjtDisableBit.mjDSBL_LIMIT
    | mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    | mujoco.mjtDisableBit.mjDSBL_SENSOR
)


class Assembly:
    """A copy of a model in which nothing but the closures acts; `data` is at the pose that was placed last.

    Attributes:
        original: the model as it was given.
        points: that were asked for.
        touching: two geoms whose contact places what the closures leave free; None where they leave nothing.
    """

    def __init__(self, model: mujoco.MjModel, crank: Crank, points: tuple[FoundPoint, ...]) -> None:
        self.original, self.model = model, copy.copy(model)
        self.model.opt.disableflags |= int(NOT_KINEMATIC)
        self.data = mujoco.MjData(self.model)
        self.crank, self.points = crank, points
        self.free = np.array([i for i in range(model.nv) if i != crank.rate], dtype=int)
        self.touching: tuple[int, int] | None = None

    # -- one pose ----------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Close the loops with the crank where it is.

        Raises:
            InvalidInput: they cannot be closed.
        """
        for _ in range(NEWTON_STEPS):
            mujoco.mj_fwdPosition(self.model, self.data)
            step, jacobian = np.zeros(self.model.nv), self.jacobian()
            if len(jacobian) and np.all(np.isfinite(jacobian)):
                step[self.free] = -np.linalg.lstsq(jacobian[:, self.free], self.violation(), rcond=1e-10)[0]
            mujoco.mj_integratePos(self.model, self.data.qpos, step, 1.0)
            if not np.all(np.isfinite(self.data.qpos)):
                break
            if np.abs(step).max(initial=0.0) <= CLOSED * (1.0 + np.abs(self.data.qpos).max()):
                mujoco.mj_fwdPosition(self.model, self.data)
                return
        worst = int(self.data.efc_id[int(np.argmax(np.abs(self.violation())))])
        held = name_or_number(self.model, "equality", worst)
        raise InvalidInput(f"its loops do not close with the crank at {self.degrees()}: {held}")

    def distance(self, geoms: tuple[int, int]) -> float:
        """Signed distance of two geoms, in the model's unit of length."""
        return float(mujoco.mj_geomDistance(self.model, self.data, *geoms, FAR * self.model.stat.extent, None))

    def touch(self) -> None:
        """Move what the closures leave free until the two geoms just touch.

        Raises:
            InvalidInput: they cannot be brought to touch.
        """
        geoms, extent = self.touching, float(self.model.stat.extent)
        if geoms is None:
            return
        base, way = self.data.qpos.copy(), self.left_free()[0]

        def moved(by: float) -> float:
            self.data.qpos[:] = base
            mujoco.mj_integratePos(self.model, self.data.qpos, way, by)
            self.close()
            return self.distance(geoms)

        close_gap(moved, 0.0, NUDGE * extent, TOUCHING * extent)
        if abs(self.distance(geoms)) > NUDGE * extent:
            names = " and ".join(name_or_number(self.model, "geom", geom) for geom in geoms)
            raise InvalidInput(f"{names} cannot be brought to touch with the crank at {self.degrees()}")

    def jacobian(self) -> Array:
        """Of the closures (rows, nv)."""
        return equality_jacobian(self.model, self.data)

    def violation(self) -> Array:
        """Of the closures (rows,), which come first among the constraints."""
        return np.array(self.data.efc_pos[: self.data.ne])

    # -- along the motion --------------------------------------------------------------------------------------

    def rates(self) -> Array:
        """Joint rates (nv,) that the closures leave at a crank rate of one; the contact's part is not in it."""
        rates, jacobian = np.zeros(self.model.nv), self.jacobian()
        rates[self.crank.rate] = 1.0
        if len(jacobian):
            rates[self.free] = np.linalg.lstsq(jacobian[:, self.free], -jacobian[:, self.crank.rate], rcond=1e-10)[0]
        return rates

    def left_free(self) -> Array:
        """Directions (k, nv) in which the closures let the model move with the crank held."""
        jacobian = self.jacobian()[:, self.free]
        directions = np.eye(len(self.free))
        if len(jacobian):
            directions = np.linalg.svd(jacobian)[2][jacobian_rank(jacobian) :]
        every = np.zeros((len(directions), self.model.nv))
        every[:, self.free] = directions
        return every

    def coordinate(self) -> float:
        """Of the crank [rad]."""
        return float(self.data.qpos[self.crank.coordinate])

    def degrees(self) -> str:
        """The crank's coordinate in words."""
        return f"{np.degrees(self.coordinate()):.6g} deg"

    def go(self, goal: float) -> None:
        """Turn the crank to a coordinate; the rest follows without leaving its branch.

        Raises:
            InvalidInput: it goes no further.
        """
        step = float(np.copysign(STEP, goal - self.coordinate()))
        while self.coordinate() != goal:
            here, before = self.coordinate(), self.data.qpos.copy()
            following = goal if abs(goal - here) <= abs(step) else here + step
            if self._try_step(following):
                step = float(np.copysign(min(2.0 * abs(step), STEP), step))
                continue
            self.data.qpos[:] = before
            mujoco.mj_fwdPosition(self.model, self.data)
            step *= 0.5
            if abs(step) < LEAST_STEP:
                held = "the closures hold it, and a crank turns fully"
                raise InvalidInput(f"its crank goes no further than {self.degrees()}: {held}")

    def _try_step(self, following: float) -> bool:
        tangent = self.rates() * (following - self.coordinate())
        mujoco.mj_integratePos(self.model, self.data.qpos, tangent, 1.0)
        self.data.qpos[self.crank.coordinate] = following
        predicted, strayed = self.data.qpos.copy(), np.empty(self.model.nv)
        try:
            self.close()
        except InvalidInput:
            return False
        mujoco.mj_differentiatePos(self.model, strayed, 1.0, predicted, self.data.qpos)
        if np.abs(strayed).max() > STRAYED * np.abs(tangent).max() + NOTHING:
            return False
        self.touch()
        return True


# -- from a file -------------------------------------------------------------------------------------------------------


def prepare(path: Path, question: Question) -> Assembly:
    """Load a model, find what was asked for and assemble it at its start pose.

    Raises:
        InvalidInput: the model cannot be loaded, has not what was asked for, is of another mobility than the machine
            or cannot be assembled.
    """
    model = load_model(path)
    check_finite(model)
    crank = find_crank(model, question.crank)
    assembly = Assembly(model, crank, tuple(find_point(model, place) for place in question.places))
    _assemble(assembly, question.keyframe)
    _check_freedom(assembly, question)
    if question.contacts and len(assembly.left_free()):
        assembly.touching = _geoms(assembly)
        assembly.touch()
    return assembly


def _assemble(assembly: Assembly, keyframe: str | None) -> None:
    """Close the loops from the pose that is asked for, or from the first of the model's own that can be closed."""
    model = assembly.model
    poses = [model.qpos0, *model.key_qpos]
    if keyframe is not None:
        index = keyframe_to_start_from(model, keyframe)
        poses = poses[:1] if index is None else [model.key_qpos[index]]
    for k, pose in enumerate(poses):
        assembly.data.qpos[:] = pose
        try:
            assembly.close()
            return
        except InvalidInput:
            if k == len(poses) - 1:
                raise


def _check_freedom(assembly: Assembly, question: Question) -> None:
    """Refuse a model of another mobility than the machine's, and name what moves or is held.

    A higher pair takes one freedom, when it touches: the closures alone may leave so many more.
    """
    rank, coordinates, least = jacobian_rank(assembly.jacobian()), assembly.model.nv, question.mobility
    if least <= coordinates - rank <= least + question.contacts:
        return
    by_contact = f", or {least + question.contacts} where it is closed by contact" if question.contacts else ""
    held = "its closures hold the crank"
    if coordinates - rank > least:
        moving = np.flatnonzero(np.abs(assembly.left_free()).max(axis=0) > MOVES)
        joints = dict.fromkeys(int(assembly.model.dof_jntid[i]) for i in moving)
        names = listed(name_or_number(assembly.model, "joint", joint) for joint in joints)
        held = f"with the crank held, {names} can still move; is a closure missing?"
    raise InvalidInput(
        f"its mobility is {coordinates - rank} ({coordinates} degrees of freedom of its joints, of which its "
        f"closures take {rank}), that of the machine is {least}{by_contact}: {held}"
    )


def _geoms(assembly: Assembly) -> tuple[int, int]:
    """The nearest pair of a geom that turns with the crank and a movable one that does not.

    Raises:
        InvalidInput: there is no pair that may collide.
    """
    model = assembly.model
    below = {int(model.jnt_bodyid[assembly.crank.joint])}
    for body in range(model.nbody):  # parents come before their children
        if int(model.body_parentid[body]) in below:
            below.add(body)
    turning = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in below]
    others = [g for g in range(model.ngeom) if g not in turning and model.body_weldid[model.geom_bodyid[g]] != 0]
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
    return min(pairs, key=lambda pair: abs(assembly.distance(pair)))
