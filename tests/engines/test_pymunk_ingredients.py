"""pymunk: ingredients do to the model what is said of them, and leave the motion unless they are harmful."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pymunk
import pytest
from catalogue import CAM, PRESS, SCENES
from cell_tasks import answer_study

from conrod import InvalidInput, compare
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.engines.pymunk import PymunkSettings, iterations_needed, model_edits
from conrod.engines.pymunk.distance_rods import _unwrap_rotations, find_rods
from conrod.engines.pymunk.dynamics import build_at_angle
from conrod.engines.pymunk.space import PymunkSpace
from conrod.engines.run import run_in_one_piece
from conrod.engines.variants import Ingredient
from conrod.execution.paired_timing import PairedTiming
from conrod.execution.run import RunCase, RunResult, measure
from conrod.scenes import catalogue_scene
from conrod.studies.ablate.findings import EngineAblation, IngredientVerdict, Role
from conrod.studies.ablate.report import absent_words, largest_gain
from conrod.studies.ablate.study import CostCase, CostResult, ablate_engine, ablation_study

PYMUNK: Any = engine_named("pymunk")
SAW = SCENES["saw-500rpm"]
MACHINES: dict[str, Any] = {"press": PRESS, "saw": SAW}
STEPS = 1000
QUANTITIES = ("position", "velocity", "acceleration")


@cache
def minimal_of(machine: str) -> PymunkSettings:
    found: PymunkSettings = PYMUNK.minimal_settings(MACHINES[machine], STEPS)
    return found


@cache
def ingredients_of(machine: str) -> dict[str, Ingredient[PymunkSettings]]:
    found = PYMUNK.ingredients(MACHINES[machine], minimal_of(machine))
    return {one.name: one for one in found if not one.refusal}


def with_one(machine: str, name: str) -> PymunkSettings:
    """The minimal model with an ingredient, or without one of its own."""
    one = ingredients_of(machine)[name]
    return (one.removed if one.minimal else one.added)(minimal_of(machine))


@cache
def errors(machine: str, settings: PymunkSettings) -> dict[str, float]:
    found = run_in_one_piece(PYMUNK, MACHINES[machine], settings, 1.0)
    assert found.outcome is Outcome.COMPLETED, found.reason
    compared = compare(found, MACHINES[machine])
    return {quantity: compared.worst(quantity) for quantity in QUANTITIES}


def counts(made: PymunkSpace) -> dict[str, int]:
    """Bodies, joints of each kind, shapes and iterations of a space."""
    space = made.space
    joints = Counter(type(one).__name__ for one in space.constraints)
    moving = [one for one in space.bodies if one.body_type != pymunk.Body.STATIC]
    return {"bodies": len(moving), **joints, "shapes": len(space.shapes), "iterations": space.iterations}


# -- what an ingredient does to the model ------------------------------------------------------------------------------

MINIMAL = {"bodies": 2, "PinJoint": 1, "GrooveJoint": 1, "shapes": 0, "iterations": 21}
BODIES = {"bodies": 3, "PivotJoint": 2, "GrooveJoint": 1, "shapes": 0, "iterations": 147}
CHANGED = {
    "filtered-shapes": MINIMAL | {"shapes": 2},
    "touching-shapes": BODIES | {"shapes": 3},
    "gravity": MINIMAL,
    "rod-body": BODIES,
    "light-rod-body": BODIES,
    "iterations-1000": MINIMAL | {"iterations": 1000},
    "redundant-joints": MINIMAL | {"PinJoint": 2, "GrooveJoint": 2},
    "closure": {name: count for name, count in MINIMAL.items() if name != "PinJoint"},
    "full-correction": MINIMAL,
    "iterations": MINIMAL | {"iterations": 1},
}


def test_each_ingredient_changes_the_space_as_it_says() -> None:
    made = {name: build_at_angle(SAW, with_one("saw", name), 0.0) for name in ingredients_of("saw")}
    least = build_at_angle(SAW, minimal_of("saw"), 0.0)
    assert counts(least) == MINIMAL
    assert {name: counts(one) for name, one in made.items()} == CHANGED
    assert (least.space.gravity, made["gravity"].space.gravity) == ((0.0, 0.0), (0.0, -9.81))
    masses = [made[name].body_of("rod").mass for name in ("rod-body", "light-rod-body")]
    assert masses == [1.5, 1.5e-3]
    assert {one.error_bias for one in least.space.constraints} == {0.0}
    assert {one.error_bias for one in made["full-correction"].space.constraints} == {(1.0 - 0.1) ** 60}
    # Shapes of the one kind never touch; those of the other collide where joints hold links together.
    assert {shape.filter.mask for shape in made["filtered-shapes"].space.shapes} == {0}
    colliding = {name: {one.collide_bodies for one in made[name].space.constraints} for name in CHANGED}
    assert colliding == {name: {name == "touching-shapes"} for name in CHANGED}


def test_an_ingredient_is_removed_from_the_full_model_alone() -> None:
    own = ingredients_of("saw")
    full = minimal_of("saw")
    for name in ("filtered-shapes", "gravity", "rod-body", "iterations-1000", "redundant-joints"):
        full = own[name].added(full)
    without = {name: counts(build_at_angle(SAW, own[name].removed(full), 0.0)) for name in own}
    twice = {"PivotJoint": 4, "GrooveJoint": 2}
    everything = BODIES | twice | {"shapes": 3, "iterations": 1000}
    assert counts(build_at_angle(SAW, full, 0.0)) == everything
    assert without["filtered-shapes"] == everything | {"shapes": 0}
    assert without["iterations-1000"] == everything | {"iterations": 147}
    assert without["redundant-joints"] == BODIES | {"shapes": 3, "iterations": 1000}
    rods = MINIMAL | {"PinJoint": 2, "GrooveJoint": 2, "shapes": 2, "iterations": 1000}
    assert without["rod-body"] == rods


# -- the motion --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("machine", MACHINES)
def test_harmless_ingredients_leave_the_errors_as_they_are(machine: str) -> None:
    base = errors(machine, minimal_of(machine))
    tuned = errors(machine, replace(PymunkSettings.tuned(MACHINES[machine], STEPS), gravity=False))
    for name in ("filtered-shapes", "gravity"):
        # What is only looked at, or acts on no prescribed motion, leaves rounding.
        assert errors(machine, with_one(machine, name)) == pytest.approx(base, rel=1e-6), name
    for name in ("rod-body", "iterations-1000", "redundant-joints"):
        # The scheme's own error is there before and after; the iteration may add 1 % of it.
        assert errors(machine, with_one(machine, name)) == pytest.approx(base, rel=0.05), name
    assert errors(machine, with_one(machine, "rod-body")) == pytest.approx(tuned, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "outcomes"),
    [
        ("touching-shapes", (Outcome.OPENED,)),
        ("light-rod-body", (Outcome.EXPLODED, Outcome.OPENED)),
        ("closure", (Outcome.OPENED,)),
    ],
)
def test_harmful_ingredients_end_the_run(name: str, outcomes: tuple[Outcome, ...]) -> None:
    assert run_in_one_piece(PYMUNK, SAW, with_one("saw", name), 2.0).outcome in outcomes


def test_a_run_with_distance_rods_is_the_same_in_pieces() -> None:
    settings = with_one("saw", "gravity")
    whole = run_in_one_piece(PYMUNK, SAW, settings, 0.3, 1.0)
    parts = [one.trajectory for one in PYMUNK.run(SAW, settings, 0.3, 1.0, 7)]
    for states in ("position", "velocity", "acceleration"):
        pieces = [getattr(one.bodies, states) for one in parts]
        for values in ("poses", "rates"):
            together = np.vstack([getattr(one, values) for one in pieces])
            assert np.array_equal(together, getattr(getattr(whole.bodies, states), values)), (states, values)


def test_a_rod_that_turns_is_counted_over_whole_turns() -> None:
    """As that of a drag link, whose crank and output turn fully."""
    turn = np.linspace(-3.0, 20.0, 200)
    wrapped = np.arctan2(np.sin(turn), np.cos(turn))
    assert np.allclose(_unwrap_rotations(wrapped, -3.0), turn)
    assert np.allclose(_unwrap_rotations(wrapped, -3.0 + 4.0 * np.pi), turn + 4.0 * np.pi)
    assert not np.allclose(wrapped, turn)


@pytest.mark.slow
def test_iterations_needed_of_distance_rods_are_enough_and_few() -> None:
    """Errors in acceleration at the iterations of the theory, and at a third of them, over those at many."""
    machine: Any = catalogue_scene("six-bar")
    minimal = PYMUNK.minimal_settings(machine, STEPS)
    rods = find_rods(machine.kinematics.mechanism)
    assert minimal.iterations == iterations_needed(machine.kinematics, machine.speed, rods)
    assert minimal.iterations < PymunkSettings.tuned(machine, STEPS).iterations

    def acceleration(iterations: int) -> float:
        settings = replace(minimal, iterations=iterations)
        return float(compare(run_in_one_piece(PYMUNK, machine, settings, 0.1), machine).worst("acceleration"))

    best = acceleration(2000)
    assert acceleration(minimal.iterations) == pytest.approx(best, rel=0.05)
    assert acceleration(minimal.iterations // 3) > 2.0 * best


# -- settings ----------------------------------------------------------------------------------------------------------


def test_settings_without_edits_have_the_keys_of_before() -> None:
    plain = PymunkSettings.tuned(SAW, STEPS)
    assert "dressing" not in plain.as_dict()
    edited = replace(plain, dressing=("redundant-joints", "distance-rods", "redundant-joints"))
    assert edited.as_dict()["dressing"] == ["distance-rods", "redundant-joints"]
    keys = {RunCase("saw", SAW, settings).key for settings in (plain, edited)}
    assert len(keys) == 2


def test_an_edit_that_does_not_apply_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"unknown dressing 'distance-rod'.*did you mean 'distance-rods'"):
        replace(minimal_of("saw"), dressing=("distance-rod",))
    for scene, name in ((CAM, "distance-rods"), (CAM, "touching-shapes"), (SAW, "no-contact")):
        assert name in PYMUNK.refusal(scene, replace(PymunkSettings.tuned(scene, 100), dressing=(name,)))


def test_an_edited_model_reports_no_forces_and_writes_no_module() -> None:
    found = PYMUNK.forces(SAW, minimal_of("saw"), 0.1)
    assert found.drive_torque is None
    assert "edited" in found.unsupported["drive torque"]
    assert PYMUNK.expected_forces(SAW, minimal_of("saw"), 0.1) is None
    with pytest.raises(InvalidInput, match="no edits"):
        PYMUNK.model("saw", SAW, minimal_of("saw"))


# -- the study ---------------------------------------------------------------------------------------------------------


def answer(case: RunCase) -> RunResult:
    """A run in the engine; a timing by the number of iterations, that no clock took."""
    if not isinstance(case, CostCase):
        return measure(case)
    one, other = (settings.iterations for settings in (case.settings, case.against))  # type: ignore[attr-defined]
    return CostResult(timing=PairedTiming(one / other, 0.99 * one / other, 1.01 * one / other, 1.0, 1.0, 2))


def ablated(scene: Any = SAW) -> EngineAblation:
    found: EngineAblation = answer_study(ablate_engine("saw", scene, PYMUNK, 200, 2), answer)
    return found


@pytest.fixture(scope="module")
def found() -> EngineAblation:
    return ablated()


def verdicts(found: EngineAblation) -> dict[str, IngredientVerdict]:
    return {one.name: one.verdict for one in found.ingredients}


def test_verdicts_follow_from_what_ingredients_do(found: EngineAblation) -> None:
    free, costly = IngredientVerdict.FREE, IngredientVerdict.COSTLY
    harmful, required = IngredientVerdict.HARMFUL, IngredientVerdict.REQUIRED
    assert verdicts(found) == {
        "filtered-shapes": free,
        "touching-shapes": harmful,
        "gravity": free,
        "rod-body": costly,
        "light-rod-body": harmful,
        "iterations-1000": costly,
        "redundant-joints": free,  # of a cost by iterations alone
        "closure": required,
        "full-correction": required,
        "iterations": required,
    }
    assert found.needless == ("filtered-shapes", "gravity", "rod-body", "iterations-1000", "redundant-joints")


def test_a_report_says_the_gain_of_the_largest_trade(found: EngineAblation) -> None:
    study = ablation_study("saw", SAW, [found], {})
    said = largest_gain({"saw": study})
    assert said.startswith("Of what a naive model of saw contains in pymunk, 5 ingredients can go: that makes a step ")
    assert said.endswith("**47.6 times** cheaper at the same error.")
    assert largest_gain({}) == ""
    # A full model that is far better says at what error the minimal one is cheaper.
    better = [
        replace(one, errors=dict.fromkeys(one.errors or (), 1e-9)) if one.role is Role.FULL else one
        for one in found.variants
    ]
    coarse = largest_gain({"saw": replace(study, engines=(replace(found, variants=tuple(better)),))})
    assert "times the error." in coarse


def shorten_rod(made: PymunkSpace) -> None:
    """Planted: a rod a millimetre short, by what is said to be a shape that touches nothing."""
    for one in made.names:
        if isinstance(one, pymunk.PinJoint):
            one.distance -= 1e-3


def test_a_rod_a_millimetre_short_is_not_called_needless(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model_edits, "EDITS", {**model_edits.EDITS, "filtered-shapes": shorten_rod})
    planted = ablated()
    assert verdicts(planted)["filtered-shapes"] is IngredientVerdict.HARMFUL
    assert "filtered-shapes" not in planted.needless


def test_a_machine_without_an_ingredient_says_so_in_a_line() -> None:
    machine: Any = catalogue_scene("planetary-gear")
    offered = PYMUNK.ingredients(machine, PYMUNK.minimal_settings(machine, 100))
    absent = {one.name: one.refusal for one in offered if one.refusal}
    line = absent_words(EngineAblation("pymunk", "1", 100, 2.0, "here", (), (), absent=absent))
    assert line == (
        "Not on this machine: rod-body and light-rod-body (no link carries nothing but two pins to other moving "
        "links); fine-cam (the machine has no cam)."
    )
    assert absent_words(EngineAblation("pymunk", "1", 100, 2.0, "here", (), ())) == ""
