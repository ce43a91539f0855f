"""Axes change one thing of a machine or its run, from harmless to hopeless, and nothing else."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, SCENES

from conrod import MuJoCoSettings
from conrod.comparison.compare import compare
from conrod.engines.mujoco.dynamics import simulate
from conrod.engines.mujoco.model import build
from conrod.engines.run import run_in_one_piece
from conrod.execution.run import RunResult
from conrod.scenes import Saw, Scene, scene_named
from conrod.studies.limits.axes import AXES, FIXED_STEP
from conrod.studies.limits.axis import Scale
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.changed_machines import rescaled_parameters
from conrod.studies.limits.records import Level, level_of

PRESETS = (("mujoco", "stock"), ("mujoco", "tuned"), ("mujoco", "hardened"), ("pymunk", "stock"), ("pymunk", "tuned"))
CASES = [
    case
    for scene in (PRESS, SAW, CAM)
    for engine, preset in PRESETS
    if (case := Setup(scene.kind, scene, engine, preset)).refusal() is None
]


def case_of(scene: Scene = SAW, engine: str = "mujoco", preset: str = "hardened") -> Setup:
    return Setup(scene.kind, scene, engine, preset)


def changed(cell: LimitCase, case: Setup) -> set[str]:
    """Names of the parameters and settings in which a run differs from the preset's."""
    own = case.settings()
    return {n for n, v in cell.scene.parameters.items() if v != case.scene.parameters[n]} | {
        f.name for f in fields(own) if f.name != "preset" and getattr(cell.settings, f.name) != getattr(own, f.name)
    }


# -- the table -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", AXES)
def test_axis_ends_can_be_built_or_have_a_refusal(name: str) -> None:
    axis = AXES[name]
    refusals = {case: axis.refusal(case) for case in CASES}
    assert None in refusals.values()
    for case, refusal in refusals.items():
        if refusal is not None:
            assert case.scene.kind in refusal or case.engine in refusal
            continue
        for value in (end for span in axis.spans(case) for end in span):
            cell = axis.case(case, value)
            assert axis.text(case, value)
            assert cell.key == axis.case(case, value).key
            assert axis.scale is Scale.LISTED or axis.allowed[0] <= value <= axis.allowed[1]


ALONE = {
    "mass-ratio": {"slider_mass"},
    "mass-ratio-at-iterations": {"slider_mass"},
    "nearness": {"offset"},
    "stabilisation": {"solref", "refsafe"},
    "regularisation": {"hardening"},
    "iterations": {"iterations"},
    "rounding": {"rounded_state"},
    "start-pose": set(),
    "declaration": set(),
}


@pytest.mark.parametrize("name", ALONE)
def test_an_axis_changes_nothing_but_its_own_quantity(name: str) -> None:
    axis, usual = AXES[name], case_of()
    case = replace(usual, steps_per_revolution=usual.steps)
    # Presets follow the machine: the flywheel of the drive its masses and its travel.
    follows = {"armature"} if name in ("mass-ratio", "mass-ratio-at-iterations", "nearness") else set()
    seen = set.union(*(changed(axis.case(case, end), case) for span in axis.spans(case) for end in span))
    assert ALONE[name] <= seen <= ALONE[name] | follows


@pytest.mark.parametrize(("given", "steps"), [(None, 5000), (700, 700)])
def test_nearness_is_run_at_the_steps_asked_for_or_at_5000(given: int | None, steps: int) -> None:
    cell = AXES["nearness"].case(replace(case_of(), steps_per_revolution=given), 0.9)
    assert cell.settings.steps_per_revolution == steps


@pytest.mark.parametrize(("scene", "preset", "steps"), [(SAW, "hardened", 50), (CAM, "tuned", 1000)])
def test_long_run_has_few_steps_a_turn_and_more_with_a_cam(scene: Scene, preset: str, steps: int) -> None:
    cell = AXES["run-length"].case(replace(case_of(scene, preset=preset), steps_per_revolution=400), 12.0)
    assert (cell.settings.steps_per_revolution, cell.revolutions) == (steps, 12.0)


@pytest.mark.parametrize(("axis", "rest"), [("run-length", "and no more"), ("start-pose", "from its start")])
def test_an_input_of_one_pass_lacks_the_axis_with_a_reason(axis: str, rest: str) -> None:
    scene = scene_named("double-rocker")
    assert AXES[axis].missing_reason(case_of(scene)) == f"the input of {scene.kind} makes one pass {rest}"
    assert AXES[axis].missing_reason(case_of(SAW)) is None


# -- each of them ----------------------------------------------------------------------------------------------------


def test_every_speed_that_exists_has_whole_steps_of_one_length() -> None:
    axis, case = AXES["speed"], Setup("saw", Saw(speed=-4.0), "mujoco", "tuned")
    for value, steps in ((1.0, 100_000), (77.0, 1299), (50000.0, 2)):
        cell = axis.case(case, value)
        assert (cell.settings.steps_per_revolution, cell.settings.timestep) == (
            steps,
            pytest.approx(FIXED_STEP, rel=1e-12),
        )
        assert axis.nearest(value) == pytest.approx(-cell.scene.speed / (2.0 * math.pi) * 60.0, rel=1e-12)


def test_stabilisation_is_walked_both_ways_from_the_presets_own() -> None:
    axis = AXES["stabilisation"]
    assert axis.spans(case_of(preset="tuned")) == ((8.0, 1000.0), (8.0, 0.1))
    # It mends all at once: there is but one way to go.
    assert axis.spans(case_of(SAW, "pymunk", "tuned")) == ((0.1, 1000.0),)
    assert axis.spans(case_of(CAM, "mujoco", "tuned")) == ((2.0, 20000.0), (2.0, 0.1))


def test_another_unit_of_length_is_the_same_machine() -> None:
    for scene in (PRESS, SAW, CAM):
        in_mm = scene.with_parameters(**rescaled_parameters(scene, 1e3))
        angles = np.linspace(0.0, 6.0, 7)
        for name, length in scene.lengths.items():
            assert in_mm.lengths[name] == pytest.approx(1e3 * length, rel=1e-9)
            here, there = scene.motion(angles, 1.0).point(name), in_mm.motion(angles, 1.0).point(name)
            np.testing.assert_allclose(there.acceleration, 1e3 * here.acceleration, rtol=1e-9, atol=1e-9 * 1e3 * length)
    assert rescaled_parameters(SAW, 1e3)["gravity"] == pytest.approx(9810.0)
    assert rescaled_parameters(SAW, 1e3)["rod_inertia"] == pytest.approx(0.01125e6)


def test_runs_start_every_five_degrees_and_at_dead_centres() -> None:
    starts = AXES["start-pose"].values(case_of())
    dead = [start for start in starts if start % 5.0]
    assert (len(starts), len(dead)) == (74, 2)
    # There the output stands still.
    assert np.linalg.norm(SAW.motion(np.radians(dead), 1.0).point("C").velocity, axis=1).max() < 1e-8


def test_declaration_orders_are_spread_evenly_and_end_reversed() -> None:
    axis = AXES["declaration"]
    assert axis.values(case_of(CAM, preset="tuned")) == tuple(range(12))
    numbers = axis.values(case_of())
    assert len(numbers) == 24
    setup = case_of()
    assert axis.value_text(setup, 0) == "crank, rod, slider; " + ", ".join(one.name for one in SAW.mechanism().joints)
    first, *_, last = (axis.case(setup, number).declared_mechanism for number in numbers)
    mechanism = SAW.mechanism()
    assert first == mechanism
    assert last == replace(mechanism, bodies=mechanism.bodies[::-1], joints=mechanism.joints[::-1])


def test_the_force_on_a_follower_stays_while_the_speed_grows() -> None:
    axis, case = AXES["float"], case_of(CAM, preset="tuned")
    for value in (0.2, 1.0, 5.0):
        scene = axis.case(case, value).scene
        assert scene.preload_force == pytest.approx(CAM.preload_force, rel=1e-12)
        # The force over what the follower needs.
        needed = -scene.least_acceleration * scene.follower_mass
        assert scene.preload_force / needed == pytest.approx(1.0 / value**2, rel=1e-12)


# -- from harmless to hopeless ---------------------------------------------------------------------------------------


def run(name: str, case: Setup, value: float) -> RunResult:
    return AXES[name].case(case, value).perform()


FAILS = [
    ("steps", case_of(SAW, "mujoco", "hardened"), 200.0, 2.0),
    ("mass-ratio", case_of(SAW, "pymunk", "stock"), 1.0, 1e-6),
    ("nearness", case_of(SAW, "mujoco", "hardened"), 0.1, 1.0 - 1e-9),
    ("stabilisation", case_of(SAW, "mujoco", "tuned"), 8.0, 0.1),
    ("iterations", case_of(SAW, "pymunk", "tuned"), 200.0, 1.0),
    ("length-unit", Setup("saw", SCENES["saw-500rpm"], "mujoco", "stock"), 1.0, 1e-3),
    ("speed", case_of(SAW, "pymunk", "tuned"), 200.0, 50000.0),
]


@pytest.mark.parametrize(("name", "case", "harmless", "hopeless"), FAILS)
def test_an_axis_leads_from_a_sound_run_to_a_failed_one(
    name: str, case: Setup, harmless: float, hopeless: float
) -> None:
    assert level_of(run(name, case, harmless)) in (Level.SAFE, Level.ROUGH)
    assert level_of(run(name, case, hopeless)) not in (Level.SAFE, Level.ROUGH)


def test_mass_ratio_is_safe_by_the_rule_and_not_at_iterations() -> None:
    case = case_of(SAW, "pymunk", "tuned")
    ruled, stays = (run(name, case, 1e3) for name in ("mass-ratio", "mass-ratio-at-iterations"))
    assert (level_of(ruled), level_of(stays)) == (Level.SAFE, Level.UNBOUNDED)


@pytest.mark.parametrize(("engine", "preset"), [("mujoco", "hardened"), ("pymunk", "tuned")])
def test_single_precision_shows_in_every_state_and_in_error(engine: str, preset: str) -> None:
    case = case_of(SAW, engine, preset)
    double, single = (run("rounding", case, value).largest("position") for value in (0.0, 1.0))
    assert single > (100.0 if engine == "mujoco" else 1.0) * double
    turns = [
        run_in_one_piece(
            case.loaded_engine, SAW, AXES["rounding"].case(case, value).settings, 0.1
        ).bodies.position.poses[1:, 2]
        for value in (0.0, 1.0)
    ]
    assert [np.array_equal(turn, turn.astype(np.float32)) for turn in turns] == [False, True]


@pytest.mark.parametrize(
    ("scene", "engine", "preset"), [(PRESS, "mujoco", "hardened"), (SAW, "pymunk", "tuned")], ids=["mujoco", "pymunk"]
)
def test_errors_ignore_declaration_order_when_solver_converges(scene: Scene, engine: str, preset: str) -> None:
    axis, case = AXES["declaration"], case_of(scene, engine, preset)
    numbers = axis.values(case)
    errors = [axis.case(case, number).perform().largest("position") for number in numbers[:: len(numbers) // 4]]
    assert errors == pytest.approx([errors[0]] * len(errors), rel=0.05)


@pytest.mark.parametrize(("engine", "preset"), [("mujoco", "stock"), ("pymunk", "tuned")])
def test_orders_start_in_the_same_pose_and_compare_by_body(engine: str, preset: str) -> None:
    """The tracks of a redeclared machine are its own: seen in the scene's order they are another machine's."""
    case = case_of(SAW, engine, preset)
    cell = AXES["declaration"].case(case, AXES["declaration"].values(case)[-1])
    trajectory = run_in_one_piece(case.loaded_engine, cell.machine, cell.settings, 0.05)
    start = trajectory.bodies.position.poses[0].reshape(-1, 3)
    np.testing.assert_allclose(start[::-1].ravel(), SAW.kinematics.start[0], atol=1e-12)
    assert compare(trajectory, cell.machine).closure.position < 1e-2
    assert compare(trajectory, SAW).closure.position > 0.1


def test_time_constant_is_at_least_two_steps_when_guarded() -> None:
    def run(steps: float, refsafe: bool) -> bytes:
        settings = MuJoCoSettings.tuned(SAW, 200)
        settings = replace(settings, solref=(steps * settings.timestep, 1.0), refsafe=refsafe)
        return simulate(build(SAW, settings), SAW, settings, 150, 0.7)[1].tobytes()

    assert run(1.0, True) == run(2.0, True) == run(2.0, False) != run(1.0, False)
