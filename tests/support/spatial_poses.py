"""Drives of the spatial machines by their laws, and their MuJoCo models in given poses."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mechanism.units import parse_quantity
from conrod.scenes.space import SpatialMachine


def driven(machine: SpatialMachine, times: Array, order: int = 0) -> dict[str, Array]:
    """Coordinate of each driven joint under its law, with derivatives by time: (order + 1, T)."""
    return {joint: _law(law, times, order) for joint, law in machine.drives.items()}


def _law(law: str, times: Array, order: int) -> Array:
    if not law.startswith("sine:"):
        speed = parse_quantity("speed", law, "rad/s")
        return np.array([speed * times, np.full_like(times, speed), *np.zeros((2, len(times)))])[: order + 1]
    amplitude, frequency = law.removeprefix("sine:").split(",")
    height = parse_quantity("amplitude", amplitude, "m" if amplitude.endswith("mm") else "rad")
    rate = 2.0 * math.pi * float(frequency.removesuffix("Hz"))
    return np.array([height * rate**k * np.sin(rate * times + 0.5 * math.pi * k) for k in range(order + 1)])


class Model:
    """The compiled model of a machine, in poses and with rates that the closed form gives."""

    def __init__(self, machine: SpatialMachine) -> None:
        self.machine = machine
        self.model = mujoco.MjModel.from_xml_string(machine.mjcf)
        self.data = mujoco.MjData(self.model)

    def put(self, drives: dict[str, Array], sample: int, machine: SpatialMachine | None = None) -> None:
        """Every joint where the closed form of this machine, or of another like it, has it at a sample."""
        source = machine or self.machine
        for joint, values in source.joints(drives).items():
            address = self.model.joint(joint)
            self.data.qpos[address.qposadr[0]] = values[0, sample]
            if len(values) > 1:
                self.data.qvel[address.dofadr[0]] = values[1, sample]
        if self.machine.name == "rssr-idle-spin":
            self._aim_rod(source.points(drives), drives["input"], sample)
        mujoco.mj_fwdPosition(self.model, self.data)
        mujoco.mj_fwdVelocity(self.model, self.data)

    def _aim_rod(self, points: dict[str, Array], turn: Array, sample: int) -> None:
        """The ball that carries the rod: turned the shortest way, for its spin about itself is anyone's."""
        rod = points["rocker_pin"][0, sample] - points["crank_pin"][0, sample]
        cosine, sine = math.cos(turn[0, sample]), math.sin(turn[0, sample])
        aim = np.array([cosine * rod[0] + sine * rod[1], cosine * rod[1] - sine * rod[0], rod[2]])
        start = self.model.site("rod_end").pos
        quaternion = np.array([start @ start + start @ aim, *np.cross(start, aim)])
        address = self.model.joint("rod").qposadr[0]
        self.data.qpos[address : address + 4] = quaternion / np.linalg.norm(quaternion)

    @property
    def rows(self) -> Array:
        """Which rows of the constraints are of closures."""
        return np.flatnonzero(self.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)

    @property
    def opening(self) -> float:
        """The farthest that a closure is open [m] or [rad]."""
        return float(np.abs(self.data.efc_pos[self.rows]).max())

    @property
    def rank(self) -> int:
        """Number of independent equations of the closures."""
        jacobian = self.data.efc_J.reshape(-1, self.model.nv)[self.rows]
        return int(np.linalg.matrix_rank(jacobian, tol=1e-9))
