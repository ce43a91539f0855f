"""Runs of compiled models that are compared with each other, and the constraints along them.

All are from one start, by the same steps, and observe the same points.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import WARNINGS, warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.mjcf.equalities import Rows, openings, rows_at
from conrod.mjcf.stepping import BROKEN, broken

SAMPLES = 400
LOOKS = 40
# Of a model of many coordinates fewer, or their ranks would take longer than its run.
FEWEST, COORDINATES = 3, 100


@dataclass(frozen=True)
class Start:
    """State that a run starts from, and what acts from outside."""

    qpos: Array
    qvel: Array
    act: Array
    ctrl: Array
    mocap_pos: Array
    mocap_quat: Array

    @classmethod
    def of(cls, data: mujoco.MjData) -> Start:
        """Start from the state of data."""
        names = ("qpos", "qvel", "act", "ctrl", "mocap_pos", "mocap_quat")
        return cls(*(getattr(data, name).copy() for name in names))

    def data(self, model: mujoco.MjModel) -> mujoco.MjData:
        """New data in this state."""
        data = mujoco.MjData(model)
        self.put(data)
        return data

    def put(self, data: mujoco.MjData) -> None:
        """This state into data that is new, or has been reset."""
        data.qpos[:], data.qvel[:], data.act[:], data.ctrl[:] = self.qpos, self.qvel, self.act, self.ctrl
        data.mocap_pos[:], data.mocap_quat[:] = self.mocap_pos, self.mocap_quat


@dataclass(frozen=True)
class Observed:
    """Points that are looked at: sites, bodies, geoms, or the origins and centres of gravity of all that can move."""

    sites: tuple[int, ...] = ()
    bodies: tuple[int, ...] = ()
    geoms: tuple[int, ...] = ()

    def at(self, model: mujoco.MjModel, data: mujoco.MjData) -> Array:
        """Positions (p, 3) [m] in data whose kinematics were made."""
        if self.sites or self.bodies or self.geoms:
            places = ((data.site_xpos, self.sites), (data.xpos, self.bodies), (data.geom_xpos, self.geoms))
            return np.concatenate([every[list(chosen)] for every, chosen in places])
        moving = model.body_weldid > 0
        return np.concatenate([data.xpos[moving], data.xipos[moving]])


@dataclass(frozen=True)
class State:
    """One sample of a run, with all that the next step depends on."""

    qpos: Array
    qvel: Array
    act: Array
    guess: Array  # that the solver begins with

    def put(self, data: mujoco.MjData) -> None:
        """This sample into data."""
        data.qpos[:], data.qvel[:], data.act[:], data.qacc_warmstart[:] = self.qpos, self.qvel, self.act, self.guess


@dataclass(frozen=True)
class Run:
    """A run that was made.

    Attributes:
        states: at S samples, evenly spaced, the first is the start.
        points: (S, p, 3) [m], what is observed.
        sensors: (S, n), as MuJoCo gives them after the step that leaves the sample: they belong to the sample.
        touched: how many steps a pair of geoms was in contact.
        steps: that were made before anything broke.
        warnings: of the engine, and how often.
        finite: whether all positions are.
    """

    states: tuple[State, ...]
    points: Array
    sensors: Array
    steps: int
    touched: dict[tuple[int, int], int] = field(default_factory=dict)
    warnings: dict[str, int] = field(default_factory=dict)
    finite: bool = True

    @property
    def broke(self) -> bool:
        """True where the engine gave up, or should have."""
        return not self.finite or any(name in self.warnings for name in BROKEN)

    @property
    def travel(self) -> float:
        """The longest way [m] of a point from where it was at the start."""
        if not self.points.size:
            return 0.0
        return float(np.linalg.norm(self.points - self.points[0], axis=2).max())


def run(model: mujoco.MjModel, start: Start, steps: int, observed: Observed) -> Run:
    """Step a model; ends early where the engine warns of numbers that are none."""
    data = start.data(model)
    every = max(1, -(-steps // SAMPLES))
    states: list[State] = []
    sensors: list[Array] = []
    touched: dict[tuple[int, int], int] = {}
    done = 0
    with warnings_kept_quiet():
        for step in range(steps):
            sample = step % every == 0
            if sample:
                if broken(data):
                    break
                guess = data.qacc_warmstart.copy()
                states.append(State(data.qpos.copy(), data.qvel.copy(), data.act.copy(), guess))
            mujoco.mj_step(model, data)
            done += 1
            if data.ncon:
                _count_contacts(data, touched)
            if sample:
                sensors.append(data.sensordata.copy())
        warnings, finite = _warnings(data), bool(np.isfinite(data.qpos).all())
        points = _positions(model, start, states, observed)
    return Run(
        tuple(states), points, np.array(sensors), done, touched, warnings, finite and bool(np.isfinite(points).all())
    )


def _positions(model: mujoco.MjModel, start: Start, states: list[State], observed: Observed) -> Array:
    # In data of their own: after a step, positions in the data of the run belong to the instant before it.
    aside = start.data(model)
    points = []
    for state in states:
        aside.qpos[:] = state.qpos
        mujoco.mj_kinematics(model, aside)
        points.append(observed.at(model, aside))
    return np.array(points)


def _count_contacts(data: mujoco.MjData, touched: dict[tuple[int, int], int]) -> None:
    contact = data.contact
    # A contact within its margin that makes no force has no row.
    acting = contact.efc_address >= 0
    for one, other in {(min(pair), max(pair)) for pair in contact.geom[acting].tolist()}:
        touched[one, other] = touched.get((one, other), 0) + 1


def _warnings(data: mujoco.MjData) -> dict[str, int]:
    counts = data.warning.number
    return {name: int(counts[kind]) for name, kind in WARNINGS.items() if counts[kind]}


def largest_change(one: Run, other: Run) -> float:
    """Largest distance of a point from itself in another run [m]; infinite where one of them broke earlier."""
    if len(one.points) != len(other.points):
        return float("inf")
    return float(np.linalg.norm(one.points - other.points, axis=2).max()) if one.points.size else 0.0


class Poses:
    """Constraints at poses of a run that was made."""

    def __init__(self, model: mujoco.MjModel, start: Start, run: Run) -> None:
        self.model, self._start, self._run = model, start, run

    def each(self, every: int = 0) -> Iterator[mujoco.MjData]:
        """Data of poses along the run, with all that `mj_forward` makes; one object, used again and again.

        Args:
            every: take every so manieth sample, 0 for some `LOOKS` poses.
        """
        data = self._start.data(self.model)
        looks = min(LOOKS, max(FEWEST, LOOKS * COORDINATES**2 // self.model.nv**2))
        states = self._run.states
        for state in states[:: every or max(1, len(states) // looks)]:
            state.put(data)
            mujoco.mj_forward(self.model, data)
            yield data

    @cached_property
    def rows(self) -> list[Rows]:
        """Equality constraints at each look."""
        return [rows_at(self.model, data) for data in self.each()]

    @cached_property
    def openings(self) -> Array:
        """Opening (samples, neq) [m] of each connect or weld; 0 for other equalities and those that are off."""
        found = [openings(self.model, data) for data in self.each(1)]
        return np.array(found).reshape(len(found), self.model.neq)

    @cached_property
    def freedom(self) -> int:
        """Degrees of freedom that the closures leave, at the pose where they leave the fewest."""
        coordinates = int(self.model.nv)
        return min((coordinates - rows.rank for rows in self.rows), default=coordinates)
