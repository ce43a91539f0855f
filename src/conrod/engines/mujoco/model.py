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
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.mujoco import MuJoCoSettings, older
from conrod.engines.mujoco.compiled_edits import harden
from conrod.engines.mujoco.loads import by_program, joint_name, moves_nothing, origin_of
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.spanning_tree import SpanningTree, machine_tree
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact


def compiled(text: str) -> mujoco.MjModel:
    """The model of an MJCF text.

    Raises:
        ValueError: MuJoCo cannot compile it.
    """
    root = ET.fromstring(text)
    files = {}
    for mesh in root.iterfind("asset/mesh"):
        # MuJoCo's MSH format: four counts, then single precision.
        numbers = np.array(mesh.attrib.pop("vertex").split(), dtype=np.float32)
        content = struct.pack("4i", len(numbers) // 3, 0, 0, 0) + numbers.tobytes()
        # Named after its content: whatever the cache compares, two meshes are never taken for one.
        name = f"{hashlib.sha256(content).hexdigest()}.msh"
        mesh.set("file", name)
        files[name] = content
    changed = older.adapt(root) or files
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode") if changed else text, files)


@contextmanager
def laws_acting(model: mujoco.MjModel, tree: SpanningTree, begin: float = 0.0) -> Iterator[None]:
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


@dataclass(frozen=True)
class Build:
    """A compiled model with the tree that its coordinates belong to; states are those of all links."""

    tree: SpanningTree
    model: mujoco.MjModel

    @property
    def crank_coordinate(self) -> int:
        """Index of the crank among the coordinates."""
        return int(self.model.joint("crank").qposadr[0])

    @property
    def crank_dof(self) -> int:
        """Index of the crank among the rates."""
        return int(self.model.joint("crank").dofadr[0])

    def start_state(self, machine: Machine, angle: float) -> tuple[Array, Array]:
        """Joint coordinates and rates of the exact motion at a crank angle."""
        poses, slopes = machine.kinematics.derivatives(np.array([angle]), 1)
        return self.coordinates(poses)[0], self.rates(poses, slopes * machine.speed)[0]

    def coordinates(self, poses: Array) -> Array:
        """Model coordinates (T, nq) of poses (T, 3 n)."""
        found = np.zeros((len(poses), self.model.nq))
        found[:, [place for place, _ in self._joints]] = self.tree.coordinates(poses)
        return found

    def rates(self, poses: Array, rates: Array) -> Array:
        """Model rates (T, nv) of rates of the poses (T, 3 n); a joint's rate is linear in them."""
        found = np.zeros((len(poses), self.model.nv))
        found[:, [rate for _, rate in self._joints]] = self.tree.rates(poses, rates)
        return found

    def forward_kinematics(self, coordinates: Array, rates: Array) -> tuple[Array, Array]:
        """Poses and their rates (T, 3 n) of coordinates (T, nq) and rates (T, nv)."""
        places, rate_places = [place for place, _ in self._joints], [rate for _, rate in self._joints]
        return self.tree.forward_kinematics(coordinates[:, places], rates[:, rate_places])

    @cached_property
    def _joints(self) -> list[tuple[int, int]]:
        """Of the joint of each of the tree's branches, the places of its coordinate and of its rate."""
        joints = [self.model.joint(joint_name(self.tree, branch)) for branch in self.tree.branches]
        return [(int(joint.qposadr[0]), int(joint.dofadr[0])) for joint in joints]

    def inverse_weight(self, closure: str) -> float:
        """Compiled inverse weight [1/kg] of what closes a loop, by its name."""
        equality = self.model.equality(closure)
        if equality.type[0] == mujoco.mjtEq.mjEQ_TENDON:
            return float(self.model.tendon_invweight0[self.model.eq_obj1id[equality.id]])
        return float(self.model.body_invweight0[older.bodies_of(self.model, equality.id), 0].sum())

    def geoms(self, contact: CamContact) -> tuple[int, int]:
        """Indices of cam and roller."""
        return int(self.model.geom(f"{contact.a}.profile").id), int(self.model.geom(f"{contact.b}.roller").id)

    def sensor(self, data: Array, name: str) -> Array:
        """Columns x and y (or the one column) of a sensor in an array of sensor data (T, nsensordata)."""
        sensor = self.model.sensor(name)
        return data[:, sensor.adr[0] : sensor.adr[0] + sensor.dim[0]]


def build(machine: Machine, settings: MuJoCoSettings, sensors: bool = True) -> Build:
    """Translate and compile; hardened where the settings say so."""
    kinematics = machine.kinematics
    tree = machine_tree(machine)
    model = compiled(mjcf(tree, settings, f"conrod-{kinematics.mechanism.name}", sensors=sensors))
    if settings.hardening is not None:
        harden(model, settings.hardening)
    return Build(tree, model)


def constraint_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Jacobian (nefc, nv) of all constraints in the data, dense whatever the model uses."""
    jacobian = np.empty((data.nefc, model.nv))
    for k, direction in enumerate(np.eye(model.nv)):
        column = np.empty(data.nefc)
        mujoco.mj_mulJacVec(model, data, column, direction)
        jacobian[:, k] = column
    return jacobian


def equality_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Jacobian (rows, nv) of the active equality constraints, which come first among the constraints."""
    return constraint_jacobian(model, data)[: data.ne]
