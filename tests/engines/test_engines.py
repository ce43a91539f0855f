"""What the engines must reach, and that their errors are the ones their laws predict.

N is steps per revolution, two revolutions, h = 2 pi / N.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, EVERY_SCENE, LINKAGES, PRESS, SAW, SCENES
from kinematic_mode import kinematic_errors

from conrod import Comparison, MuJoCoSettings, Outcome, Trajectory, compare, harden, run
from conrod.comparison.convergence import observed_order
from conrod.comparison.outcome import joint_gaps
from conrod.engines import ENGINES, OPTIONAL_ENGINES, engine_named
from conrod.engines.mujoco.error_bound import PREDICTION_MARGIN, DrivenCourse, rk4_local_errors
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.engines.run import run_in_one_piece
from conrod.exact.motion import Array
from conrod.scenes import Saw, Scene, ShearPress, catalogue_scene

QUANTITIES = ("position", "velocity", "acceleration")
TURN = 2.0 * math.pi


@cache
def run_engine(scene: Scene, engine: str, preset: str, steps: int, revolutions: float = 2.0) -> Trajectory:
    return run(scene, engine_named(engine).presets[preset](scene, steps), revolutions)


@cache
def compare_run(scene: Scene, engine: str, preset: str, steps: int) -> Comparison:
    trajectory = run_engine(scene, engine, preset, steps)
    assert trajectory.outcome is Outcome.COMPLETED, trajectory.reason
    return compare(trajectory, scene)


def fitted_order(scene: Scene, engine: str, preset: str, steps: tuple[int, ...], quantity: str) -> float:
    errors = [compare_run(scene, engine, preset, n).worst(quantity) for n in steps]
    return float(-np.polyfit(np.log(steps), np.log(errors), 1)[0])


def error_bound(scene: Scene, engine: str, preset: str, steps: int) -> Any:
    found = engine_named(engine)
    return found.expected_error(scene, found.presets[preset](scene, steps))


# -- kinematic mode: the model ---------------------------------------------------------------------------------------

KINEMATIC = {"mujoco": 1e-13, "pymunk": 1e-12}
ANGLES = np.linspace(0.0, TURN, 72, endpoint=False)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", LINKAGES)
def test_kinematic_mode_gives_the_exact_pose(name: str, engine: str) -> None:
    scene = LINKAGES[name]
    position, velocity = kinematic_errors(engine, scene, ANGLES)
    assert position <= KINEMATIC[engine]
    assert velocity <= 1e-9
    poses = engine_named(engine).solve_kinematics(scene, ANGLES).poses
    assert max(np.abs(gap).max() for gap in joint_gaps(scene.mechanism(), [poses]).values()) <= 1e-12


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("scene", [PRESS, SAW], ids=["press", "saw"])
def test_kinematic_mode_detects_a_rod_too_long_by_1e_4(scene: Any, engine: str) -> None:
    position, velocity = kinematic_errors(engine, scene, ANGLES, replace(scene, rod=1.0001 * scene.rod))
    assert position > 1e6 * KINEMATIC[engine]
    assert velocity > 1e-6


# -- MuJoCo, hardened ------------------------------------------------------------------------------------------------

HARDENED_PATH = (125, 250, 500, 1000)
BARS = {"position": 1.5e-9, "velocity": 1e-8, "acceleration": 2e-8}  # at 500 steps


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("name", LINKAGES)
def test_hardened_mujoco_has_order_four_and_keeps_its_limits(name: str, quantity: str) -> None:
    scene = LINKAGES[name]
    assert compare_run(scene, "mujoco", "hardened", 500).worst(quantity) <= BARS[quantity]
    assert fitted_order(scene, "mujoco", "hardened", HARDENED_PATH, quantity) == pytest.approx(4.0, abs=0.15)
    errors = [compare_run(scene, "mujoco", "hardened", n).worst(quantity) for n in HARDENED_PATH]
    assert observed_order(HARDENED_PATH, errors).claimed == pytest.approx(4.0, abs=0.15)


def test_hardening_does_not_apply_to_contact() -> None:
    engine = engine_named("mujoco")
    assert "contact" in (engine.refusal(CAM, engine.presets["hardened"](CAM, 1000)) or "")
    assert all(engine.refusal(s, engine.presets["hardened"](s, 1000)) is None for s in LINKAGES.values())


def test_harden_works_on_any_compiled_model() -> None:
    model = build(SAW, MuJoCoSettings.tuned(SAW, 100)).model
    body, dof = model.body_invweight0.copy(), model.dof_invweight0.copy()
    assert body.max() > 0.0
    harden(model, 1e-3)
    np.testing.assert_allclose(model.body_invweight0, 1e-3 * body, rtol=1e-15)
    np.testing.assert_allclose(model.dof_invweight0, 1e-3 * dof, rtol=1e-15)
    for factor in (0.0, -1.0, 1.5, math.nan):
        with pytest.raises(ValueError, match="out of range"):
            harden(model, factor)


# -- MuJoCo, stock ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LINKAGES)
def test_stock_mujoco_acceleration_does_not_converge(name: str) -> None:
    path = (500, 1000, 2000, 4000)
    errors = [compare_run(LINKAGES[name], "mujoco", "stock", n).worst("acceleration") for n in path]
    assert observed_order(path, errors).claimed is None
    assert errors[-1] > 0.5 * errors[0]
    assert errors[-1] > 1e-3


# -- pymunk, tuned ---------------------------------------------------------------------------------------------------

PYMUNK_PATH = (250, 500, 1000, 2000)


@pytest.mark.parametrize("quantity", ["position", "velocity"])
@pytest.mark.parametrize("name", LINKAGES)
def test_tuned_pymunk_is_of_order_two(name: str, quantity: str) -> None:
    assert fitted_order(LINKAGES[name], "pymunk", "tuned", PYMUNK_PATH, quantity) == pytest.approx(2.0, abs=0.05)


# -- the drive -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("engine", "preset"), [("mujoco", "stock"), ("mujoco", "tuned"), ("mujoco", "hardened"), ("pymunk", "tuned")]
)
@pytest.mark.parametrize("name", LINKAGES)
def test_the_drive_keeps_its_speed(name: str, engine: str, preset: str) -> None:
    found = compare_run(LINKAGES[name], engine, preset, 500)
    assert found.drive_speed <= 1e-12
    assert found.phase_max <= 1e-12 * 2.0 * TURN
    assert found.worst("total") <= found.worst("position") + 1e-10


# -- the laws --------------------------------------------------------------------------------------------------------

OTHERS = {
    "press-reversed": EVERY_SCENE["press-reversed"],
    "saw-reversed": EVERY_SCENE["saw-reversed"],
    "saw-slide-below": EVERY_SCENE["saw-slide-below"],
    "saw-heavy": Saw(slider_mass=30.0, speed=20.0),
    "press-fast": ShearPress(speed=60.0),
}
LAWFUL = {**LINKAGES, **OTHERS}


@pytest.mark.parametrize(
    ("engine", "preset", "steps", "least"),
    [("mujoco", "tuned", 500, 0.93), ("mujoco", "hardened", 500, 0.93), ("pymunk", "tuned", 1000, 0.9)],
)
@pytest.mark.parametrize("name", LAWFUL)
def test_error_law_bounds_linkage_runs_closely(name: str, engine: str, preset: str, steps: int, least: float) -> None:
    scene = LAWFUL[name]
    found, law = compare_run(scene, engine, preset, steps), error_bound(scene, engine, preset, steps)
    shares = {quantity: found.worst(quantity) / getattr(law, quantity) for quantity in QUANTITIES}
    assert max(shares.values()) <= 1.0, shares
    assert min(shares["position"], shares["velocity"]) >= least, shares
    assert law.law


def test_error_laws_fail_on_a_wrong_model() -> None:
    # Negative control: a rod 0.01% too long in the engine is outside of every bound, of hardened MuJoCo's by far.
    scene: Any = SAW
    wrong = replace(scene, rod=1.0001 * scene.rod)
    for engine, preset in (("mujoco", "tuned"), ("mujoco", "hardened"), ("pymunk", "tuned")):
        found = compare(run_engine(wrong, engine, preset, 2000), scene)
        times = 1e5 if preset == "hardened" else 3.0
        assert found.worst("position") > times * error_bound(scene, engine, preset, 2000).position


@pytest.mark.parametrize("start_angle", [0.0, 2.0])
@pytest.mark.parametrize("preset", ["tuned", "hardened"])
@pytest.mark.parametrize("name", ["saw-500rpm", "shear-press"])
def test_error_law_predicts_the_error_from_any_start(name: str, preset: str, start_angle: float) -> None:
    scene, engine = EVERY_SCENE[name], engine_named("mujoco")
    settings = engine.presets[preset](scene, 250)
    law = engine.expected_error(scene, settings, start_angle)
    found = compare(run_in_one_piece(engine, scene, settings, 1.0, start_angle), scene)
    for quantity in ("position", "velocity", "acceleration"):
        assert 1.0 < getattr(law, quantity) / found.worst(quantity) < 1.03 + PREDICTION_MARGIN
    # Negative control: the law of another start is another one, where the closures give way.
    if (name, preset) == ("saw-500rpm", "tuned"):
        other = engine.expected_error(scene, settings, start_angle + 1.5)
        assert other.acceleration / law.acceleration != pytest.approx(1.0, rel=0.1)


def test_local_errors_of_rk4_have_order_four() -> None:
    scene: Any = EVERY_SCENE["saw-500rpm"]
    settings = MuJoCoSettings.hardened(scene, 250)
    tree, constant = build(scene, settings).tree, abs(scene.speed) * settings.solref[0]
    step = 2.0 * math.pi / 250
    sizes = [
        np.abs(rk4_local_errors(tree, DrivenCourse.sample_course(scene, 0.0, h, constant), constant, h)[0]).max()
        for h in (step, step / 2.0)
    ]
    assert sizes[0] / sizes[1] == pytest.approx(16.0, rel=0.05)


# -- the cam, by contact ---------------------------------------------------------------------------------------------

CONTACT_PATH = (3927, 7854, 15708)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_contact_has_order_two(engine: str) -> None:
    assert fitted_order(CAM, engine, "tuned", CONTACT_PATH, "position") == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("steps", CONTACT_PATH)
@pytest.mark.parametrize("engine", ENGINES)
def test_error_law_bounds_contact_runs(engine: str, steps: int) -> None:
    found, law = compare_run(CAM, engine, "tuned", steps), error_bound(CAM, engine, "tuned", steps)
    assert found.worst("position") <= law.position
    assert found.worst("velocity", "rms") <= law.velocity_rms
    # The law is worth something: it allows no more than three times what is there; MuJoCo's eight, of velocities.
    assert law.position <= 3.0 * found.worst("position")
    assert law.velocity_rms <= (2.0 if engine == "pymunk" else 9.0) * found.worst("velocity", "rms")


@pytest.mark.parametrize(("factor", "tight"), [(1.0, 2.5), (4.7, 6.0)])
def test_a_follower_near_floating_falls_in_more_steps(factor: float, tight: float) -> None:
    """At 4.7 times its speed 0.88 of the fall is used up."""
    cam = catalogue_scene("cam-4-5-6-7")
    faster = cam.with_parameters(speed=factor * cam.speed)
    found, law = compare_run(faster, "pymunk", "tuned", 6000), error_bound(faster, "pymunk", "tuned", 6000)
    assert 1.0 < law.velocity_rms / found.worst("velocity", "rms") < tight


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_contact_keeps_its_limit_at_default_steps(engine: str) -> None:
    assert compare_run(CAM, engine, "tuned", 62832).worst("position") <= 1e-5


# -- the MJCF files --------------------------------------------------------------------------------------------------

MJCF = Path(__file__).parents[2] / "mjcf"


@pytest.mark.parametrize("name", SCENES)
def test_committed_mjcf_is_what_the_translator_writes(name: str) -> None:
    assert (MJCF / f"{name}.xml").read_text(encoding="utf-8") == standalone_mjcf(name, SCENES[name])


@pytest.fixture(
    params=[*(name for name in SCENES if name != "cam-follower"), pytest.param("cam-follower", marks=pytest.mark.slow)],
    scope="module",
)
def standalone(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Scene, Any]:
    """A committed file, copied away and loaded by plain MuJoCo from another folder."""
    folder = tmp_path_factory.mktemp("standalone")
    copy = folder / "models" / "model.xml"
    copy.parent.mkdir()
    copy.write_text((MJCF / f"{request.param}.xml").read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.MonkeyPatch.context() as elsewhere:
        elsewhere.chdir(folder)
        return SCENES[request.param], mujoco.MjModel.from_xml_path(str(copy))


def standalone_positions(model: Any, scene: Scene, revolutions: float) -> tuple[Array, dict[str, Array]]:
    """Crank angles and sensor positions over a run from the keyframe, by nothing but MuJoCo's own API."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    crank = model.joint("crank").qposadr[0]
    steps = round(revolutions * scene.period / model.opt.timestep)
    angles = np.empty(steps)
    positions = {point: np.empty((steps, 2)) for point in scene.lengths}
    # Views of the engine's own memory, which each step writes into.
    sensed = [(values, data.sensor(f"{point}.position").data[:2]) for point, values in positions.items()]
    coordinates = data.qpos
    for k in range(steps):
        angles[k] = coordinates[crank]
        mujoco.mj_step(model, data)
        for values, now in sensed:
            values[k] = now
    return angles, positions


def test_a_standalone_model_follows_the_exact_motion(standalone: tuple[Scene, Any]) -> None:
    scene, model = standalone
    angles, positions = standalone_positions(model, scene, 1.0)
    # A whole turn but for the last step.
    last = scene.speed * (scene.period - model.opt.timestep)
    assert angles[-1] == pytest.approx(last, abs=1e-9)
    exact = scene.motion(angles, scene.speed)
    law = error_bound(scene, "mujoco", "tuned", round(scene.period / model.opt.timestep)).position
    for point, values in positions.items():
        off = np.linalg.norm(values - exact.point(point).position, axis=1).max() / scene.lengths[point]
        assert off <= law
        # Negative control: paired with the instant after the step, the same samples are off by a step.
        late = np.linalg.norm(values[:-1] - exact.point(point).position[1:], axis=1).max() / scene.lengths[point]
        assert late > 2.0 * law


# -- masses and gravity, of which the exact motion of a driven linkage knows nothing -----------------------------------


@pytest.mark.parametrize(
    ("scene", "preset", "steps", "least", "most"),
    [(SAW, "hardened", 200, 0.99, 1.01), (PRESS, "hardened", 200, 0.99, 1.01), (PRESS, "stock", 400, 0.0, 0.7)],
)
def test_stock_depends_on_gravity_and_masses_hardened_does_not(
    scene: Any, preset: str, steps: int, least: float, most: float
) -> None:
    settings = engine_named("mujoco").presets[preset](scene, steps)
    weightless, lighter = replace(settings, gravity=False), scene.with_parameters(slider_mass=0.1 * scene.slider_mass)
    before = compare(run(scene, settings), scene).worst("position")
    for machine, used in ((lighter, settings), (scene, weightless)):
        assert least < compare(run(machine, used), machine).worst("position") / before < most


def test_each_engine_that_ships_has_a_colour_of_its_own() -> None:
    styles = {**ENGINES, **OPTIONAL_ENGINES}
    assert len({style.colour for style in styles.values()}) == len(styles)
