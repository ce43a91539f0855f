"""conrod's drive is the armature that a file could have on its driven joints, on simple bodies and on others."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pytest

from conrod import harden
from conrod.engines.mujoco import HARDENING_FACTOR
from conrod.engines.mujoco.compiled_edits import INVERSE_WEIGHTS, set_armature, set_step
from conrod.engines.mujoco.driven_joints import STEPS_TOGETHER, Drives
from conrod.engines.mujoco.model import constraint_jacobian
from conrod.exact.motion import Array
from conrod.mjcf.driven_runs import with_settings
from conrod.mjcf.driving import driven_run
from conrod.mjcf.loop_results import OWN_SETTINGS, LoopRequest
from conrod.models.loops.study import _LoopBench

CASES = Path(__file__).parents[2] / "data" / "cases"
STEPS, STEP = 100, 1e-3


def body(name: str, joint: str, geom: str = 'type="cylinder" size="0.05 0.01" mass="0.5"', more: str = "") -> str:
    """A body on the world, centred on its joint unless its place is given with the joint's."""
    at, _, joint = joint.rpartition("|")
    return f"""<body name="{name}" pos="{at or "0 0 0"}"><joint name="{name}" {joint}/><geom {geom}/>
      <site name="{name}_s" pos="0.02 0.01 0"/>{more}</body>"""


def machine(bodies: str, equality: str, more: str = "") -> str:
    return f"""<mujoco><compiler angle="radian"/><option timestep="{STEP}"/>
      <default><geom contype="0" conaffinity="0"/></default><worldbody>{bodies}</worldbody>
      <equality>{equality}</equality>{more}</mujoco>"""


def coupled(one: str, other: str, ratio: str = "0 1 0 0 0") -> str:
    return f'<joint joint1="{one}" joint2="{other}" polycoef="{ratio}"/>'


DISC, TILTED, SLIDE = 'axis="0 0 1"', 'axis="0 0.6 0.8"', 'type="slide" axis="1 0 0"'
BALL = 'type="sphere" size="0.02" mass="0.2"'
OFF_CENTRE = 'type="box" size="0.03 0.02 0.01" pos="0.05 0.01 0" mass="0.7"'
ROD = f'<body name="rod"><joint name="rod" {DISC}/><geom {OFF_CENTRE}/><site name="end" pos="-0.2 0 0"/></body>'
PISTON = body("piston", f"0.25 0 0|{SLIDE}", 'type="box" size="0.03 0.03 0.03" mass="3"', ROD)
PIN = '<site name="pin" pos="0.05 0 0"/>'
BIG_END = '<connect site1="end" site2="pin"/>'
TOP_PIN = '<site name="pin" pos="0.03 0.04 0"/>'
TOP_END = '<connect body1="rod" body2="crank" anchor="-0.22 0.04 0"/>'
TWO_SLIDES = (
    '<body name="xy"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>'
    '<geom type="sphere" size="0.02" mass="0.4"/><site name="xy_s"/></body>'
)


def tendon(**coefficients: float) -> str:
    joints = "".join(f'<joint joint="{name}" coef="{value}"/>' for name, value in coefficients.items())
    return f'<tendon><fixed name="t">{joints}</fixed></tendon>'


HELD_BALL = '<body name="held" pos="0 0 1"><joint name="held" type="ball"/><geom type="box" size="0.1 0.2 0.3"/></body>'
HELD_FREE = '<body name="held" pos="0 0 1"><freejoint name="held"/><geom type="box" size="0.1 0.2 0.3"/></body>'
FLOATING = (
    '<body name="base" pos="0 0 0.4"><freejoint name="base"/><geom size="0.2" mass="3"/>'
    f"{body('a', DISC)}{body('b', f'0.2 0 0|{DISC}')}</body>"
)
# Each with its driven joints; on 14 of them the compiler takes the driven or held body for a simple one.
MODELS: dict[str, tuple[str, dict[str, str]]] = {
    "disc and crank": (machine(body("crank", DISC, more=PIN) + PISTON, BIG_END), {"crank": "600rpm"}),
    "bar and crank": (machine(body("crank", DISC, OFF_CENTRE, PIN) + PISTON, BIG_END), {"crank": "600rpm"}),
    "piston drives a disc": (machine(body("crank", DISC, more=TOP_PIN) + PISTON, TOP_END), {"piston": "sine:5mm,5Hz"}),
    "two gears": (machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}"), coupled("b", "a", "0 -2 0 0 0")),
                  {"a": "60rpm"}),
    "two gears off centre": (machine(body("a", DISC, OFF_CENTRE) + body("b", f"0.1 0 0|{DISC}", OFF_CENTRE),
                                     coupled("b", "a", "0 -2 0 0 0")), {"a": "60rpm"}),
    "gear with a tilted axis": (machine(body("a", TILTED) + body("b", f"0.1 0 0|{DISC}"), coupled("b", "a")),
                                {"a": "60rpm"}),
    "three gears": (machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}") + body("c", f"0.2 0 0|{DISC}"),
                            coupled("b", "a", "0 -1 0 0 0") + coupled("c", "b", "0 -1.5 0 0 0")), {"a": "60rpm"}),
    "pinion drives a rack": (machine(body("pinion", DISC) + body("rack", SLIDE, BALL),
                                     coupled("rack", "pinion", "0 0.018 0 0 0")), {"pinion": "sine:40deg,1Hz"}),
    "rack drives a pinion": (machine(body("pinion", DISC) + body("rack", SLIDE, BALL),
                                     coupled("pinion", "rack", "0 50 0 0 0")), {"rack": "sine:10mm,1Hz"}),
    "rack with a load": (machine(body("pinion", DISC) + body("rack", SLIDE, BALL, body("load", TILTED)),
                                 coupled("rack", "pinion", "0 0.018 0 0 0")), {"pinion": "sine:40deg,1Hz"}),
    "jaws": (machine(body("a", SLIDE, BALL) + body("b", f"0 0.1 0|{SLIDE}", BALL), coupled("b", "a", "0 -1 0 0 0")),
             {"a": "sine:10mm,1Hz"}),
    "a jaw along no axis": (machine(body("a", 'type="slide" axis="3 4 0"', BALL) + body("b", f"0 0.1 0|{SLIDE}", BALL),
                                    coupled("b", "a", "0 -1 0 0 0")), {"a": "sine:10mm,1Hz"}),
    "two slides of a body": (machine(TWO_SLIDES, coupled("y", "x", "0 0.5 0 0 0")), {"x": "sine:10mm,1Hz"}),
    "discs on a tendon": (machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}"), '<tendon tendon1="t"/>',
                                  tendon(a=1.0, b=0.5)), {"a": "60rpm"}),
    "a differential": (machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}") + body("c", f"0.2 0 0|{DISC}"),
                               '<tendon tendon1="t"/>', tendon(a=1.0, b=1.0, c=-2.0)),
                       {"a": "60rpm", "b": "sine:30deg,2Hz"}),
    "a disc with an armature": (machine(body("a", f"{DISC} armature='0.3'") + body("b", f"0.1 0 0|{DISC}"),
                                        coupled("b", "a")), {"a": "60rpm"}),
    "a held ball": (machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}") + HELD_BALL, coupled("b", "a")),
                    {"a": "60rpm"}),
    "a held free body": (machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}") + HELD_FREE, coupled("b", "a")),
                         {"a": "60rpm"}),
    "a held slide": (machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}") + body("held", SLIDE, BALL),
                             coupled("b", "a")), {"a": "60rpm"}),
    "a held base": (machine(FLOATING, coupled("b", "a")), {"a": "60rpm"}),
}  # fmt: skip


def with_armature(text: str, joints: list[str], armature: float) -> str:
    root = ET.fromstring(text)
    for one in root.iter():
        if one.tag in ("joint", "freejoint") and one.get("name") in joints:
            free = {"type": "free"} if one.tag == "freejoint" else {}  # which has no armature of its own
            one.tag, one.attrib = "joint", one.attrib | free | {"armature": repr(armature)}
    return ET.tostring(root, encoding="unicode")


@dataclass(frozen=True)
class Compared:
    """A model with conrod's drive, and the same with the drive's armature in its text."""

    bench: _LoopBench
    drives: Drives
    ours: mujoco.MjModel
    written: mujoco.MjModel


def compared(name: str, label: str = OWN_SETTINGS) -> Compared:
    text, laws = MODELS[name]
    model = mujoco.MjModel.from_xml_string(text)
    bench = _LoopBench.from_request(model, LoopRequest(laws, seconds=STEPS * STEP))
    ours = with_settings(model, label, STEP, bench.period)
    drives = Drives(bench.machine, ours)
    joints = [joint.name for joint in (*bench.machine.driven, *drives.held)]
    written = mujoco.MjModel.from_xml_string(with_armature(text, joints, drives.armature))
    return Compared(bench, drives, ours, with_settings(written, label, STEP, bench.period))


@contextmanager
def pushed(one: Compared) -> Iterator[None]:
    """The drive's forces, at each stage of a step."""

    def push(_: mujoco.MjModel, data: mujoco.MjData) -> None:
        for joint, law in one.drives.joints:
            data.qfrc_applied[joint.rate] = one.drives.armature * law.derivatives(np.array([data.time]))[2, 0]

    mujoco.set_mjcb_control(push)
    try:
        yield
    finally:
        mujoco.set_mjcb_control(None)


def plain_run(one: Compared) -> tuple[Array, Array]:
    """Coordinates (nq, T) of plain MuJoCo with the armature in the file, and of the exact motion."""
    motion = one.bench.machine.motion(STEP * np.arange(STEPS + 1))
    data, seen = mujoco.MjData(one.written), []
    data.qpos[:], data.qvel[:] = motion.coordinates[:, 0], motion.rates[0, :, 0]
    write = one.drives.writer(STEP * np.arange(STEPS + 1))
    with pushed(one):
        for k in range(STEPS + 1):
            write(data, k)
            seen.append(data.qpos.copy())
            mujoco.mj_step(one.written, data)
    return np.array(seen).T, motion.coordinates


def our_run(one: Compared, label: str) -> Array:
    model = with_settings(one.bench.model, label, STEP, one.bench.period)
    motion = one.bench.machine.motion(STEP * np.arange(STEPS + 1))
    return driven_run(one.bench.machine, model, motion, one.bench.points, 1, carried=False).coordinates


@pytest.mark.parametrize("name", MODELS)
def test_drive_is_the_armature_written_in_the_file(name: str) -> None:
    for label in (OWN_SETTINGS, "hardened"):
        one = compared(name, label)
        (plain, exact), ours = plain_run(one), our_run(one, label)
        off = np.abs(plain - exact).max()
        assert ours.shape == plain.shape
        assert np.abs(ours - plain).max() < 1e-6 * off + 1e-13, label
        assert off < (0.02 if label == OWN_SETTINGS else 1e-6), (
            label
        )  # a loop that is driven at all is not open by a radius


@pytest.mark.parametrize("name", MODELS)
def test_flywheel_changes_the_fields_of_a_compiled_armature(name: str) -> None:
    one, kept = compared(name, "hardened"), ("stat", "names", "actuator_acc0", "text_data")
    for field in dir(one.ours):
        values = getattr(one.ours, field)
        if not field.startswith("_") and isinstance(values, np.ndarray) and field not in kept:
            assert values == pytest.approx(getattr(one.written, field), rel=1e-12, abs=0.0), field
    assert np.any(one.ours.dof_armature != one.bench.model.dof_armature)


def test_most_example_models_have_a_simple_body_and_some_none() -> None:
    simple = []
    for text, laws in MODELS.values():
        model = mujoco.MjModel.from_xml_string(text)
        dofs = [int(model.joint(name).dofadr[0]) for name in laws]
        simple.append(bool(model.dof_simplenum[dofs].any()))
    assert len(simple) == 20
    assert simple.count(True) >= 12
    assert simple.count(False) >= 4


def test_hardening_and_scaled_weights_survive_a_flywheel() -> None:
    plain = mujoco.MjModel.from_xml_string(MODELS["disc and crank"][0])
    hard = mujoco.MjModel.from_xml_string(MODELS["disc and crank"][0])
    harden(hard)
    for model in (plain, hard):
        set_armature(model, [0], 1e9)
    for name in INVERSE_WEIGHTS:
        assert getattr(hard, name) == pytest.approx(HARDENING_FACTOR * getattr(plain, name), rel=1e-12)
    assert plain.dof_invweight0[0] == pytest.approx(1e-9, rel=1e-6)
    assert plain.stat.meaninertia < 10.0  # the scale of the solver's tolerance is the machine's


CLOTH = """<mujoco><option integrator="discrete"/><worldbody><flexcomp name="cloth" type="grid" dim="2" count="4 4 1"
  spacing=".1 .1 .1" mass="1" radius=".01"><elasticity young="3e4" poisson="0" thickness="2e-2" elastic2d="bend"/>
  <contact contype="0" conaffinity="0" selfcollide="none"/></flexcomp></worldbody></mujoco>"""


def test_cloth_step_set_after_compiling_equals_step_in_file() -> None:
    if not hasattr(mujoco.MjModel, "efm0_L"):
        pytest.skip("this release keeps no factor with the step in it")
    model = mujoco.MjModel.from_xml_string(CLOTH)
    written = mujoco.MjModel.from_xml_string(CLOTH.replace("<option", '<option timestep="0.0005"'))
    assert model.nefm0dof
    assert np.any(model.efm0_L != written.efm0_L)
    set_step(model, 0.0005)
    assert np.array_equal(model.efm0_L, written.efm0_L)


# -- models that were not driven at all --------------------------------------------------------------------------------

# Drive, and the largest error of position [m] as it is and hardened, by plain MuJoCo with the armature in the file.
FIGURES = {
    "disc-crank": ({"crank": "600rpm"}, 2.6616e-3, 4.973e-8),
    "coupled-slides": ({"a": "sine:10mm,1Hz"}, 1.8188e-5, 3.25e-13),
    "steering": ({"pinion": "sine:40deg,1Hz"}, 5.0510e-5, 1.33e-12),
}


@pytest.mark.parametrize("name", FIGURES)
def test_simple_bodies_are_driven_as_plain_mujoco_drives_them(name: str) -> None:
    drives, *expected = FIGURES[name]
    bench = _LoopBench.from_request(mujoco.MjModel.from_xml_path(str(CASES / f"{name}.xml")), LoopRequest(drives))
    runs = [bench._run(label, 1.0, 0.1, {}) for label in (OWN_SETTINGS, "hardened")]
    found = [run.errors["position"] for run in runs]
    assert found[0] == pytest.approx(expected[0], rel=1e-4)
    assert found[1] == pytest.approx(expected[1], rel=0.02)


def test_steering_opens_at_its_teeth_when_its_rack_drives_it() -> None:
    """Softened by the pinion's tiny inertia: in plain MuJoCo by 30.07 mm of 30."""
    model = mujoco.MjModel.from_xml_path(str(CASES / "steering.xml"))
    run = _LoopBench.from_request(model, LoopRequest({"rack": "sine:30mm,1Hz"}))._run(OWN_SETTINGS, 1.0, 0.1, {})
    assert (run.outcome.slug, run.reason) == ("opened", "teeth opens by 30.1 mm")


@pytest.mark.parametrize("flag", ["enable", "disable"])
def test_run_follows_a_reversing_drive_when_actuation_is_off(flag: str) -> None:
    text, laws = MODELS["pinion drives a rack"]
    model = mujoco.MjModel.from_xml_string(
        text.replace(f'timestep="{STEP}"/>', f'timestep="{STEP}"><flag actuation="{flag}"/></option>')
    )
    run = _LoopBench.from_request(model, LoopRequest(laws, seconds=0.1))._run("hardened", 1.0, 0.1, {})
    assert run.errors["acceleration"] < 1e-6


# -- settings that a flag would keep from being read -------------------------------------------------------------------


def test_flywheels_are_pushed_by_the_laws_at_each_stage() -> None:
    found = machine(body("a", DISC) + body("b", f"0.1 0 0|{DISC}"), coupled("b", "a", "0 -2 0 0 0"))
    model = mujoco.MjModel.from_xml_string(found)
    driven = _LoopBench.from_request(model, LoopRequest({"a": "sine:20deg,1.5Hz"}, seconds=1.0)).machine
    drives, law, asked = Drives(driven, model), driven.laws["a"], mujoco.MjData(model)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with drives.pushing_flywheels():
        for k in range(2 * STEPS_TOGETHER + 3):
            mujoco.mj_step(model, asked)
            if k == STEPS_TOGETHER:  # to a time that no step from the last one leads to
                asked.time = 0.1234567
            mujoco.mj_forward(model, asked)
            force = drives.armature * law.derivatives(np.array([asked.time]))[2, 0]
            assert asked.qfrc_applied[driven.driven[0].rate] == pytest.approx(force, rel=1e-13)


@pytest.mark.parametrize("kind", ["dense", "sparse"])
def test_jacobian_is_the_product_with_each_direction(kind: str) -> None:
    text, _ = MODELS["disc and crank"]
    model = mujoco.MjModel.from_xml_string(text.replace("<option ", f'<option jacobian="{kind}" '))
    data = mujoco.MjData(model)
    data.qpos[:] = 0.3
    mujoco.mj_forward(model, data)
    products = np.empty((model.nv, data.nefc))
    for row, direction in zip(products, np.eye(model.nv), strict=True):
        mujoco.mj_mulJacVec(model, data, row, direction)
    assert np.any(products)
    assert constraint_jacobian(model, data).tobytes() == np.ascontiguousarray(products.T).tobytes()


def test_hardening_holds_when_inverse_inertias_vary_each_step() -> None:
    text, laws = MODELS["disc and crank"]
    exact = text.replace(f'timestep="{STEP}"/>', f'timestep="{STEP}"><flag diagexact="enable"/></option>')
    model = mujoco.MjModel.from_xml_string(exact)
    run = _LoopBench.from_request(model, LoopRequest(laws, seconds=0.1))._run("hardened", 1.0, 0.1, {})
    assert run.errors["position"] < 1e-7
    harden(model)
    assert model.opt.enableflags == 0


def test_contact_presets_apply_when_file_overrides_geoms() -> None:
    text, _ = MODELS["disc and crank"]
    over = text.replace(
        f'timestep="{STEP}"/>', f'timestep="{STEP}" o_solref="0.5 1"><flag override="enable"/></option>'
    )
    model = with_settings(mujoco.MjModel.from_xml_string(over), "tuned", STEP, 0.1)
    assert np.array_equal(model.opt.o_solref, model.geom_solref[0])
    own = with_settings(mujoco.MjModel.from_xml_string(over), OWN_SETTINGS, STEP, 0.1)
    assert own.opt.o_solref.tolist() == [0.5, 1.0]


def test_run_of_few_steps_has_a_sample_at_each() -> None:
    text, laws = MODELS[next(iter(MODELS))]
    model = mujoco.MjModel.from_xml_string(text)
    bench = _LoopBench.from_request(model, LoopRequest(laws, seconds=12 * STEP))
    _, coordinates = bench._record_model(OWN_SETTINGS, with_settings(model, OWN_SETTINGS, STEP, bench.period), 0.1)
    assert coordinates.shape == (model.nq, 13)
