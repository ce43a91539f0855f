"""The compiled model of a machine, its start state, and the laws of loads that act while it is stepped.

MuJoCo seeks the hull of each mesh that can collide when a model is compiled: for a cam of 4000 vertices that takes a
second, several times what a coarse run of it takes. Of a mesh in a file MuJoCo keeps the hull, in a cache that lasts as
long as the process; then it takes 5 ms. So vertices that stand in a model's text are handed over as a file in memory.
The compiled model is the same to the last bit, but for the path of that file.

MuJoCo asks a program for the bias of an actuator (`mjcb_act_bias`) whenever it evaluates forces, so at every stage of
RK4, at that stage's length, rate and time. There is one such program in a process: it is there while it is needed, and
what was there before comes back, whatever happens.
"""

from __future__ import annotations

import hashlib
import struct
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.massless_rod import ModelForm, model_form
from conrod.engines.mujoco.closures import joint_name
from conrod.engines.mujoco.loads import by_program, moves_nothing, origin_of
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.settings import MuJoCoSettings, harden
from conrod.engines.tree import Tree, tree_of
from conrod.exact.motion import Array


@dataclass(frozen=True)
class Coordinates:
    """Of the bodies that the engine has; poses and rates are theirs, (T, 3 m).

    Attributes:
        places: of each branch of the tree, the first of its coordinates.
        rate_places: the first of its rates.
        free: whether its body is free in space.
        sizes: numbers of all coordinates and of all rates.
    """

    tree: Tree
    places: tuple[int, ...]
    rate_places: tuple[int, ...]
    free: tuple[bool, ...]
    sizes: tuple[int, int]

    def of_poses(self, poses: Array) -> Array:
        """Coordinates (T, nq)."""
        found = np.zeros((len(poses), self.sizes[0]))
        for k, column in enumerate(self.tree.coordinates(poses).T):
            place = self.places[k]
            if self.free[k]:
                pose = poses[:, self._columns(k)]
                found[:, place : place + 2] = pose[:, :2]
                found[:, place + 3], found[:, place + 6] = np.cos(0.5 * pose[:, 2]), np.sin(0.5 * pose[:, 2])
            else:
                found[:, place] = column
        return found

    def of_rates(self, poses: Array, rates: Array) -> Array:
        """Rates (T, nv)."""
        found = np.zeros((len(poses), self.sizes[1]))
        for k, column in enumerate(self.tree.rates(poses, rates).T):
            place = self.rate_places[k]
            if self.free[k]:
                found[:, [place, place + 1, place + 5]] = rates[:, self._columns(k)]
            else:
                found[:, place] = column
        return found

    def forward(self, coordinates: Array, rates: Array, after: Array | None = None) -> tuple[Array, Array]:
        """Poses and their rates.

        Args:
            after: poses (3 m,) that these follow in a run reported in pieces; None at its beginning.
        """
        known = {self.tree.branches[k].child: self._free_body(k, coordinates, rates, after) for k in self._free_ones}
        return self.tree.forward(coordinates[:, self.places], rates[:, self.rate_places], known)

    def _free_body(self, k: int, coordinates: Array, rates: Array, after: Array | None) -> tuple[Array, Array]:
        """Pose and rates (T, 3) in the plane; the first turn within half a turn of the one before, or of the start."""
        place, rate = self.places[k], self.rate_places[k]
        near = (self.tree.start if after is None else after)[self._columns(k)][2]
        turn = 2.0 * np.arctan2(coordinates[:, place + 6], coordinates[:, place + 3])
        # Whole turns are counted, so that the same comes of it wherever a run is cut.
        turn = turn - 2.0 * np.pi * np.cumsum(np.rint(np.diff(turn, prepend=near) / (2.0 * np.pi)))
        pose = np.column_stack([coordinates[:, place : place + 2], turn])
        return pose, rates[:, [rate, rate + 1, rate + 5]]

    @property
    def _free_ones(self) -> list[int]:
        return [k for k, free in enumerate(self.free) if free]

    def _columns(self, k: int) -> slice:
        i = 3 * self.tree.mechanism.body_index[self.tree.branches[k].child]
        return slice(i, i + 3)


# What else may stand beside vertices, and would have to be in the file too.
OTHER_PARTS = {"face", "normal", "texcoord", "file", "builtin"}


def compiled(text: str) -> mujoco.MjModel:
    """The model of an MJCF text.

    Raises:
        ValueError: MuJoCo cannot compile it.
    """
    root = ET.fromstring(text)
    files = {}
    for mesh in root.iterfind("asset/mesh"):
        if "vertex" in mesh.attrib and not OTHER_PARTS & set(mesh.attrib):
            content = _file_of(mesh.attrib.pop("vertex"))
            # Named after its content: whatever the cache compares, two meshes are never taken for one.
            name = f"{hashlib.sha256(content).hexdigest()}.msh"
            mesh.set("file", name)
            files[name] = content
    if not files:
        return mujoco.MjModel.from_xml_string(text)
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"), files)


def _file_of(vertices: str) -> bytes:
    """The vertices as a file in MuJoCo's MSH format: four counts, then single precision."""
    numbers = np.array(vertices.split(), dtype=np.float32)
    return struct.pack("4i", len(numbers) // 3, 0, 0, 0) + numbers.tobytes()


@contextmanager
def laws_acting(model: mujoco.MjModel, tree: Tree, begin: float = 0.0) -> Iterator[None]:
    """Give the laws of a machine's loads to MuJoCo, which steps it in this thread alone.

    Args:
        begin: the time [s] at which the engine's clock is 0.
    """
    laws = {
        int(model.actuator(load.name).id): (load.law, origin_of(load, tree))
        for load in by_program(tree.mechanism)
        if not moves_nothing(load, tree)
    }
    if not laws:
        yield
        return

    def bias(_: mujoco.MjModel, data: mujoco.MjData, actuator: int) -> float:
        law, origin = laws[actuator]
        value, rate = data.actuator_length[actuator] + origin, data.actuator_velocity[actuator]
        return float(law.force(np.asarray(value), np.asarray(rate), np.asarray(begin + data.time)))

    before = mujoco.get_mjcb_act_bias()
    mujoco.set_mjcb_act_bias(bias)
    try:
        yield
    finally:
        mujoco.set_mjcb_act_bias(before)


Edit = Callable[[mujoco.MjModel], None]


@dataclass(frozen=True)
class Build:
    """A compiled model with the tree that its coordinates belong to; states are those of all links."""

    form: ModelForm
    tree: Tree
    model: mujoco.MjModel

    @property
    def crank_coordinate(self) -> int:
        """Index of the crank among the coordinates."""
        return int(self.model.joint("crank").qposadr[0])

    @property
    def crank_dof(self) -> int:
        """Index of the crank among the rates."""
        return int(self.model.joint("crank").dofadr[0])

    @cached_property
    def coordinates_of(self) -> Coordinates:
        """Places of the state of the tree in the model."""
        joints = [self.model.joint(joint_name(self.tree, branch)) for branch in self.tree.branches]
        return Coordinates(
            tree=self.tree,
            places=tuple(int(joint.qposadr[0]) for joint in joints),
            rate_places=tuple(int(joint.dofadr[0]) for joint in joints),
            free=tuple(joint.type[0] == mujoco.mjtJoint.mjJNT_FREE for joint in joints),
            sizes=(self.model.nq, self.model.nv),
        )

    def start_state(self, machine: Machine, angle: float) -> tuple[Array, Array]:
        """Joint coordinates and rates of the exact motion at a crank angle."""
        poses, slopes = machine.kinematics.derivatives(np.array([angle]), 1)
        return self.coordinates(poses)[0], self.rates(poses, slopes * machine.speed)[0]

    def coordinates(self, poses: Array) -> Array:
        """Model coordinates (T, nq) of poses (T, 3 n)."""
        return self.coordinates_of.of_poses(self.form.kept(poses))

    def rates(self, poses: Array, rates: Array) -> Array:
        """Model rates (T, nv) of rates of the poses (T, 3 n); a joint's rate is linear in them."""
        return self.coordinates_of.of_rates(self.form.kept(poses), self.form.kept(rates))

    def forward(self, coordinates: Array, rates: Array, after: Array | None = None) -> tuple[Array, Array]:
        """Poses and their rates (T, 3 n) of coordinates (T, nq) and rates (T, nv); for `after` see `completed`."""
        before = None if after is None else self.form.kept(after)
        poses, speeds = self.form.completed(self.coordinates_of.forward(coordinates, rates, before), after)
        return poses, speeds

    def sensor(self, data: Array, name: str) -> Array:
        """Columns x and y (or the one column) of a sensor in an array of sensor data (T, nsensordata)."""
        sensor = self.model.sensor(name)
        return data[:, sensor.adr[0] : sensor.adr[0] + sensor.dim[0]]


def build(machine: Machine, settings: MuJoCoSettings, sensors: bool = True) -> Build:
    """Translate and compile; hardened where the settings say so."""
    kinematics = machine.kinematics
    form = model_form(kinematics.mechanism, settings.rod)
    tree = tree_of(machine, form)
    text = mjcf(tree, settings, f"conrod-{kinematics.mechanism.name}", sensors=sensors)
    model = compiled(text)
    if settings.hardening is not None:
        harden(model, settings.hardening)
    return Build(form, tree, model)
