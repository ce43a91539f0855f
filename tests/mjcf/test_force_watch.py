"""What acts besides the loops is seen where it acts, and not where a file only has it."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from conrod.comparison.other_forces import OtherForce, acting_sentences, merge_forces
from conrod.mjcf.force_watch import ForceWatch, _length_curvature, _missing_acceleration, gravity_across

# A pendulum of two links in the x-y plane, pinned to a slide.
MACHINE = """<mujoco><compiler angle="radian"/><option timestep="0.002" {option}><flag {flag}/></option>
<default><geom contype="0" conaffinity="0"/></default><worldbody>{world}
<body name="crank"><joint name="crank" axis="0 0 1" {crank}/><geom type="capsule" size="0.01" fromto="0 0 0 0.1 0 0"/>
  <body name="rod" pos="0.1 0 0"><joint name="rod" axis="0 0 1" {rod}/>
    <geom name="tip" type="capsule" size="0.01" fromto="0 0 0 0.3 0 0" {tip}/>
    <site name="end" pos="0.3 0 0"/></body></body>
<body name="slider" pos="0.4 0 0"><joint name="slide" type="slide" axis="1 0 0" {slide}/><geom size="0.02"/>
  <site name="pin"/></body>{bodies}</worldbody>
<equality><connect name="joint" site1="end" site2="pin"/>{equality}</equality>{more}</mujoco>"""
PARTS = ("option", "flag", "world", "crank", "rod", "tip", "slide", "bodies", "equality", "more")
FLAT = 'gravity="0 -9.81 0"'
FIXED = '<tendon><fixed name="t" {}><joint joint="slide" coef="2"/></fixed></tendon>'
DISC = '<body name="d" pos="0 1 0"><joint name="d" axis="0 0 1"/><geom size="0.05" mass="1"/></body>'
SPATIAL = '<tendon><spatial name="s"><site site="o"/><site site="end"/></spatial></tendon>'
HANDLE = '<body name="h" mocap="true" pos="0.4 0 0"/>'


def seen(steps: int = 200, rate: float = 20.0, **parts: str) -> tuple[OtherForce, ...]:
    text = MACHINE.format(**dict.fromkeys(PARTS, "") | {"option": FLAT} | parts)
    model = mujoco.MjModel.from_xml_string(text)
    data, watch = mujoco.MjData(model), ForceWatch(model)
    data.qvel[:2] = rate, -rate / 3.0
    mujoco.mj_forward(model, data)
    watch.sample(data)
    for _ in range(steps):
        mujoco.mj_step(model, data)
        watch.sample(data)
    return watch.found


# What is in the file, and the kind and name that are seen, with a unit.
ACTING = {
    "limit of a hinge": ({"rod": 'range="-0.2 0.2"'}, ("limit", "joint rod", "N m")),
    "limit of a slide": ({"slide": 'range="-0.05 0.05"'}, ("limit", "joint slide", "N")),
    "limit of a tendon": ({"more": FIXED.format('range="-0.1 9"')}, ("limit", "tendon t", "N")),
    "contact": ({"world": '<geom name="wall" type="box" size="1 0.05 1" pos="0 -0.08 0" contype="1" conaffinity="1"/>',
                 "tip": 'contype="1" conaffinity="1"'}, ("contact", "tip and wall", "N")),
    "dry friction": ({"slide": 'frictionloss="0.5"'}, ("dry friction", "joint slide", "N")),
    "dry friction of a tendon": ({"more": FIXED.format('frictionloss="0.5"')}, ("dry friction", "tendon t", "N")),
    "spring": ({"rod": 'stiffness="0.3"'}, ("spring", "joint rod", "N m")),
    "spring of a tendon": ({"more": FIXED.format('stiffness="3" springlength="0"')}, ("spring", "tendon t", "N")),
    "damper": ({"crank": 'damping="0.01"'}, ("damper", "joint crank", "N m")),
    "damper of a tendon": ({"more": FIXED.format('damping="3"')}, ("damper", "tendon t", "N")),
    "fluid": ({"option": f'{FLAT} density="1.2" viscosity="2e-5"'}, ("fluid", "", "")),
    "actuator": ({"more": '<actuator><position name="m" joint="slide" kp="5"/></actuator>'},
                 ("actuator", "actuator m", "")),
    "gravity compensation": ({"bodies": DISC.replace("<body", '<body gravcomp="0.5"').replace(
        "<geom", '<geom pos="0.1 0 0"')}, ("gravity compensation", "", "")),
    "handle": ({"bodies": HANDLE, "equality": '<connect name="grip" body1="slider" body2="h" anchor="0 0 0"/>'},
               ("handle", "mocap body h by grip", "N")),
    "polynomial of joints": ({"bodies": DISC, "equality":
                              '<joint name="p" joint1="d" joint2="crank" polycoef="0 1 0.5 0 0"/>'},
                             ("lacking acceleration", "p", "rad/s²")),
    "tendon through sites": ({"world": '<site name="o" pos="0 0.5 0"/>', "equality": '<tendon name="q" tendon1="s"/>',
                              "more": SPATIAL},
                             ("lacking acceleration", "q", "m/s²")),
    "gravity across": ({"option": 'gravity="0 -9.81 0.00981"'}, ("gravity across the plane", "", "g")),
}  # fmt: skip
# In the file, but nothing is made of it.
AT_REST = {
    "a limit that is not reached": {"slide": 'range="-5 5"'},
    "a limit that is off": {"slide": 'range="-0.05 0.05"', "flag": 'limit="disable"'},
    "friction that is off": {"slide": 'frictionloss="0.5"', "flag": 'frictionloss="disable"'},
    "a spring that is off": {"rod": 'stiffness="0.3"', "flag": 'spring="disable"'},
    "a spring of a tendon that is slack": {"more": FIXED.format('stiffness="3" springlength="-9 9"')},
    "a damper that is off": {"crank": 'damping="0.01"', "flag": 'damper="disable"'},
    "a motor without a control": {"more": '<actuator><motor joint="slide"/></actuator>'},
    "a wall far off": {"world": '<geom type="box" size="1 1 1" pos="0 -9 0" contype="1" conaffinity="1"/>',
                       "tip": 'contype="1" conaffinity="1"'},
    "a line of joints": {"bodies": DISC, "equality": '<joint name="p" joint1="d" joint2="crank"/>'},
    "a closure that is off": {"bodies": HANDLE, "equality":
                              '<connect active="false" body1="slider" body2="h" anchor="0 0 0"/>'},
    "gravity in its plane to six digits": {"option": 'gravity="0 -9.81 9.81e-7"'},
}  # fmt: skip


@pytest.mark.parametrize("what", ACTING)
def test_what_acts_in_a_run_is_named_and_nothing_else(what: str) -> None:
    parts, (kind, name, unit) = ACTING[what]
    (found,) = seen(**parts)
    assert (found.kind, found.name, found.unit) == (kind, name, unit)
    assert found.largest > 0.0


@pytest.mark.parametrize("what", AT_REST)
def test_what_a_file_has_and_does_not_act_is_not_named(what: str) -> None:
    assert seen(**AT_REST[what]) == ()


def test_sizes_are_those_of_mujoco() -> None:
    (friction,) = seen(slide='frictionloss="0.5"')
    assert friction.largest == pytest.approx(0.5)
    (spring,) = seen(steps=1, rate=0.0, rod='stiffness="0.3" springref="0.2"', option='gravity="0 0 0"')
    assert spring.largest == pytest.approx(0.06)
    assert spring.exact
    (bent,) = seen(steps=1, rate=0.0, rod='stiffness="0.3 0.5" springref="0.2"', option='gravity="0 0 0"')
    assert not bent.exact  # the exact forces know linear springs
    # Dampers of a rate of 20 rad/s: linear, of its square alone, of both, and of an actuator.
    for damping, size, exact in (("0.5", 10.0, True), ("0 0.5", 200.0, False), ("0.5 0.25", 110.0, False)):
        (damper,) = seen(steps=0, crank=f'damping="{damping}"')
        assert (damper.kind, damper.name, damper.unit, damper.exact) == ("damper", "joint crank", "N m", exact)
        assert damper.largest == pytest.approx(size)
    for damping, size in (("0.5", 10.0), ("0 0.5", 200.0)):
        motor = f'<actuator><general name="m" joint="crank" damping="{damping}"/></actuator>'
        assert seen(steps=0, more=motor) == (OtherForce("damper", "actuator m", size, ""),)


def test_acceleration_that_mujoco_lacks_is_second_derivative() -> None:
    """Of y = x + x^2 / 2 at 20 rad/s: 400 rad/s^2."""
    parts = {"bodies": DISC, "equality": '<joint name="p" joint1="d" joint2="crank" polycoef="0 1 0.5 0 0"/>'}
    (found,) = seen(steps=0, **parts)
    assert found.largest == pytest.approx(400.0, rel=1e-12)
    # A connect, whose part MuJoCo computes since 3.7, is no such equality.
    assert seen(steps=0) == ()


TENDONS = """<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody>
<site name="o" pos="0 0.5 0"/><site name="p" pos="-0.3 0.2 0"/>
<body name="a"><joint name="a" axis="0 0 1"/><geom size="0.01" mass="1"/><site name="end" pos="0.4 0 0"/></body>
<body name="b" pos="0.1 0 0"><joint name="b" axis="0 0 1"/><geom size="0.01" mass="1"/>
  <site name="tip" pos="0 0.3 0"/></body>
</worldbody><tendon><spatial name="s"><site site="o"/><site site="end"/></spatial>
<spatial name="t"><site site="p"/><site site="tip"/></spatial></tendon>
<equality><tendon name="q" tendon1="s" tendon2="t" polycoef="0 1 2 30 400"/></equality></mujoco>"""


def test_acceleration_that_tendons_lack_is_that_of_their_gap() -> None:
    """At constant rates the gap x - x0 - p(y - y0) of two lengths is differentiated twice, number by number."""
    model = mujoco.MjModel.from_xml_string(TENDONS)
    data, beside = mujoco.MjData(model), mujoco.MjData(model)
    rates, start, step = np.array([1.3, -0.7]), np.array([0.6, 0.5]), 1e-4
    coefficients = np.array([0.0, 1.0, 2.0, 30.0, 400.0])

    def gap(time: float) -> float:
        beside.qpos[:] = start + rates * time
        mujoco.mj_fwdPosition(model, beside)
        x, y = beside.ten_length - model.tendon_length0
        return float(x - np.polynomial.polynomial.polyval(y, coefficients))

    data.qpos[:], data.qvel[:] = start, rates
    mujoco.mj_forward(model, data)
    curvature = [_length_curvature(model, data, k) for k in range(2)]
    for k in range(2):
        lengths = []
        for side in (-1.0, 0.0, 1.0):
            beside.qpos[:] = start + side * step * rates
            mujoco.mj_fwdPosition(model, beside)
            lengths.append(beside.ten_length[k])
        assert curvature[k] == pytest.approx((lengths[0] - 2.0 * lengths[1] + lengths[2]) / step**2, rel=1e-4)
        assert abs(curvature[k]) > 0.04
    expected = (gap(-step) - 2.0 * gap(0.0) + gap(step)) / step**2
    # This release of MuJoCo computes none of it.
    assert _missing_acceleration(model, data, 0, 0) == pytest.approx(abs(expected), rel=1e-3)
    assert abs(expected) > 1.0
    data.qvel[:] = 0.0
    assert [_length_curvature(model, data, k) for k in range(2)] == [0.0, 0.0]  # nothing changes at rest


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_gravity_across_is_along_hinges_of_a_planar_machine(tilt: float) -> None:
    text = MACHINE.format(**dict.fromkeys(PARTS, "") | {"option": f'gravity="0 {-np.cos(tilt)} {-np.sin(tilt)}"'})
    assert gravity_across(mujoco.MjModel.from_xml_string(text)) == pytest.approx(np.sin(tilt), abs=1e-12)
    # A machine in space has no plane.
    space = text.replace('name="rod" axis="0 0 1"', 'name="rod" axis="0 0.1 1"')
    assert gravity_across(mujoco.MjModel.from_xml_string(space)) == 0.0


def test_all_is_said_in_sentences_with_the_largest_first() -> None:
    found = [OtherForce("limit", f"joint j{k}", float(k), "N m") for k in range(1, 6)]
    found += [OtherForce("actuator", "actuator m", 3.0, "")]
    found += [
        OtherForce("lacking acceleration", "p", 0.25, "rad/s²"),
        OtherForce("gravity across the plane", "", 1.0, "g"),
    ]
    assert acting_sentences(found, "MuJoCo 4.0.0") == (
        "What acts besides its loops: the limit of joint j5 (up to 5 N m), the limit of joint j4 (up to 4 N m), "
        "the limit of joint j3 (up to 3 N m) and 2 more, and the force of actuator m; "
        "the exact motion has no limits or contacts, so errors are not the engine's alone.",
        "MuJoCo 4.0.0 lacks the part of the velocity in the acceleration of p: up to 0.25 rad/s², "
        "which no setting mends.",
        "Gravity acts across the plane of motion.",
    )
    assert acting_sentences([OtherForce("gravity across the plane", "", 1e-3, "g")]) == (
        "A share of 0.001 of gravity acts across the plane of motion.",
    )
    assert acting_sentences([]) == ()
    # Of a model in millimetres sizes are said in SI, each by its dimension; shares and angles have no length.
    sizes = {one.unit: one.in_metres(1e-3).largest / one.largest for one in found}
    assert sizes == pytest.approx({"N m": 1e-6, "": 1.0, "rad/s²": 1.0, "g": 1.0})
    assert OtherForce("contact", "a and b", 5.0, "N").in_metres(1e-3).largest == pytest.approx(5e-3)
    assert [one.largest for one in merge_forces([found[0], OtherForce("limit", "joint j1", 9.0, "N m")])] == [9.0]
