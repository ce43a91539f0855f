"""A model written in millimetres becomes, in metres, the model that is written in metres."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.mjcf.request import size_of_unit
from conrod.mjcf.unit_of_length import controls_in_metres, convert_to_metres


def machine(u: float) -> str:
    """A crank, a slide with a rack, a floating block, springs, tendons, servos and a contact; u units are a metre."""
    return f"""<mujoco><compiler autolimits="true"/>
    <option timestep="0.002" gravity="0 0 {-9.81 * u}" density="{1.2 / u**3}" viscosity="{2e-5 / u}"/>
    <default><equality solimp="0.9 0.95 {1e-3 * u}"/>
      <geom density="{1000.0 / u**3}" solimp="0.9 0.95 {1e-3 * u}" friction="0.9 {0.005 * u} {1e-4 * u}"
        margin="{1e-3 * u}"/>
      <joint solimplimit="0.9 0.95 {1e-3 * u}"/>
      <tendon width="{0.003 * u}" solimplimit="0.9 0.95 {1e-3 * u}"/><site size="{0.005 * u} {0.005 * u}
        {0.005 * u}"/></default>
    <worldbody><geom type="plane" size="{u} {u} {0.1 * u}" pos="0 0 {-0.5 * u}"/>
      <body name="crank"><joint name="crank" axis="0 1 0" range="-90 90" damping="{0.02 * u**2}"
        stiffness="{0.3 * u**2}"
          armature="{0.01 * u**2}" frictionloss="{0.1 * u**2}" actuatorfrcrange="{-9 * u**2} {9 * u**2}"
        solimplimit="0.9 0.95 0.001"/>
        <geom type="capsule" size="{0.01 * u}" fromto="0 0 0 {0.2 * u} 0 0"/><site name="tip" pos="{0.2 * u} 0
        0"/></body>
      <body name="rack" pos="0 0 {0.3 * u}"><joint name="rack" type="slide" axis="1 0 0" range="{-0.1 * u} {0.1 * u}"
        damping="3"
          stiffness="200" springref="{0.01 * u}" armature="0.5" frictionloss="{2 * u}" actuatorfrcrange="{-90 * u}
        {90 * u}"/>
        <geom type="box" size="{0.05 * u} {0.02 * u} {0.02 * u}"/><site name="end" pos="{0.05 * u} 0 0"/></body>
      <body name="block" pos="{0.5 * u} 0 {0.5 * u}"><freejoint name="float"/><geom type="sphere" size="{0.04 * u}"/>
        <site name="eye" pos="0 {0.04 * u} 0"/></body>
    </worldbody>
    <tendon><fixed name="sum" range="{-0.2 * u} {0.2 * u}" stiffness="40" damping="2" frictionloss="{u}">
        <joint joint="crank" coef="{0.05 * u}"/><joint joint="rack" coef="1"/></fixed>
      <spatial name="rope" stiffness="70" damping="4" range="0 {2 * u}"><site site="tip"/><site
        site="end"/></spatial></tendon>
    <equality><joint name="teeth" joint1="rack" joint2="crank" polycoef="{0.01 * u} {0.05 * u} {0.01 * u} 0 0"
        solimp="0.9 0.95 {1e-3 * u}"/>
      <connect name="pin" body1="block" body2="rack" anchor="0 0 {-0.1 * u}"/>
      <weld name="glue" body1="block" body2="crank" torquescale="{0.3 * u}"/></equality>
    <actuator><position name="turn" joint="crank" kp="{5 * u**2}" kv="{0.4 * u**2}" ctrlrange="-1 1"
        forcerange="{-8 * u**2} {8 * u**2}"/>
      <position name="push" joint="rack" kp="500" kv="20" ctrlrange="{-0.1 * u} {0.1 * u}" forcerange="{-60 * u}
        {60 * u}"/>
      <velocity name="pace" joint="rack" kv="30" ctrlrange="{-0.5 * u} {0.5 * u}"/>
      <general name="lift" joint="rack" gainprm="{2 * u}" ctrlrange="-1 1"/>
      <general name="pull" tendon="rope" gainprm="50" biastype="affine" biasprm="{u} -50 -2"/></actuator>
    <keyframe><key name="home" qpos="0.3 {0.02 * u} {0.5 * u} 0 {0.4 * u} 1 0 0 0" qvel="1 {0.3 * u} {0.1 * u} 0 0 0
        0 2"
      ctrl="0.5 {0.05 * u} {0.2 * u} 0.7 {0.1 * u}"/></keyframe></mujoco>"""


FLOATS = [name for name in dir(mujoco.MjModel) if not name.startswith("_")]


def differences(one: mujoco.MjModel, other: mujoco.MjModel) -> dict[str, float]:
    """Largest relative difference of each array of numbers."""
    found = {}
    for name in FLOATS:
        a, b = getattr(one, name), getattr(other, name)
        if isinstance(a, np.ndarray) and a.dtype.kind == "f" and a.size:
            found[name] = float(np.abs(a - b).max() / max(np.abs(a).max(), 1e-300))
    return found


@pytest.mark.parametrize("per_metre", [1000.0, 1.0 / 0.0254])
def test_model_in_other_units_becomes_the_one_in_metres(per_metre: float) -> None:
    right = mujoco.MjModel.from_xml_string(machine(1.0))
    made = mujoco.MjModel.from_xml_string(machine(per_metre))
    # Negative control: as it is written it is another one.
    assert max(differences(right, made).values()) > 10.0
    convert_to_metres(made, 1.0 / per_metre)
    assert {name: off for name, off in differences(right, made).items() if off > 1e-9} == {}
    assert np.allclose(made.opt.gravity, right.opt.gravity)
    # Both move alike, with controls of the file converted.
    runs = []
    for model in (right, made):
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        for _ in range(50):
            mujoco.mj_step(model, data)
        runs.append(data.qpos.copy())
    assert np.abs(runs[0]).max() > 0.1
    assert runs[1] == pytest.approx(runs[0], abs=1e-7)


def test_controls_of_servos_along_slides_are_lengths() -> None:
    model = mujoco.MjModel.from_xml_string(machine(1000.0))
    given = tuple((name, 2.0) for name in ("turn", "push", "pace", "lift", "4", "none"))
    found = controls_in_metres(model, given, 1e-3)
    assert found == (("turn", 2.0), ("push", 0.002), ("pace", 0.002), ("lift", 2.0), ("4", 0.002), ("none", 2.0))
    assert controls_in_metres(model, given, 1.0) == given
    assert controls_in_metres(model, given[1:2], 2.0) == (("push", 4.0),)


def test_unit_of_a_model_with_muscles_is_refused() -> None:
    text = machine(1000.0).replace("</actuator>", '<muscle name="m" joint="crank"/></actuator>')
    with pytest.raises(InvalidInput, match="--unit: it has muscles"):
        convert_to_metres(mujoco.MjModel.from_xml_string(text.replace('ctrl="', 'act="0" ctrl="0 ')), 1e-3)


def test_all_parts_that_are_not_converted_are_named() -> None:
    # Of arrays that a release of MuJoCo lacks a model uses none.
    model: Any = SimpleNamespace(
        nflex=1, nplugin=2, actuator_gaintype=np.array([int(mujoco.mjtGain.mjGAIN_MUSCLE), 0]),
        actuator_biastype=np.array([0, int(mujoco.mjtBias.mjBIAS_USER)]),
        geom_fluid=np.array([0.0, 0.5]), dof_dampingpoly=np.zeros((2, 2)),
    )  # fmt: skip
    with pytest.raises(InvalidInput) as refused:
        convert_to_metres(model, 1e-3)
    assert str(refused.value) == (
        "--unit: it has flexes, plugins, muscles, actuators of a user's own kind, geom_fluid, which are not converted "
        "to metres"
    )
    convert_to_metres(model, 1.0)


def test_sizes_of_units_are_in_metres_and_others_are_refused() -> None:
    assert [size_of_unit(unit) for unit in (None, "m", "cm", "mm", "inch")] == [1.0, 1.0, 0.01, 0.001, 0.0254]
    with pytest.raises(InvalidInput) as refused:
        size_of_unit("yards")
    assert str(refused.value) == "unknown unit of a model's lengths 'yards': choose from cm, inch, m, mm"
