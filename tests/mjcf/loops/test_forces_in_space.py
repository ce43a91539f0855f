"""Driving torques and reactions of machines in space, against energy; in the plane: `test_placed_scenes`."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest
from four_bars import driven, four_bar

from conrod.exact.space.mobility import forces
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.loops.reading import tree_of
from conrod.scenes.space import MACHINES


@pytest.mark.parametrize(("name", "open_ones"), [("stewart", set()), ("cardan", {"cross_1", "cross_2"})])
def test_reactions_are_open_where_closures_are_redundant_and_nowhere_else(name: str, open_ones: set[str]) -> None:
    machine = MACHINES[name]()
    found, motion = moved(machine.mjcf, dict(machine.drives), 0.2)
    assert set(forces(found, motion).ambiguous) == open_ones


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


def test_springs_and_dampers_that_are_switched_off_ask_for_nothing_and_other_forces_are_named() -> None:
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
    "actuators": four_bar(more='<actuator><motor joint="rocker"/></actuator>'),
    "springs or dampers that are not linear": four_bar().replace(
        '<joint name="coupler"', '<joint name="coupler" damping="0.1 0.2"'
    ),
}
