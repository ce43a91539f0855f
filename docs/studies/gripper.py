"""A parallel gripper like a 2F-85: two four-bar fingers whose loops a `connect` closes, and the exact motion of a pad.

A finger in its own plane, y up: the driver turns about A, the follower about D, and the fingertip is pinned to the ends
B of the driver and C of the follower. As drawn it is a parallelogram, so the pad keeps its direction. With lengths b =
AB, c = BC, d = DC and a = AD, the driver at angle t and u = D - B at distance s and direction w,

    direction of BC = w - acos((c^2 + s^2 - d^2) / (2 c s)),    direction of DC = that of B + c e(direction of BC) - D

(a circle about B meets one about D; Norton, Design of Machinery, section 4.5).
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.exact.motion import Array

# As drawn [m]: lengths a, b, c, d of a finger, and how far each may be off, ISO 2768-1 m: 6 to 30 mm, 30 to 120 mm.
DRAWN = np.array([0.0184, 0.048, 0.0184, 0.048])
TOLERANCE = np.array([0.2e-3, 0.3e-3, 0.2e-3, 0.3e-3])
DRIVER_PIVOT = np.array([0.030, 0.055])  # A [m]
BASE_ANGLE = np.deg2rad(157.6)  # direction of AD, and of BC as drawn
PAD = np.array([-0.005, 0.045])  # from B as drawn, in the finger's plane [m]
OPEN, CLOSED = np.deg2rad(45.0), np.deg2rad(100.0)  # angle of the driver
CLOSING_TIME = 0.5  # [s]
SPEED = (CLOSED - OPEN) / CLOSING_TIME  # of the drivers [rad/s]
FLYWHEEL = 1e11  # armature of the drivers [kg m^2]
FINGERS = ("right", "left")

MODEL = """
<mujoco model="gripper">
  <compiler angle="radian"/>
  <option gravity="0 -9.81 0" timestep="{timestep}" solver="Newton" iterations="1" tolerance="0">
    <flag contact="disable" autoreset="disable"/>
  </option>
  <default>
    <joint axis="0 0 1"/>
    <geom type="capsule" contype="0" conaffinity="0" mass="0"/>
    <equality solref="{time_constant} 1" solimp="0.9999 0.9999 0.001"/>
  </default>
  <worldbody>
    {right}
    <frame quat="0 0 1 0">
      {left}
    </frame>
  </worldbody>
  <equality>
    <connect site1="right-tip-end" site2="right-follower-end"/>
    <connect site1="left-tip-end" site2="left-follower-end"/>
  </equality>
</mujoco>
"""
FINGER = """
<body name="{name}-driver" pos="{A[0]!r} {A[1]!r} 0">
  <joint name="{name}-driver" armature="{armature}"/>
  <inertial pos="{half_driver!r} 0 0" mass="0.02" diaginertia="4e-6 4e-6 4e-6"/>
  <geom fromto="0 0 0 {driver!r} 0 0" size="0.004"/>
  <body name="{name}-tip" pos="{driver!r} 0 0">
    <joint name="{name}-tip"/>
    <inertial pos="{middle[0]!r} {middle[1]!r} 0" mass="0.03" diaginertia="8e-6 8e-6 8e-6"/>
    <geom fromto="0 0 0 {tip!r} 0 0" size="0.004"/>
    <geom fromto="0 0 0 {pad[0]!r} {pad[1]!r} 0" size="0.006"/>
    <site name="{name}-tip-end" pos="{tip!r} 0 0"/>
    <site name="{name}-pad" pos="{pad[0]!r} {pad[1]!r} 0"/>
  </body>
</body>
<body name="{name}-follower" pos="{D[0]!r} {D[1]!r} 0">
  <joint name="{name}-follower"/>
  <inertial pos="{half_follower!r} 0 0" mass="0.01" diaginertia="2e-6 2e-6 2e-6"/>
  <geom fromto="0 0 0 {follower!r} 0 0" size="0.003"/>
  <site name="{name}-follower-end" pos="{follower!r} 0 0"/>
</body>
"""


def unit(angle: Array) -> Array:
    """Unit vectors (.., 2) in the directions of angles (..)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def pad_in_tip() -> Array:
    """The pad (2,) [m] in the fingertip's frame: origin B, x to C."""
    cos, sin = unit(np.asarray(BASE_ANGLE))
    return np.asarray(np.array([[cos, sin], [-sin, cos]]) @ PAD)


@dataclass(frozen=True)
class Fingers:
    """Exact motion of fingers with lengths a, b, c, d (.., 4) [m]."""

    lengths: Array

    def angles(self, driver: Array) -> tuple[Array, Array]:
        """Directions of BC and of DC (.., T) [rad] at driver angles (.., T) [rad]."""
        base, crank, tip, follower = (self.lengths[..., k, None] for k in range(4))
        end = base[..., None] * unit(np.asarray(BASE_ANGLE)) - crank[..., None] * unit(driver)  # u = D - B
        distance = np.hypot(end[..., 0], end[..., 1])
        opening = np.arccos((tip**2 + distance**2 - follower**2) / (2.0 * tip * distance))
        direction = np.arctan2(end[..., 1], end[..., 0]) - opening
        pin = tip[..., None] * unit(direction) - end  # from D to C
        return np.mod(direction, 2.0 * np.pi), np.arctan2(pin[..., 1], pin[..., 0])

    def rates(self, driver: Array) -> tuple[Array, Array]:
        """Rates of BC and of DC over that of the driver (.., T), of the loop's velocity equation."""
        tip_angle, follower_angle = self.angles(driver)
        _, crank, tip, follower = (self.lengths[..., k, None] for k in range(4))
        between = np.sin(follower_angle - tip_angle)
        return (
            crank * np.sin(driver - follower_angle) / (tip * between),
            crank * np.sin(driver - tip_angle) / (follower * between),
        )

    def pad(self, driver: Array, tip_angle: Array) -> Array:
        """The pad (.., T, 2) [m] from A, with a driver and a fingertip in given directions (.., T) [rad]."""
        along, across = pad_in_tip()
        ahead = unit(tip_angle)
        side = np.stack([-ahead[..., 1], ahead[..., 0]], axis=-1)
        return np.asarray(self.lengths[..., 1, None, None] * unit(driver) + along * ahead + across * side)


def gripper_model(lengths: Array, steps: int) -> mujoco.MjModel:
    """Compile a gripper of finger lengths (2, 4) [m] that closes in some steps."""
    timestep = CLOSING_TIME / steps
    pad = pad_in_tip().tolist()
    texts = {}
    for name, (base, driver, tip, follower) in zip(FINGERS, lengths.tolist(), strict=True):
        pivot = (DRIVER_PIVOT + base * unit(np.asarray(BASE_ANGLE))).tolist()
        texts[name] = FINGER.format(
            name=name, A=DRIVER_PIVOT.tolist(), D=pivot, pad=pad, middle=[0.5 * x for x in pad], armature=FLYWHEEL,
            driver=driver, tip=tip, follower=follower, half_driver=0.5 * driver, half_follower=0.5 * follower,
        )  # fmt: skip
    return mujoco.MjModel.from_xml_string(MODEL.format(timestep=timestep, time_constant=2.0 * timestep, **texts))


def coordinates(lengths: Array, driver: Array) -> Array:
    """Exact coordinates (n, T, 6) of grippers of finger lengths (n, 2, 4) [m] at driver angles (T,) [rad]."""
    at = np.broadcast_to(driver, (len(lengths), 2, len(driver)))
    tip, follower = Fingers(lengths).angles(at)
    return np.moveaxis(np.stack([at, tip - at, follower], axis=2), -1, 1).reshape(len(lengths), len(driver), 6)


def start_state(lengths: Array) -> tuple[Array, Array]:
    """Exact coordinates and rates (n, 6) of open grippers that begin to close."""
    at = np.full((len(lengths), 2, 1), OPEN)
    tip, follower = Fingers(lengths).rates(at)
    rates = SPEED * np.concatenate([np.ones_like(at), tip - 1.0, follower], axis=-1)
    return coordinates(lengths, np.array([OPEN]))[:, 0], rates.reshape(len(lengths), 6)
