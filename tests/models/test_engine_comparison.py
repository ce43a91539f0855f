"""`conrod check MODEL.xml --drive --engine`: users' loops in several engines, by their own exact motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from command_line import conrod, refusal

import conrod as api
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named, installed_extras
from conrod.engines.capabilities import SpatialRuns, require_capability
from conrod.engines.mujoco.space import spatial_mjcf
from conrod.exact.motion import Array
from conrod.exact.space import SpatialTree
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.loop_closure import residuals
from conrod.exact.space.motion import DrivenTree
from conrod.exact.space.rigid_parts import merge_rigid_parts
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.reading import tree_of
from conrod.models.engine_comparison.study import read_model
from conrod.scenes.space import MACHINES
from conrod.studies.space.plan import SpatialCell
from conrod.studies.space.results import SpatialResult
from conrod.studies.space.study import SpatialBench, judge_run, run_cell

NEEDS_EXUDYN = pytest.mark.skipif("exudyn" not in installed_extras(), reason="Exudyn is not installed")
ENGINES = ["mujoco", pytest.param("exudyn", marks=NEEDS_EXUDYN)]
QUICK = ("--drive", "input=60rpm", "--engine", "mujoco", "--preset", "hardened", "--steps-per-rev", "60")
LAW = "sine:20deg,1Hz"
INERTIA = 'mass="0.3" pos="0.05 0.01 0" fullinertia="2e-4 3e-4 4e-4 1e-5 0 0"'
# An arm of two joints that no loop has, which carries a four-bar with a gear; the rocker's tip is a body of its own.
GRIPPER = f"""<mujoco><worldbody>
<body name="shoulder" pos="0.1 0 0.3" euler="20 10 0"><joint name="swing" type="ball"/><inertial {INERTIA}/>
 <body name="arm" pos="0.2 0 0" euler="0 30 0"><joint name="lift" axis="0 1 0" ref="0.2"/><inertial {INERTIA}/>
  <body name="palm" pos="0.1 0 0.05" euler="5 0 0"><inertial {INERTIA}/>
   <body name="crank" pos="0 0 0"><joint name="crank" axis="0 0 1"/><inertial {INERTIA}/>
    <body name="rod" pos="0.05 0 0"><joint name="rod" axis="0 0 1"/><inertial {INERTIA}/>
     <site name="rod_end" pos="0.2 0 0"/></body></body>
   <body name="rocker" pos="0.15 0 0"><joint name="rocker" axis="0 0 1" pos="0.01 0 0"/><inertial {INERTIA}/>
    <body name="tip" pos="0.1 0.1 0" euler="0 0 40"><inertial {INERTIA}/><site name="tip" pos="0.02 0 0"/></body>
    <site name="rocker_end" pos="0.1 0.1 0"/></body>
   <body name="gear" pos="0 -0.2 0"><joint name="gear" axis="0 0 1" ref="0.1"/><inertial {INERTIA}/>
    <site name="tooth" pos="0.05 0 0"/></body>
  </body></body></body></worldbody>
<equality><connect name="pin" site1="rod_end" site2="rocker_end"/>
<joint name="teeth" joint1="gear" joint2="crank" polycoef="0.05 -2 0 0 0"/></equality></mujoco>"""


@pytest.fixture(scope="module")
def gripper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("models") / "gripper.xml"
    path.write_text(GRIPPER)
    return path


def result_of(path: Path, engine: str, preset: str, steps: int = 100) -> SpatialResult:
    read = read_model(path, LoopRequest({"crank": LAW}), 1)
    return run_cell(SpatialCell(path.stem, engine, preset, (steps,), 1, read.model))


# -- the machine that engines are given --------------------------------------------------------------------------------


def test_smaller_tree_moves_as_the_model() -> None:
    model = mujoco.MjModel.from_xml_string(GRIPPER)
    tree = tree_of(model, model.qpos0)
    held = ("swing", "lift")
    law = {"crank": parse_drive_law(LAW, "rad", 0.0, "crank")}
    whole = DrivenTree(tree, law, held)
    whole.track_branch(whole.assemble_start(), 1.0)
    small = merge_rigid_parts(tree, whole.knots[0].coordinates, held)
    assert [body.name for body in small.bodies[1:]] == ["crank", "rod", "rocker", "gear"]
    assert small.bodies[3].mass == pytest.approx(0.6)
    merged = DrivenTree(small, law)
    merged.track_branch(small.start[:, None], 1.0)
    times = np.linspace(0.0, 1.0, 23)
    before, after = whole.motion(times), merged.motion(times)
    for name, moved in after.points.items():
        for quantity in ("position", "velocity", "acceleration"):
            assert np.abs(getattr(moved, quantity) - getattr(before.points[name], quantity)).max() < 1e-11, name
    names = [joint.name for joint in small.joints]
    heavy, light = (
        mass_matrix(tree, before.coordinates[:, 7], names),
        mass_matrix(small, after.coordinates[:, 7], names),
    )
    assert np.abs(heavy - light).max() < 1e-12 * np.abs(heavy).max()


def mass_matrix(tree: SpatialTree, pose: Array, names: list[str]) -> Array:
    """Mass matrix (n, n) of some joints at a pose (nq,), as MuJoCo computes it."""
    model = mujoco.MjModel.from_xml_string(spatial_mjcf(tree))
    data, full = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    data.qpos[:] = pose
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, full)
    rates = [joint.rate for joint in tree.joints if joint.name in names]
    return np.asarray(full[np.ix_(rates, rates)])


def test_held_joint_beside_one_that_moves_is_a_drive(tmp_path: Path) -> None:
    path = tmp_path / "two.xml"
    gear = '<joint name="gear" '
    path.write_text(GRIPPER.replace(gear, f'<joint name="side" type="slide" ref="0.3"/>{gear}'))
    start = read_model(path, LoopRequest({"crank": LAW}), 1).model.start
    assert set(start.machine.laws) == {"crank", "side"}
    assert start.machine.laws["side"].derivatives(np.zeros(1))[0] == pytest.approx(0.3)
    assert start.machine.motion(np.array([0.2])).points.keys() >= {"tooth"}


def test_coupling_to_a_held_joint_keeps_its_value() -> None:
    model = mujoco.MjModel.from_xml_string(GRIPPER)
    tree = tree_of(model, model.qpos0)
    whole = DrivenTree(tree, {"crank": parse_drive_law(LAW, "rad", 0.0, "crank")})
    pose = whole.close_loops(whole.tree.start[:, None], 0.0)[0]
    small = merge_rigid_parts(tree, pose, ("swing", "lift", "crank"))
    (teeth,) = (closure for closure in small.closures if closure.name == "teeth")
    gear = next(joint for joint in small.joints if joint.name == "gear")
    assert teeth.sums == ({gear.rate: 1.0}, {})
    poses = forward_kinematics(small, small.start[:, None])
    assert np.abs(residuals(poses, 0)).max() < 1e-12


# -- engines -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
def test_engines_run_a_model_with_gears_and_held_arm(engine: str, gripper: Path) -> None:
    found = result_of(gripper, engine, "hardened" if engine == "mujoco" else "stock")
    assert found.outcome == Outcome.COMPLETED.slug, found.reason
    assert found.largest("position") < 1e-6  # type: ignore[operator]
    assert found.largest("closure") < 1e-6  # type: ignore[operator]


@pytest.mark.parametrize("engine", ENGINES)
def test_gear_of_another_ratio_is_seen(engine: str, gripper: Path) -> None:
    read = read_model(gripper, LoopRequest({"crank": LAW}), 1)
    start = read.model.start
    slipped = tuple(
        one if one.points else replace(one, polynomial=(0.05, -2.001, 0.0, 0.0, 0.0)) for one in start.tree.closures
    )
    other = replace(start, machine=DrivenTree(replace(start.tree, closures=slipped), start.machine.laws))
    runs = require_capability(engine_named(engine), SpatialRuns)
    run = runs.run_in_space(replace(other, step=0.01), "hardened" if engine == "mujoco" else "stock", 100)
    exact = start.machine.motion(run.times).points["tooth"].position
    off = np.linalg.norm(run.points["tooth"][0] - exact, axis=1).max()
    assert off == pytest.approx(0.05 * 0.001 * np.radians(20.0), rel=0.05)  # its radius, times the angle it is off


def test_model_of_a_machine_has_the_errors_of_its_closed_form(tmp_path: Path) -> None:
    path = tmp_path / "rssr.xml"
    path.write_text(MACHINES["rssr"]().mjcf)
    read = read_model(path, LoopRequest({"input": "60rpm"}, points=("rocker_pin", "rod_end")), 1)
    filed = run_cell(SpatialCell("rssr", "mujoco", "tuned", (60,), 1, read.model))
    known = run_cell(SpatialCell("rssr", "mujoco", "tuned", (60,), 1))
    for quantity in ("position", "velocity", "acceleration"):
        assert filed.largest(quantity) == pytest.approx(known.largest(quantity), rel=1e-3)


def test_rod_of_another_length_is_seen(gripper: Path, tmp_path: Path) -> None:
    path = tmp_path / "longer.xml"
    path.write_text(GRIPPER.replace('"rod_end" pos="0.2 0 0"', '"rod_end" pos="0.2001 0 0"'))
    longer = read_model(path, LoopRequest({"crank": LAW}), 1).model.start
    own = read_model(gripper, LoopRequest({"crank": LAW}), 1).model
    cell = SpatialCell("gripper", "mujoco", "hardened", (100,), 1, replace(own, start=longer))
    assert run_cell(cell).largest("position") < 1e-6  # type: ignore[operator] # by the longer one's own motion
    run = require_capability(engine_named("mujoco"), SpatialRuns).run_in_space(
        replace(longer, step=0.01), "hardened", 100
    )
    judged = judge_run(100, run, SpatialBench(None, own.start), own.scales)
    assert judged.worst("position") > 1e-4


# -- the command -------------------------------------------------------------------------------------------------------


def test_check_compares_engines_on_a_model(tmp_path: Path) -> None:
    (tmp_path / "rssr.xml").write_text(MACHINES["rssr"]().mjcf)
    asked = (*QUICK, "--tolerance", "position=1e-3L", "--out", "report")
    found = conrod("check", "rssr.xml", *asked, cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith("Within tolerance: MuJoCo hardened. On rssr the largest position errors over L are")
    page = (tmp_path / "report" / "rssr-space.md").read_text(encoding="utf-8")
    assert "the exact motion of rssr.xml" in page
    assert "closed form" not in page
    tight = conrod("check", "rssr.xml", *QUICK, "--tolerance", "position=1e-9L", cwd=tmp_path)
    assert tight.returncode == 1
    assert "OUT OF TOLERANCE: position" in tight.stdout


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (("--engine", "pymunk", "--drive", "input=60rpm"), "pymunk: unsupported, it has no runs of machines in space"),
        (
            ("--engine", "mujoco", "--preset", "tuned"),
            "none of its joints is driven: give --drive JOINT=LAW for one of input",
        ),
        (
            ("--engine", "mujoco", "--preset", "tuned", "--drive", "inptu=60rpm"),
            "unknown joint 'inptu': did you mean 'input'",
        ),
        ((*QUICK, "--seconds", "2"), "--seconds does not go with a model in several engines"),
        ((*QUICK, "--revolutions", "100000000"), "revolutions"),
        (("--engine", "mujoco", "--drive", "input=60rpm", "--steps-per-rev", "5000000"), "too many"),
        ((*QUICK, "--scene", "rssr"), "--scene does not go with a model in several engines"),
        (
            ("--engine", "mujoco", "--drive", "input=60rpm", "--drive", "output=sine:1deg,1Hz", "--preset", "tuned"),
            "rives",
        ),
    ],
    ids=["planar", "undriven", "joint", "seconds", "revolutions", "steps", "scene", "drives"],
)
def test_wrong_wishes_for_engines_are_refused(asked: tuple[str, ...], said: str, tmp_path: Path) -> None:
    path = tmp_path / "rssr.xml"
    path.write_text(MACHINES["rssr"]().mjcf)
    assert said in refusal("check", str(path), *asked)


def test_machine_in_space_is_validated_not_checked() -> None:
    assert "by conrod validate rssr" in refusal("check", "rssr", "--engine", "all")


def test_check_loops_in_engines_says_what_is_left_out(gripper: Path) -> None:
    found = api.check_loops_in_engines(
        gripper, drives={"crank": LAW}, engines="mujoco", preset="tuned", steps_per_rev=60
    )
    assert found.study.remarks == ("swing, lift held: no loop has them",)
    assert found.study.drives == {"crank": LAW}
    assert [run.steps_per_rev for run in found.study.results[0].runs] == [30, 60]
