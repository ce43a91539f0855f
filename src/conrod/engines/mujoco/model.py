"""The compiled model of a machine, and its start state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.left_out_rod import ModelForm, model_form
from conrod.engines.mujoco.closures import joint_name
from conrod.engines.mujoco.compiling import compiled
from conrod.engines.mujoco.coordinates import Coordinates
from conrod.engines.mujoco.hardening import harden
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import Tree, tree_of
from conrod.motion import Array

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
        """Where the model keeps the state of the tree."""
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
