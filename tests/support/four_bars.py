"""Four-bars in space as small MuJoCo models, by their lengths, and where their pins are; any model driven by laws."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.exact.space.mobility import check_drives
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.reading import tree_of

# Where the frame stands, and how it is turned.
FRAME = 'pos="0.3 -0.2 0.5" quat="0.8 -0.4 0.2 0.4"'
GRASHOF = (0.1, 0.25, 0.3, 0.35)  # crank, coupler, rocker, ground [m]


def rocker_pin(lengths: tuple[float, float, float, float], crank: float, branch: float = 1.0) -> Array:
    """The pin of coupler and rocker (2,) [m] in the plane of the frame, the crank's pivot its origin."""
    a, b, c, d = lengths
    pin = a * np.array([math.cos(crank), math.sin(crank)])
    way = np.array([d, 0.0]) - pin
    length = float(np.linalg.norm(way))
    along = (b * b - c * c + length**2) / (2.0 * length)
    across = branch * math.sqrt(b * b - along**2)
    return pin + (along * way + across * np.array([-way[1], way[0]])) / length


def start_angles(lengths: tuple[float, float, float, float], crank: float, branch: float = 1.0) -> tuple[float, ...]:
    """Coordinates of the model's joints crank, coupler and rocker [rad]."""
    pin = lengths[0] * np.array([math.cos(crank), math.sin(crank)])
    far = rocker_pin(lengths, crank, branch)
    coupler, rocker = far - pin, far - [lengths[3], 0.0]
    return crank, math.atan2(coupler[1], coupler[0]) - crank, math.atan2(rocker[1], rocker[0])


def four_bar(
    lengths: tuple[float, float, float, float] = GRASHOF, crank: float = 1.0, branch: float = 1.0, keys: str = "",
    joint: str = "", closure: str = "", more: str = "", option: str = "", frame: str = FRAME,
) -> str:  # fmt: skip
    """The model, assembled on a branch at a crank angle [rad]; coordinates are angles in the plane from there on.

    Args:
        joint, closure, option: more attributes of the crank's joint, the closure and the option.
        keys, more: keyframes, and elements beside the world.
    """
    a, b, c, d = lengths
    one, two, three = (repr(angle) for angle in start_angles(lengths, crank, branch))
    inertial = '<inertial pos="{} 0.01 0.02" mass="{}" diaginertia="0.001 0.002 0.0025"/>'
    return f"""<mujoco><compiler angle="radian"/><option timestep="0.001" {option}>
    <flag contact="disable"/></option>
    <worldbody><body name="frame" {frame}>
      <body name="crank" quat="{_about_z(one)}"><joint name="crank" axis="0 0 1" ref="{one}" {joint}/>
        {inertial.format(a / 2, 1.0)}<site name="A" pos="{a} 0 0"/>
        <body name="coupler" pos="{a} 0 0" quat="{_about_z(two)}"><joint name="coupler" axis="0 0 1" ref="{two}"/>
          {inertial.format(b / 2, 0.8)}<site name="B" pos="{b} 0 0"/></body></body>
      <body name="rocker" pos="{d} 0 0" quat="{_about_z(three)}"><joint name="rocker" axis="0 0 1" ref="{three}"/>
        {inertial.format(c / 2, 1.2)}<site name="C" pos="{c} 0 0"/></body>
    </body></worldbody>
    <equality><connect name="pin" site1="B" site2="C" {closure}/></equality>{more}
    <keyframe>{keys}</keyframe></mujoco>"""


def in_millimetres(text: str) -> str:
    """The four-bar of tests/data/cases, written in millimetres and kilograms."""
    for metres in ("0.26 ", "0.22 ", "0.008", "0.1 0", "0.3 0", "0.01"):
        number, space, rest = metres.partition(" ")
        size = f"{1e3 * float(number):g}{space}{rest}"
        text = text.replace(f'"{metres}', f'"{size}').replace(f" {metres}", f" {size}")
    return text.replace('density="2000"', 'density="2e-6"')


def key(name: str, lengths: tuple[float, float, float, float], crank: float, branch: float) -> str:
    """A keyframe with the four-bar assembled so."""
    return f'<key name="{name}" qpos="{" ".join(map(repr, start_angles(lengths, crank, branch)))}"/>'


def _about_z(angle: str) -> str:
    half = 0.5 * float(angle)
    return f"{math.cos(half)!r} 0 0 {math.sin(half)!r}"


def driven(model: mujoco.MjModel | str, drives: dict[str, str], seconds: float = 1.0) -> DrivenTree:
    """A model's machine after it went along its motion, from its reference pose."""
    if isinstance(model, str):
        model = mujoco.MjModel.from_xml_string(model)
    tree = tree_of(model, model.qpos0)
    joints = {joint.name: joint for joint in tree.joints if joint.name in drives}
    laws = {j: parse_drive_law(law, joints[j].unit, tree.start[joints[j].coordinate], j) for j, law in drives.items()}
    made = DrivenTree(tree, laws)
    start = made.assemble_start()
    check_drives(made, start)
    made.track_branch(start, seconds)
    return made
