"""MuJoCo: what a model may carry does to the motion what is said of it, and free motion follows the exact one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, SCENES
from free_machines import chain

from conrod import InvalidInput, MuJoCoSettings, Outcome, compare, run
from conrod.comparison.trajectory import Piece
from conrod.engines import engine_named
from conrod.engines.mujoco import MUJOCO_PRESETS, compat
from conrod.engines.mujoco import model_edits as dressing
from conrod.engines.mujoco.engine import without_loop_judgement
from conrod.engines.mujoco.model import build
from conrod.engines.tracks import FreeRun, Pace
from conrod.engines.variants import Ingredient
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.mechanism.loads import Distance, Elastic, Friction, Load, SpeedLine, Steady, TimePulse, Turn, Viscous
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes import catalogue_scene

MUJOCO: Any = engine_named("mujoco")
FAST_SAW = SCENES["saw-500rpm"]
MACHINES: dict[str, Any] = {"press": PRESS, "saw": FAST_SAW, "cam": CAM}
STEPS = 1000
# What does harm by itself: contact forces where links overlap; accelerations told from forces that have lost digits.
HARMFUL = ("touching-geoms", "noslip")
EQUAL = 1e-9


@cache
def minimal_of(machine: str) -> MuJoCoSettings:
    scene = MACHINES[machine]
    made: MuJoCoSettings = MUJOCO.minimal_settings(scene, 62832 if scene is CAM else STEPS)
    return replace(made, cam_vertices=250)  # a coarse cam is compiled in no time


@cache
def ingredients_of(machine: str) -> dict[str, Ingredient[MuJoCoSettings]]:
    return {one.name: one for one in MUJOCO.ingredients(MACHINES[machine], minimal_of(machine)) if not one.refusal}


def with_one(machine: str, name: str) -> MuJoCoSettings:
    """The minimal model with an ingredient, or without one of its own."""
    one = ingredients_of(machine)[name]
    return (one.removed if one.minimal else one.added)(minimal_of(machine))


EVERY = [(machine, name) for machine in MACHINES for name in ingredients_of(machine)]
LINKAGE_EXTRA = [(one, name) for one, name in EVERY if one != "cam" and not ingredients_of(one)[name].minimal]


def compiled_model(scene: Any, settings: MuJoCoSettings) -> bytes:
    """All numbers and names of the model that is timed."""
    model = MUJOCO.stepper(scene, settings).model
    content = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return content.tobytes()


def changes_the_model(machine: str, name: str) -> bool:
    scene = MACHINES[machine]
    return compiled_model(scene, with_one(machine, name)) != compiled_model(scene, minimal_of(machine))


@cache
def piece(machine: str, settings: MuJoCoSettings, revolutions: float = 1.0) -> Piece:
    steps = round(settings.steps_per_revolution * revolutions)
    found: Piece = next(MUJOCO.run(MACHINES[machine], settings, revolutions, 0.0, steps))
    return found


def change(machine: str, settings: MuJoCoSettings, quantity: str = "position") -> float:
    """Largest change of the observed points against the minimal model, normalised."""
    scene = MACHINES[machine]
    one, other = (piece(machine, s).trajectory.points for s in (settings, minimal_of(machine)))
    order = ("position", "velocity", "acceleration").index(quantity)
    return max(
        float(np.linalg.norm(getattr(one[p], quantity).values - getattr(other[p], quantity).values, axis=1).max())
        / (scene.lengths[p] * abs(scene.speed) ** order)
        for p in one
    )


# -- the ingredients -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("machine", "name"), EVERY)
def test_an_ingredient_changes_the_compiled_model(machine: str, name: str) -> None:
    assert changes_the_model(machine, name)


def test_an_ingredient_without_effect_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    edits = dict(dressing.MODEL_EDITS)
    monkeypatch.setattr(dressing, "MODEL_EDITS", edits | {"noslip": lambda root, tree, settings: None})
    assert not changes_the_model("saw", "noslip")
    assert changes_the_model("saw", "fwdinv")


def test_free_bodies_have_six_freedoms_and_three_connects_a_pin() -> None:
    counts = {}
    for name in ("minimal", "free-bodies"):
        settings = with_one("saw", name) if name != "minimal" else minimal_of("saw")
        model = MUJOCO.stepper(FAST_SAW, settings).model
        counts[name] = {"nv": model.nv, "connects": model.neq, "bodies": model.nbody, "excluded": model.nexclude}
    # Crank, rod and slider: the rod's hinge becomes six degrees of freedom, and each of its two pins three connects.
    assert counts["minimal"] == {"nv": 3, "connects": 1, "bodies": 4, "excluded": 0}
    assert counts["free-bodies"] == {"nv": 8, "connects": 6, "bodies": 4, "excluded": 1}


def test_a_machine_says_which_ingredients_it_cannot_have() -> None:
    def refused(scene: Any) -> dict[str, str]:
        return {one.name: one.refusal for one in MUJOCO.ingredients(scene, MUJOCO.minimal_settings(scene, STEPS))}

    for scene in (PRESS, FAST_SAW):
        assert {name for name, why in refused(scene).items() if why} == {"condim-3"}
    geared, cam = refused(catalogue_scene("planetary-gear")), refused(CAM)
    assert geared["free-bodies"] == "a rolling pair ties the joints of its wheels, which free bodies do not have"
    assert (cam["free-bodies"], cam["gravity"]) == (
        "no joint of the machine closes a loop",
        "the machine is described without gravity",
    )


def test_free_bodies_report_the_same_motion_in_pieces() -> None:
    settings = replace(with_one("saw", "free-bodies"), steps_per_revolution=60, timestep=FAST_SAW.period / 60)
    whole = next(MUJOCO.run(FAST_SAW, settings, 1.0, 0.0, 60)).trajectory
    parts = [one.trajectory for one in MUJOCO.run(FAST_SAW, settings, 1.0, 0.0, 7)]
    assert np.array_equal(np.vstack([one.bodies.position.poses for one in parts]), whole.bodies.position.poses)
    made = build(FAST_SAW, settings)
    rest = made.tree.start[None]
    # The rod two whole turns on: coordinates know it but for whole turns, which are counted from the sample before.
    turned = rest + 2.0 * np.pi * np.array([[0, 0, 0, 0, 0, 2, 0, 0, 0]])
    coordinates = made.coordinates(turned)
    assert np.allclose(made.forward_kinematics(coordinates, np.zeros((1, 8)), turned[0])[0], turned, atol=1e-14)
    assert np.allclose(made.forward_kinematics(coordinates, np.zeros((1, 8)))[0], rest, atol=1e-14)


@pytest.mark.parametrize(("column", "tilted"), [(2, "rod"), (4, "rod"), (0, None), (6, None)])
def test_a_free_body_out_of_the_plane_is_detected(column: int, tilted: str | None) -> None:
    made = build(FAST_SAW, with_one("saw", "free-bodies"))
    coordinates = made.coordinates(made.tree.start[None])
    first = next(i for i in range(made.model.nq - 6) if made.model.joint("crank-pin").qposadr[0] == i)
    coordinates[0, first + column] += 1e-3
    assert made.find_tilted_body(coordinates) == tilted


def test_forces_of_free_bodies_are_not_reported() -> None:
    found = MUJOCO.forces(FAST_SAW, with_one("saw", "free-bodies"), 1.0)
    assert found.drive_torque is None
    assert "held by three connects" in found.unsupported["drive torque"]


# -- settings and keys -----------------------------------------------------------------------------------------------


def test_a_model_edit_that_does_not_apply_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"unknown dressing 'enregy'.*did you mean 'energy'"):
        run(SAW, replace(MuJoCoSettings.hardened(SAW, 100), dressing=("enregy",)))
    for scene, name in ((CAM, "redundant-closures"), (SAW, "condim-3"), (SAW, "no-contact")):
        assert name in MUJOCO.refusal(scene, replace(MuJoCoSettings.tuned(scene, 100), dressing=(name,)))


# -- the motion ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("machine", ["press", "saw"])
def test_minimal_model_has_the_motion_of_the_best_preset(machine: str) -> None:
    scene = MACHINES[machine]
    assert change(machine, MuJoCoSettings.hardened(scene, STEPS)) < 1e-12
    assert compare(piece(machine, minimal_of(machine)).trajectory, scene).worst("position") < 1e-10


@pytest.mark.parametrize(("machine", "name"), LINKAGE_EXTRA)
def test_only_harmful_ingredients_change_the_motion(machine: str, name: str) -> None:
    settings = with_one(machine, name)
    changed = change(machine, settings)
    if name in HARMFUL:
        assert changed > 100.0 * EQUAL
        return
    assert piece(machine, settings).trajectory.outcome is Outcome.COMPLETED
    assert changed < EQUAL


@pytest.mark.parametrize("name", ["closure", "hardening", "rk4", "flywheel", "iteration"])
@pytest.mark.parametrize("machine", ["press", "saw"])
def test_removing_a_minimal_ingredient_changes_the_motion(machine: str, name: str) -> None:
    assert change(machine, with_one(machine, name)) > 1e-6


def test_removing_the_contact_lets_the_follower_fall() -> None:
    gone = piece("cam", with_one("cam", "contact"), 0.05).trajectory
    assert gone.outcome is not Outcome.COMPLETED


# -- free motion against the exact one ---------------------------------------------------------------------------------

TIMES = np.linspace(0.0, 10.0, 101)
FIRST = 21  # samples of them where two seconds are enough
STEP = 0.005  # [s]; ten seconds then cost less than 0.1 s of CPU time
PACE = Pace(0.92, crosses_branches=True)  # of the chains
LOADS = (
    Load("spring", Distance("ground", "bar0", (0.0, -0.5), (0.3, 0.0)), Elastic(20.0, 0.7)),
    Load("damper", Distance("ground", "rocker1", (0.0, 0.6), (0.5, 0.1)), Viscous(0.4)),
    Load("turn-spring", Turn("rocker0", "bar0"), Elastic(3.0, 0.2)),
    Load("motor", Turn("ground", "rocker0"), SpeedLine(-2.0, -9.0)),
    Load("friction", Turn("ground", "rocker1"), Friction(0.5, 0.5)),
    Load("pulse", Turn("ground", "bar0"), TimePulse(3.0, 0.2, 1.7)),
    Load("push", Distance("ground", "rocker1", (-1.0, 0.0), (0.5, 0.0)), Steady(1.5)),
)


@cache
def exact(loads: int, count: int) -> FreeMotion:
    return ForwardDynamics(loaded_mechanism(count, loads)).motion(TIMES[:FIRST] if loads else TIMES, {"rocker0": -1.0})


def loaded_mechanism(count: int, loads: int) -> Mechanism:
    return replace(chain(count), loads=LOADS[:loads])


def swing(mechanism: Mechanism, motion: FreeMotion, preset: str = "hardened", step: float = STEP) -> FreeRun:
    start = motion.poses[0], motion.rates[0]
    steps = round(float(motion.times[-1]) / step)
    found: FreeRun = MUJOCO.free_run(mechanism, preset, step, steps, *start, PACE, every=round(0.1 / step))
    return found


def error(run: FreeRun, motion: FreeMotion) -> float:
    """Largest distance [m] or turn [rad] from the exact motion."""
    assert run.outcome.slug == "completed", run.reason
    np.testing.assert_allclose(run.times, motion.times, atol=1e-12)
    return float(np.abs(run.poses - motion.poses).max())


def test_tuned_converges_at_change_points_where_stock_does_not() -> None:
    motion = exact(0, 2)
    assert not np.abs(swing(chain(2), motion, "stock").poses - motion.poses).max() < 0.1
    errors = [error(swing(chain(2), motion, "tuned", step), motion) for step in (0.01, 0.005, 0.0025)]
    assert errors[1] < 0.1
    assert errors[0] > 3.0 * errors[1] > 30.0 * errors[2]


def test_hardened_is_within_1e_6_at_change_points_at_any_step() -> None:
    motion = exact(0, 2)
    for step in (0.01, 0.005, 0.00125):
        assert error(swing(chain(2), motion, step=step), motion) < 3e-6


def test_driven_closure_settings_lose_the_branch_in_free_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """The negative control: time constant of eight steps, damped critically, as for a machine with a drive."""
    monkeypatch.setattr("conrod.engines.mujoco.free_run.TUNED_TIME_CONSTANT_STEPS", 8.0)
    monkeypatch.setattr("conrod.engines.mujoco.free_run.TUNED_DAMPING_RATIO", 1.0)
    motion = exact(0, 2)
    assert np.abs(swing(chain(2), motion, "tuned").poses - motion.poses).max() > 1.0


def test_load_laws_act_at_every_stage_of_rk4() -> None:
    """An error of first order in the step, as a law held over it would have, would be a hundred times the bound."""
    mechanism, motion = loaded_mechanism(1, len(LOADS)), exact(len(LOADS), 1)
    free = exact(0, 1)
    assert np.abs(motion.poses - free.poses[:FIRST]).max() > 0.1
    assert error(swing(mechanism, motion), motion) < 1e-5
    assert mujoco.get_mjcb_act_bias() is None


# -- older releases ----------------------------------------------------------------------------------------------------


def test_loops_have_no_error_law_before_mujoco_3_7(monkeypatch: pytest.MonkeyPatch) -> None:
    engine: Any = engine_named("mujoco")
    loop, contact = MuJoCoSettings.tuned(SAW, 100), MuJoCoSettings.tuned(CAM, 8000)
    assert engine.expected_error(SAW, loop).position is not None
    bound = engine.expected_error(CAM, contact).position
    monkeypatch.setattr(compat, "CLOSURES_ARE_BOUNDED", False)
    law = engine.expected_error(SAW, loop)
    assert (law.position, law.law) == (None, compat.UNBOUNDED_REASON)
    assert engine.expected_error(CAM, contact).position == bound, "a cam's contact has no connect"


def test_loop_forces_have_no_tolerance_before_mujoco_3_7() -> None:
    assert "torque" in MUJOCO_PRESETS["hardened"].forces
    assert [sorted(without_loop_judgement(one).forces) for one in MUJOCO_PRESETS.values()] == [[], ["contact"], []]
    assert not any(without_loop_judgement(one).judged_free for one in MUJOCO_PRESETS.values())
