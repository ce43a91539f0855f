"""Planar machines that stand anywhere in space, turned, on a base that moves: they move as in their plane, and carry
what they carry there.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import cache

import mujoco
import numpy as np
import pytest
from four_bars import driven

from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.exact.dynamics.inverse import JointForces, State, joint_forces
from conrod.exact.jet import Jet
from conrod.exact.motion import Array
from conrod.exact.space.mobility import SpatialForces, forces
from conrod.exact.space.motion import DrivenTree
from conrod.scenes import scene_named
from conrod.scenes.scene import Scene
from conrod.scenes.space.machine import turned

QUATERNION = np.array([0.4, -0.5, 0.6, 0.3]) / np.linalg.norm([0.4, -0.5, 0.6, 0.3])
PLACE = np.array([0.7, -0.2, 1.1])
# Axis of both of a base's joints in its frame, and their laws.
ALONG = np.array([2.0, -1.0, 2.0]) / 3.0
BASE = {"base_slide": "sine:0.1,3Hz", "base_turn": "2rad/s"}


@cache
def scene(name: str) -> Scene:
    return scene_named(name)


def model_text(name: str, moving: bool = False, gravity: Array | None = None) -> ET.Element:
    """A scene's model in a frame at `PLACE`, turned by `QUATERNION`, with no more than moves in it.

    Args:
        moving: the frame slides and turns by `BASE`.
        gravity: (3,) [m/s^2] in the frame, turned as it is.
    """
    root = ET.fromstring(standalone_mjcf(name, scene(name)))
    for tag in ("asset", "sensor", "keyframe", "visual", "statistic"):
        for element in root.findall(tag):
            root.remove(element)
    world = root.find("worldbody")
    frame = ET.Element("body", name="frame", pos=text(PLACE), quat=text(QUATERNION))
    for element in list(world):
        world.remove(element)
        if element.tag in ("body", "site"):
            frame.append(element)
    for body in [frame, *frame.iter("body")]:
        for geom in body.findall("geom"):
            body.remove(geom)
    for element in frame.iter("joint"):
        element.attrib.pop("armature", None)
    if moving:
        ET.SubElement(frame, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
        ET.SubElement(frame, "joint", name="base_slide", type="slide", axis=text(ALONG))
        ET.SubElement(frame, "joint", name="base_turn", type="hinge", axis=text(ALONG), pos="0.1 0.2 0.3")
    world.append(frame)
    field = np.zeros(3) if gravity is None else frame_matrix() @ gravity
    root.find("option").set("gravity", text(field))
    return root


def text(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def frame_matrix() -> Array:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, QUATERNION)
    return matrix.reshape(3, 3)


def placed_and_driven(name: str, root: ET.Element, duration: float) -> DrivenTree:
    """The model's machine after it went along its motion."""
    laws = {"crank": repr(scene(name).speed)} | (BASE if root.find(".//joint[@name='base_turn']") is not None else {})
    return driven(ET.tostring(root, encoding="unicode"), laws, duration)


def duration(name: str) -> float:
    """One turn, or the pass that the input makes but for its ends [s]."""
    span = scene(name).kinematics.mechanism.driver.span
    return (2.0 * np.pi if span is None else 0.999 * (span[1] - span[0])) / abs(scene(name).speed)


def crank_angles(name: str, times: Array) -> Array:
    span = scene(name).kinematics.mechanism.driver.span
    return (0.0 if span is None else span[0]) + scene(name).speed * times


def exact_points(name: str, times: Array, moving: bool = False) -> dict[str, Array]:
    """conrod's planar motion (4, T, 3) of the observed points, placed in space by the formulas of turned vectors."""
    found = {}
    for point, planar in scene(name).motion(crank_angles(name, times), scene(name).speed).points.items():
        parts = [planar.position, planar.velocity, planar.acceleration / 2.0, planar.jerk / 6.0]
        placed = Jet([np.concatenate([part, np.zeros((len(times), 1))], axis=1) for part in parts])
        if moving:
            anchor = np.array([0.1, 0.2, 0.3])
            turn = _law("base_turn", times)
            placed = turned(placed - anchor, ALONG, turn) + anchor + _law("base_slide", times) * ALONG
        coefficients = [np.asarray(part) @ frame_matrix().T for part in placed.coefficients]
        found[point] = np.array(
            [coefficients[0] + PLACE, coefficients[1], 2.0 * coefficients[2], 6.0 * coefficients[3]]
        )
    return found


def _law(joint: str, times: Array) -> Jet:
    if joint == "base_turn":
        return Jet([(2.0 * times)[:, None], np.full((len(times), 1), 2.0), *np.zeros((2, len(times), 1))])
    rate = 6.0 * np.pi
    waves = [0.1 * rate**k * np.sin(rate * times + 0.5 * np.pi * k)[:, None] for k in range(4)]
    return Jet([wave / factor for wave, factor in zip(waves, (1.0, 1.0, 2.0, 6.0), strict=True)])


# -- motion -----------------------------------------------------------------------------------------------------------

# Pins and slides, wheels, and an input that makes one pass; a pin in a slot, a rack and a wheel on a line.
SCENES = (
    "six-bar",
    "planetary-gear",
    "swinging-four-bar",
    *(pytest.param(name, marks=pytest.mark.slow) for name in ("geneva", "rack-and-wheel", "rolling-on-flat")),
)
BAR = 1e-10


def worst(found: DrivenTree, truth: dict[str, Array], times: Array, rate: float) -> float:
    """Largest deviation of position, velocity, acceleration and jerk, over the travel and its rates."""
    motion = found.motion(times)
    travel = max(np.ptp(points[0], axis=0).max() for points in truth.values())
    off = 0.0
    for name, points in truth.items():
        one = motion.points[name]
        for order, values in enumerate((one.position, one.velocity, one.acceleration, one.jerk)):
            size = max(travel * rate**order, np.abs(points[order]).max() if order else 0.0)
            off = max(off, np.abs(values - points[order]).max() / size)
    return off


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("name", SCENES)
def test_a_placed_scene_moves_as_in_its_plane(name: str, moving: bool) -> None:
    end = duration(name)
    times = np.linspace(0.0, end, 90)
    truth = exact_points(name, times, moving)
    found = placed_and_driven(name, model_text(name, moving), end)
    assert worst(found, truth, times, abs(scene(name).speed)) < BAR


def test_a_pin_a_hundredth_of_a_millimetre_off_is_another_machine() -> None:
    # Negative control.
    root = model_text("six-bar")
    pin = next(site for site in root.iter("site") if site.get("name") == "D.ternary")
    pin.set("pos", "0.53001 0 0")
    times = np.linspace(0.0, duration("six-bar"), 30)
    off = worst(
        placed_and_driven("six-bar", root, times[-1]), exact_points("six-bar", times), times, scene("six-bar").speed
    )
    assert 1e-6 < off < 1e-1


# -- forces -----------------------------------------------------------------------------------------------------------

# Machines of pins and slides without loads.
WITH_FORCES = ("saw-40rpm", "six-bar")


def planar(name: str, times: Array) -> JointForces:
    """The same machine's forces in its plane, at constant speed."""
    speed = np.full_like(times, scene(name).speed)
    state = State(crank_angles(name, times), speed, np.zeros_like(times), times)
    return joint_forces(scene(name).kinematics, state)


def placed(name: str) -> tuple[DrivenTree, Array, SpatialForces]:
    root = model_text(name, gravity=np.array([*scene(name).kinematics.mechanism.gravity, 0.0]))
    times = np.linspace(0.0, duration(name), 40)
    machine = placed_and_driven(name, root, times[-1])
    return machine, times, forces(machine, machine.motion(times))


@pytest.mark.parametrize("name", WITH_FORCES)
def test_torque_and_reactions_are_those_in_the_plane(name: str) -> None:
    machine, times, found = placed(name)
    truth = planar(name, times)
    torque = found.drives["crank"]
    assert torque == pytest.approx(truth.drive_torque, abs=1e-9 * np.abs(truth.drive_torque).max())
    second = {joint.name: joint.b for joint in scene(name).kinematics.mechanism.joints}
    for closure in machine.tree.closures:
        exact, first = truth.components[closure.name], machine.tree.bodies[closure.points[0].body].name
        in_plane = np.array([exact["x"], exact["y"], np.zeros_like(times)])
        # In the plane the force is that on the second body.
        seen = (1.0 if first == second[closure.name] else -1.0) * frame_matrix().T @ found.least[closure.name].T
        assert seen == pytest.approx(in_plane, abs=1e-9 * np.abs(in_plane).max()), closure.name
    # Negative control: a thousandth more speed asks for another torque.
    faster = planar(name, times * 1.001)
    assert np.abs(torque - faster.drive_torque).max() > 1e-6 * np.abs(torque).max()
