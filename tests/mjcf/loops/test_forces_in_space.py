"""Driving torques and reactions of machines in space, against energy, and against those of planar machines."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest
from four_bars import driven, four_bar
from scipy.spatial.transform import Rotation

from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.exact.dynamics.inverse import joint_forces
from conrod.exact.motion import Array, Instants
from conrod.exact.space.mobility import forces
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.reading import tree_of
from conrod.models.loops.study import _LoopBench
from conrod.scenes import scene_named
from conrod.scenes.space import MACHINES


@pytest.mark.parametrize(("name", "open_ones"), [("stewart", set()), ("cardan", {"cross_1", "cross_2"})])
def test_reactions_are_indeterminate_only_at_redundant_closures(name: str, open_ones: set[str]) -> None:
    machine = MACHINES[name]()
    found, motion = moved(machine.mjcf, dict(machine.drives), 0.2)
    assert set(forces(found, motion).indeterminate) == open_ones


def moved(
    model: mujoco.MjModel | str, drives: dict[str, str], seconds: float, samples: int = 9
) -> tuple[DrivenTree, SpatialMotion]:
    machine = driven(model, drives, seconds)
    return machine, machine.motion(np.linspace(0.0, seconds, samples))


def with_springs(text: str) -> mujoco.MjModel:
    """Every hinge and slide with a spring, a damper and an armature of its own."""
    root = ET.fromstring(text)
    for number, joint in enumerate(root.iter("joint")):
        if joint.get("joint1") is None and joint.get("type", "hinge") in ("hinge", "slide"):
            own = {"stiffness": 3.0 + number, "springref": 0.1 * number, "damping": 0.2, "armature": 0.01 * number}
            joint.attrib |= {key: repr(value) for key, value in own.items()}
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))


def power_imbalance(model: mujoco.MjModel, drives: dict[str, str], seconds: float, stiffer: float = 1.0) -> float:
    """What drives give less what dampers take and less the change of the energy, over the largest power of a drive.

    Args:
        stiffer: of the first spring, where its energy is computed.
    """
    machine, motion = moved(model, drives, seconds, 401)
    found = forces(machine, motion)
    given = sum(found.drives[joint.name] * motion.rates[0, joint.rate] for joint in machine.driven)
    taken = np.einsum("v,vt->t", model.dof_damping, motion.rates[0] ** 2)
    # The energy by MuJoCo, in which nothing of the forces is.
    model.jnt_stiffness[0] *= stiffer
    data, energy = mujoco.MjData(model), []
    for k in range(len(motion.times)):
        data.qpos[:], data.qvel[:] = motion.coordinates[:, k], motion.rates[0, :, k]
        mujoco.mj_forward(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        energy.append(data.energy.sum())
    step = motion.times[1]
    stencil = np.array([1.0, -9.0, 45.0, 0.0, -45.0, 9.0, -1.0]) / (60.0 * step)
    change = np.convolve(energy, stencil, "valid")
    return float(np.abs((given - taken)[3:-3] - change).max() / np.abs(given).max())


@pytest.mark.parametrize("name", ["rssr", "tilted-slider-crank", pytest.param("stewart", marks=pytest.mark.slow)])
def test_what_drives_give_is_what_dampers_take_and_energy_gains(name: str) -> None:
    machine = MACHINES[name]()
    model = with_springs(machine.mjcf)
    drives = {joint: law.replace("60rpm", "sine:50deg,1Hz") for joint, law in machine.drives.items()}
    assert power_imbalance(model, drives, 0.5) < 1e-9
    assert power_imbalance(model, drives, 0.5, stiffer=1.001) > 1e-7  # negative control


def test_disabled_springs_and_dampers_need_no_torque() -> None:
    sprung = four_bar().replace('<joint name="coupler"', '<joint name="coupler" stiffness="5" damping="0.3"')
    off = sprung.replace('contact="disable"', 'contact="disable" spring="disable" damper="disable"')
    torques, named = [], []
    for text in (four_bar(), sprung, off):
        machine, motion = moved(text, {"crank": "60rpm"}, 1.0)
        torques.append(forces(machine, motion).drives["crank"])
        named += machine.tree.unmodelled
    assert torques[2] == pytest.approx(torques[0], abs=1e-12)
    assert np.abs(torques[1] - torques[0]).max() > 1e-2
    assert named == []
    for what, text in UNMODELLED.items():
        model = mujoco.MjModel.from_xml_string(text)
        assert tree_of(model, model.qpos0).unmodelled == (what,)


UNMODELLED = {
    "armatures of tendons": four_bar(
        more='<tendon><fixed armature="0.1"><joint joint="rocker" coef="1"/></fixed></tendon>'
    ),
}

MOTOR = '<actuator><{} joint="rocker"/></actuator>'
# What a file has, and what of it acts in its driven run; where nothing does, forces are compared.
FORCES = {
    "a servo": (four_bar(more=MOTOR.format('position kp="5"')), ("the force of actuator 0",)),
    "a motor at rest": (four_bar(more=MOTOR.format("motor")), ()),
    "a damper that is not linear": (
        four_bar().replace('<joint name="coupler"', '<joint name="coupler" damping="0.1 0.2"'),
        ("the damper of joint coupler",),
    ),
    "a damper that is": (four_bar().replace('<joint name="coupler"', '<joint name="coupler" damping="0.1"'), ()),
}


@pytest.mark.parametrize("what", FORCES)
def test_forces_are_compared_unless_others_act_in_the_run(what: str) -> None:
    text, expected = FORCES[what]
    bench = _LoopBench.from_request(mujoco.MjModel.from_xml_string(text), LoopRequest({"crank": "60rpm"}, seconds=0.1))
    run = bench._run("hardened", 1.0, 0.1, {})
    assert bench._unknown_forces(run.acting) == expected
    assert bool(run.drives) == (not expected)
    assert all(off < 1e-6 for off in run.drives.values())


# -- planar machines that stand anywhere, turned, move as in their plane and carry what they carry there ---------------

# (w, x, y, z), and what it turns by.
QUATERNION, PLACE = np.array([0.4, -0.5, 0.6, 0.3]), np.array([0.7, -0.2, 1.1])
TURN = Rotation.from_quat(np.roll(QUATERNION, -1)).as_matrix()


def text(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def model_of(name: str) -> ET.Element:
    """A scene's model in a frame at `PLACE`, turned by `QUATERNION` as gravity is, with no more than moves in it."""
    root = ET.fromstring(standalone_mjcf(name, scene_named(name)))
    for tag in ("asset", "sensor", "keyframe", "visual", "statistic"):
        for element in root.findall(tag):
            root.remove(element)
    world = root.find("worldbody")
    frame = ET.Element("body", name="frame", pos=text(PLACE), quat=text(QUATERNION))
    frame.extend(element for element in world if element.tag in ("body", "site"))
    world[:] = [frame]
    for body in frame.iter("body"):
        for geom in body.findall("geom"):
            body.remove(geom)
        for joint in body.findall("joint"):
            joint.attrib.pop("armature", None)
    root.find("option").set("gravity", text(TURN @ [*scene_named(name).kinematics.mechanism.gravity, 0.0]))
    return root


def course(name: str, samples: int) -> tuple[Array, Array]:
    """Times and crank angles of one turn, or of the pass that the input makes but for its ends."""
    speed, span = scene_named(name).speed, scene_named(name).kinematics.mechanism.driver.span
    begin, way = (0.0, 2.0 * np.pi) if span is None else (span[0], 0.999 * (span[1] - span[0]))
    times = np.linspace(0.0, way / abs(speed), samples)
    return times, begin + speed * times


def off_in_space(name: str, root: ET.Element) -> float:
    """Largest deviation of position, velocity, acceleration and jerk, over the travel and its rates."""
    times, angles = course(name, 60)
    scene, off = scene_named(name), 0.0
    motion = machine(name, root).motion(times)
    planar = scene.motion(angles, scene.speed).points
    travel = max(np.ptp(one.position, axis=0).max() for one in planar.values())
    for point, one in planar.items():
        for order, field in enumerate(("position", "velocity", "acceleration", "jerk")):
            truth = getattr(one, field) @ TURN[:, :2].T + (PLACE if order == 0 else 0.0)
            size = max(travel * abs(scene.speed) ** order, np.abs(truth).max() if order else 0.0)
            off = max(off, np.abs(getattr(motion.points[point], field) - truth).max() / size)
    return off


def machine(name: str, root: ET.Element) -> DrivenTree:
    """The model's machine after it went along its motion."""
    law = {"crank": repr(scene_named(name).speed)}
    return driven(ET.tostring(root, encoding="unicode"), law, course(name, 2)[0][-1])


# Pins and slides, wheels, and an input that makes one pass; a pin in a slot, a rack and a wheel on a line.
SLOW = (pytest.param(name, marks=pytest.mark.slow) for name in ("geneva", "rack-and-wheel", "rolling-on-flat"))


@pytest.mark.parametrize("name", ["six-bar", "planetary-gear", "swinging-four-bar", *SLOW])
def test_a_placed_scene_moves_as_in_its_plane(name: str) -> None:
    root = model_of(name)
    assert off_in_space(name, root) < 1e-10
    if name == "six-bar":  # negative control: a pin a hundredth of a millimetre off is another machine
        next(site for site in root.iter("site") if site.get("name") == "D.ternary").set("pos", "0.53001 0 0")
        assert 1e-6 < off_in_space(name, root) < 1e-1


@pytest.mark.parametrize("name", ["saw-40rpm", "six-bar"])
def test_torque_and_reactions_are_those_in_the_plane(name: str) -> None:
    (times, angles), placed, scene = course(name, 40), machine(name, model_of(name)), scene_named(name)

    def planar(times: Array) -> Instants:
        speed = np.full_like(times, scene.speed)
        return Instants(times, angles * times[-1] / course(name, 2)[0][-1], speed, np.zeros_like(times))

    found, truth = forces(placed, placed.motion(times)), joint_forces(scene.kinematics, planar(times))
    torque, size = found.drives["crank"], np.abs(truth.drive_torque).max()
    assert torque == pytest.approx(truth.drive_torque, abs=1e-9 * size)
    second = {joint.name: joint.b for joint in scene.kinematics.mechanism.joints}
    for closure in placed.tree.closures:
        exact, first = truth.components[closure.name], placed.tree.bodies[closure.points[0].body].name
        in_plane = np.array([exact["x"], exact["y"], np.zeros_like(times)])
        # In the plane the force is that on the second body.
        seen = (1.0 if first == second[closure.name] else -1.0) * TURN.T @ found.least[closure.name].T
        assert seen == pytest.approx(in_plane, abs=1e-9 * np.abs(in_plane).max()), closure.name
    # Negative control: angles a thousandth further ask for another torque.
    assert np.abs(torque - joint_forces(scene.kinematics, planar(times * 1.001)).drive_torque).max() > 1e-6 * size
