"""The compiled MuJoCo model of a machine, its start state, and the callback that applies its load laws.

Compiling computes the convex hull of each mesh that can collide: one second for a cam of 4000 vertices, several times
as long as a coarse run. MuJoCo caches the hull of a mesh from a file for the life of the process, after which compiling
takes 5 ms; so vertices in a model's text are passed as a file in memory. The compiled model is the same to the last
bit, except for the path of that file.

MuJoCo calls `mjcb_act_bias` for the bias of an actuator whenever it evaluates forces, so at every stage of RK4, with
that stage's length, rate and time. A process has one such callback: it is set while it is needed, and the one before is
restored whatever happens.
"""

from __future__ import annotations

import hashlib
import struct
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from conrod.engines.engine import DeferredLibrary, Machine
from conrod.engines.mujoco import MuJoCoSettings, compat
from conrod.engines.mujoco.compiled_edits import harden
from conrod.engines.mujoco.loads import callback_loads, coordinate_offset, does_no_work, joint_name
from conrod.engines.mujoco.mjcf import mjcf_text
from conrod.engines.spanning_tree import SpanningTree, machine_tree
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact

if TYPE_CHECKING:
    import mujoco
else:
    mujoco = DeferredLibrary("mujoco")


def compile_mjcf(text: str) -> mujoco.MjModel:
    """Compile an MJCF text, with the vertices of its meshes passed as files in memory.

    Raises:
        ValueError: MuJoCo cannot compile the text.
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
    changed = compat.adapt_model(root) or files
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode") if changed else text, files)


@contextmanager
def apply_load_laws(model: mujoco.MjModel, tree: SpanningTree, begin: float = 0.0) -> Iterator[None]:
    """Make MuJoCo apply a machine's load laws inside the context, by a callback; for stepping in one thread.

    Args:
        begin: the machine's time [s] at which the engine's clock is 0.
    """
    laws = {
        int(model.actuator(load.name).id): (load.law, coordinate_offset(load, tree))
        for load in callback_loads(tree.mechanism)
        if not does_no_work(load, tree)
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


# Of free bodies out of the plane of motion [m, rad]: far above rounding; by its square, far below it, the points that
# are seen in the plane are off.
MAX_TILT = 1e-6


@dataclass(frozen=True)
class MuJoCoModel:
    """A compiled model with the spanning tree whose joint coordinates are its coordinates."""

    tree: SpanningTree
    model: mujoco.MjModel

    @property
    def crank_coordinate(self) -> int:
        """Index of the crank in qpos."""
        return int(self.model.joint("crank").qposadr[0])

    @property
    def crank_dof(self) -> int:
        """Index of the crank in qvel."""
        return int(self.model.joint("crank").dofadr[0])

    def start_state(self, machine: Machine, angle: float) -> tuple[Array, Array]:
        """Coordinates (nq,) and rates (nv,) of the exact motion at a crank angle [rad]."""
        poses, derivative = machine.kinematics.derivatives(np.array([angle]), 1)
        return self.coordinates(poses)[0], self.rates(poses, derivative * machine.speed)[0]

    def coordinates(self, poses: Array) -> Array:
        """Coordinates qpos (T, nq) [rad, m] of the model from poses (T, 3 n)."""
        found = np.zeros((len(poses), self.model.nq))
        found[:, [place for place, _ in self._joint_addresses]] = self.tree.coordinates(poses)
        for place, _, own in self._free_bodies.values():
            # A place in space, and the quaternion (cos a/2, 0, 0, sin a/2) of a rotation by a about z.
            x, y, turn = poses[:, own].T
            found[:, place : place + 7] = 0.0
            columns = [place, place + 1, place + 3, place + 6]
            found[:, columns] = np.column_stack([x, y, np.cos(0.5 * turn), np.sin(0.5 * turn)])
        return found

    def rates(self, poses: Array, rates: Array) -> Array:
        """Rates qvel (T, nv) [rad/s, m/s] of the model from poses and their rates (T, 3 n)."""
        found = np.zeros((len(poses), self.model.nv))
        found[:, [rate for _, rate in self._joint_addresses]] = self.tree.rates(poses, rates)
        for _, rate, own in self._free_bodies.values():
            found[:, rate : rate + 6] = 0.0
            found[:, [rate, rate + 1, rate + 5]] = rates[:, own]
        return found

    def forward_kinematics(self, coordinates: Array, rates: Array, before: Array | None = None) -> tuple[Array, Array]:
        """Poses and their rates (T, 3 n) from coordinates qpos (T, nq) and rates qvel (T, nv).

        Args:
            before: poses (3 n,) before the first ones, from which whole turns of free bodies are counted; the poses at
                crank angle 0 by default.
        """
        known: dict[str, tuple[Array, Array]] = {}
        for body, (place, rate, own) in self._free_bodies.items():
            turn = 2.0 * np.arctan2(coordinates[:, place + 6], coordinates[:, place + 3])
            # Whole turns are counted, so that the same bits come of a run wherever it is cut.
            steps = np.diff(turn, prepend=(self.tree.start if before is None else before)[own][2])
            turn = turn - 2.0 * np.pi * np.cumsum(np.rint(steps / (2.0 * np.pi)))
            pose = np.column_stack([coordinates[:, place : place + 2], turn])
            known[body] = pose, rates[:, [rate, rate + 1, rate + 5]]
        places, rate_places = [place for place, _ in self._joint_addresses], [rate for _, rate in self._joint_addresses]
        return self.tree.forward_kinematics(coordinates[:, places], rates[:, rate_places], known)

    @cached_property
    def _joint_addresses(self) -> list[tuple[int, int]]:
        """Indices in qpos and in qvel of the joint of each branch, or of the first coordinate of a free body."""
        joints = [self.model.joint(joint_name(self.tree, branch)) for branch in self.tree.branches]
        return [(int(joint.qposadr[0]), int(joint.dofadr[0])) for joint in joints]

    @cached_property
    def _free_bodies(self) -> dict[str, tuple[int, int, slice]]:
        """Bodies with six degrees of freedom: first index in qpos and in qvel, and columns in poses (T, 3 n)."""
        found = {}
        for branch, (place, rate) in zip(self.tree.branches, self._joint_addresses, strict=True):
            if self.model.joint(joint_name(self.tree, branch)).type[0] == mujoco.mjtJoint.mjJNT_FREE:
                first = 3 * self.tree.mechanism.body_index[branch.child]
                found[branch.child] = place, rate, slice(first, first + 3)
        return found

    def find_tilted_body(self, coordinates: Array) -> str | None:
        """Name of a free body that has left the plane of motion in coordinates (T, nq), or None."""
        size = max(1.0, float(np.abs(self.tree.start).max()))
        for body, (place, _, _) in self._free_bodies.items():
            # Height, and two components of the quaternion, which are half the tilts.
            out = coordinates[:, [place + 2, place + 4, place + 5]]
            if np.abs(out).max() > MAX_TILT * size:
                return body
        return None

    def inverse_weight(self, closure: str) -> float:
        """Compiled inverse weight [1/kg] of a closure, given its name."""
        equality = self.model.equality(closure)
        if equality.type[0] == mujoco.mjtEq.mjEQ_TENDON:
            return float(self.model.tendon_invweight0[self.model.eq_obj1id[equality.id]])
        return float(self.model.body_invweight0[compat.equality_bodies(self.model, equality.id), 0].sum())

    def cam_and_roller_geoms(self, contact: CamContact) -> tuple[int, int]:
        """Indices of the geoms of cam and roller."""
        return int(self.model.geom(f"{contact.a}.profile").id), int(self.model.geom(f"{contact.b}.roller").id)

    def sensor_column(self, name: str, axis: int) -> int:
        """Column of one number of a sensor in sensor data (T, nsensordata)."""
        return int(self.model.sensor(name).adr[0]) + axis

    def sensor_values(self, data: Array, name: str) -> Array:
        """Columns of one sensor in sensor data (T, nsensordata)."""
        sensor = self.model.sensor(name)
        return data[:, sensor.adr[0] : sensor.adr[0] + sensor.dim[0]]


def build(machine: Machine, settings: MuJoCoSettings, sensors: bool = True) -> MuJoCoModel:
    """Translate a machine to MJCF and compile it, hardened if the settings say so."""
    kinematics = machine.kinematics
    tree = machine_tree(machine)
    model = compile_mjcf(mjcf_text(tree, settings, f"conrod-{kinematics.mechanism.name}", sensors=sensors))
    if settings.hardening is not None:
        harden(model, settings.hardening)
    return MuJoCoModel(tree, model)


def constraint_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Jacobian (nefc, nv) of all active constraints, as a dense array for sparse models too."""
    if not mujoco.mj_isSparse(model):
        # MuJoCo keeps it as it is. No entry is -0.0, dense or sparse.
        return np.array(np.ravel(data.efc_J)[: data.nefc * model.nv].reshape(data.nefc, model.nv) + 0.0)
    jacobian, places = np.zeros((data.nefc, model.nv)), (data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    mujoco.mju_sparse2dense(jacobian, np.ravel(data.efc_J), *map(np.ravel, places))
    return jacobian + 0.0


def equality_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Jacobian (rows, nv) of the active equality constraints, the first rows of all constraints."""
    return constraint_jacobian(model, data)[: data.ne]
