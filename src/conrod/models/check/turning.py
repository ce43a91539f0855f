"""A user's own model whose crank turns: how its closures, or a contact, move it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.numerics import secant_root
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint, displace
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.exact.space.immobility import removable_words
from conrod.exact.space.mobility import Mobility, TooManyDrivesError, check_drives, count_mobility, free_directions
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.equalities import inactive_words
from conrod.mjcf.loading import (
    FoundPoint,
    check_finite,
    find_crank,
    find_point,
    keyframe_to_start_from,
    name_or_number,
)
from conrod.mjcf.missing_files import load_with_notes
from conrod.mjcf.reading import check_rigid, tree_of
from conrod.mjcf.request import ModelRequest

TURN_SAMPLES = 180  # in a turn
ALMOST_REVOLUTION = 2.0 * np.pi * (1.0 - 1e-9)
# Of the model's extent: how far the distance of two geoms is looked for, how far a follower is nudged to see it
# change (the single precision of meshes makes it rough below), and what is no distance.
MAX_GEOM_DISTANCE, NUDGE_SIZE, TOUCHING_DISTANCE = 1e3, 1e-6, 1e-12
# Half of the way between two places of a follower, to take its rate from [rad of the crank].
RATE_INTERVAL = 1e-4


@dataclass(frozen=True, eq=False)
class Turning:
    """A model whose crank turns at 1 rad/s from where it is assembled.

    Attributes:
        crank: joint of the machine that is driven.
        start: closed coordinates (nq, 1) at time 0.
        touching: two geoms whose contact places what the closures leave free; None where they leave nothing.
        reach: times [s] from the assembled pose back to one end of the crank's travel, and on to the other end; None
            if the crank turns fully.
        left_out: what of the file is not there and was left out, in words.
    """

    model: mujoco.MjModel
    machine: DrivenTree
    crank: SpatialJoint
    points: tuple[FoundPoint, ...]
    start: Array
    freedom: Mobility
    touching: tuple[int, int] | None = None
    reach: tuple[float, float] | None = None
    left_out: tuple[str, ...] = ()

    @property
    def first(self) -> float:
        """Coordinate of the crank at time 0 [rad]."""
        return float(self.start[self.crank.coordinate, 0])

    def time_at(self, coordinate: float) -> float:
        """Time [s] at which the crank is at a coordinate [rad], within its turn or its reach."""
        if self.reach is None:
            return float(np.remainder(coordinate - self.first, 2.0 * np.pi))
        return float(np.clip(coordinate - self.first, 0.0, sum(self.reach)))

    def coordinates(self, times: Array) -> Array:
        """All joint coordinates (nq, T) at rising times (T,); a contact is solved at each."""
        if self.touching is None:
            return self.machine.motion(times, order=1).coordinates
        poses = [self.start]
        for time in times:
            poses.append(self._touching_pose(poses[-1], float(time), self.touching))
        return np.concatenate(poses[1:], axis=1)

    def state(self, time: float) -> tuple[Array, Array]:
        """Coordinates (nq,) and rates (nv,) at a time; rates by central difference if a contact determines them."""
        if self.touching is None:
            found = self.machine.motion(np.array([time]), order=1)
            return found.coordinates[:, 0], found.rates[0, :, 0]
        steps = np.linspace(0.0, time, 2 + int(TURN_SAMPLES * time / ALMOST_REVOLUTION))
        around = self.coordinates(np.array([*steps, time + RATE_INTERVAL, time - RATE_INTERVAL])).T[-3:]
        rates = np.empty(self.model.nv)
        mujoco.mj_differentiatePos(self.model, rates, 2.0 * RATE_INTERVAL, around[2], around[1])
        return around[0], rates

    def _touching_pose(self, coordinates: Array, time: float, geoms: tuple[int, int]) -> Array:
        """The closed pose (nq, 1) near a given one at which two geoms just touch.

        Raises:
            InvalidInput: the geoms cannot be brought to touch.
        """
        machine, data, extent = self.machine, mujoco.MjData(self.model), float(self.model.stat.extent)
        base = machine.close_loops(coordinates, time)[0]
        way = np.zeros((self.model.nv, 1))
        way[machine.free] = machine.weights[:, None] * free_directions(machine, base)[:, :1]

        def moved_by(size: float) -> float:
            data.qpos[:] = machine.close_loops(displace(machine.tree, base, size * way), time)[0][:, 0]
            mujoco.mj_kinematics(self.model, data)
            return distance(self.model, data, geoms)

        secant_root(moved_by, 0.0, NUDGE_SIZE * extent, TOUCHING_DISTANCE * extent)
        if abs(distance(self.model, data, geoms)) > NUDGE_SIZE * extent:
            names = " and ".join(name_or_number(self.model, "geom", geom) for geom in geoms)
            raise InvalidInput(f"{names} cannot be brought to touch {machine.describe_drives(time)}")
        return np.array(data.qpos)[:, None]


def distance(model: mujoco.MjModel, data: mujoco.MjData, geoms: tuple[int, int]) -> float:
    """Signed distance of two geoms, in the model's unit of length."""
    return float(mujoco.mj_geomDistance(model, data, *geoms, MAX_GEOM_DISTANCE * model.stat.extent, None))


# -- from a file -------------------------------------------------------------------------------------------------------


@np.errstate(all="ignore")  # of numbers that are nearly none, which are refused
def prepare_turning(path: Path, question: ModelRequest) -> Turning:
    """Load a model, find its crank and points, and assemble it from the keyframe or the first closing pose.

    Raises:
        InvalidInput: the model cannot be loaded, lacks a requested element, has another mobility than the machine, or
            cannot be assembled.
        BlockedTurnError: its crank goes no further than a part of the turn or pass.
    """
    model, left_out = load_with_notes(path, question.unit)
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
        machine = DrivenTree(
            tree, {crank.name: parse_drive_law("1rad/s", "rad", float(pose[crank.coordinate]), crank.name)}
        )
        try:
            start = machine.close_loops(tree.start[:, None], 0.0)[0]
            break
        except InvalidInput as error:
            if pose is poses[-1]:  # the model's unit of length is not known yet
                raise InvalidInput(str(error).partition(" stays open")[0]) from None
    machine.knots = machine.solve_knots(start, np.zeros(1))
    made = Turning(model, machine, crank, points, start, count_mobility(machine), left_out=left_out)
    _check_freedom(made, question)
    if question.contacts and made.freedom.remaining_dof > question.mobility:
        return replace(made, touching=_nearest_geoms(made))
    try:
        if question.span is not None:
            return _one_pass(made, question.width)
        machine.track_branch(start, 2.0 * np.pi)
    except InvalidInput as error:
        raise BlockedTurnError(str(error), made) from None
    return made


class BlockedTurnError(InvalidInput):
    """A model whose crank goes no further than a part of the machine's turn or pass.

    Attributes:
        turning: the model, with its motion as far as it goes.
    """

    def __init__(self, words: str, turning: Turning) -> None:
        super().__init__(words)
        self.turning = turning


# Share of the pass by which a model is kept off the pose where its crank can go no further.
OFF_LIMIT = 1e-2


def _one_pass(made: Turning, width: float) -> Turning:
    """Extend the motion to all that the crank can travel, at most one pass to each side of the assembly.

    Raises:
        InvalidInput: the crank travels less than the pass; names the poses where it stops.
    """
    (back, lowest, low), (ahead, _, high) = (_reachable_travel(made, sense, width) for sense in (-1.0, 1.0))
    if back + ahead < width * (1.0 - 1e-9):
        raise InvalidInput(
            f"its crank goes from {low} to {high} alone, {np.degrees(back + ahead):.5g} deg: the pass of the machine "
            f"takes {np.degrees(width):.5g} deg"
        )
    law = parse_drive_law("1rad/s", "rad", float(lowest[made.crank.coordinate, 0]), made.crank.name)
    machine = DrivenTree(made.machine.tree, {made.crank.name: law})
    machine.track_branch(lowest, back + ahead)
    return replace(made, machine=machine, start=lowest, reach=(back, ahead))


def _reachable_travel(made: Turning, sense: float, width: float) -> tuple[float, Array, str]:
    """Angle [rad] that the crank can travel one way, the pose (nq, 1) there, and its angle in words."""
    law = parse_drive_law(f"{sense!r}rad/s", "rad", made.first, made.crank.name)
    machine = DrivenTree(made.machine.tree, {made.crank.name: law})
    try:
        machine.track_branch(made.start, width)
        time = width
    except InvalidInput:
        time = max(machine.knots[-1].time - OFF_LIMIT * width, 0.0)
    there = machine.motion(np.array([time]), order=1).coordinates
    return time, there, f"{np.degrees(there[made.crank.coordinate, 0]):.5g} deg"


def _check_freedom(made: Turning, question: ModelRequest) -> None:
    """Refuse a model whose mobility differs from the machine's, and name what moves or is held.

    A higher pair takes one freedom, when it touches: the closures alone may leave so many more.
    """
    found, least = made.freedom, question.mobility
    if found.remaining_dof > least + question.contacts:
        by_contact = f", or {least + question.contacts} where it is closed by contact" if question.contacts else ""
        raise InvalidInput(
            f"its mobility is {found.remaining_dof} ({found.freedom} degrees of freedom of its joints, of which its "
            f"closures take {found.rank}), that of the machine is {least}{by_contact}: with the crank held, "
            f"{', '.join(found.idle)} can still move; {inactive_words(made.model) or 'is a closure missing?'}"
        )
    if found.remaining_dof <= least:
        try:
            check_drives(made.machine, made.start)
        except TooManyDrivesError as error:
            raise InvalidInput(f"{error}{removable_words(made.machine, made.start)}") from None


def _nearest_geoms(made: Turning) -> tuple[int, int]:
    """The nearest pair of a geom that turns with the crank and a movable one that does not.

    Raises:
        InvalidInput: no two such geoms may collide.
    """
    model, data = made.model, mujoco.MjData(made.model)
    data.qpos[:] = made.start[:, 0]
    mujoco.mj_kinematics(model, data)
    above = made.machine.tree.joints_above
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
