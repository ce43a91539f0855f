"""A study of ingredients in a real engine: planted ingredients are seen for what they do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ablations import SCENE, Planted, field_ingredient, timing
from cell_tasks import Here, assigned

from conrod import MuJoCoSettings, PymunkSettings, compare, run
from conrod.engines.mujoco.settings import HARDENING, STIFF_SOLIMP
from conrod.runs.plain import plain
from conrod.scenes import SCENES, Saw
from conrod.studies.ablate.case import ChangeCase, CostCase, Deviation, measure_change, observe
from conrod.studies.ablate.findings import Effect, EngineAblation, IngredientResult, Role, VariantResult, Verdict
from conrod.studies.ablate.study import ablate_engine, full_variants, single_variants
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.frame.case import pursue
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement

SAW = SCENES[SCENE]
STEPS = 100


def base(machine: Any, steps: int) -> MuJoCoSettings:
    """Hardened without gravity: right in motion, wrong in torque."""
    return replace(MuJoCoSettings.hardened(machine, steps), preset="custom", gravity=False)


# Without an ingredient fields are as the base has them.
PLANTED = (
    field_ingredient("gravity", {"gravity": True}, {"gravity": False}),
    field_ingredient("soft", {"hardening": 1.0}, {"hardening": HARDENING}),  # planted harm
    field_ingredient("more-iterations", {"iterations": 150}, {"iterations": 100}, group="iterations"),
    field_ingredient("most-iterations", {"iterations": 200}, {"iterations": 100}, group="iterations"),
    field_ingredient("hardening", {"hardening": HARDENING}, {"hardening": None}, minimal=True),
    field_ingredient("flat", {"solimp": STIFF_SOLIMP}, {"solimp": (0.9999, 0.9999, 0.002, 0.5, 2.0)}, minimal=True),
)


def answer(case: ChangeCase | CostCase) -> Measurement:
    """A run in the engine; a timing that no clock took: more iterations cost a third, all else nothing."""
    if isinstance(case, ChangeCase):
        return measure_change(case)
    dear = [settings.iterations > 100 for settings in (case.settings, case.against)]  # type: ignore[attr-defined]
    return Measurement("completed", beside={"paired": plain(timing(1.3 ** (dear[0] - dear[1])))})


def studied(run: Callable[[list[Any]], Any], planted: tuple[Any, ...] = PLANTED, steps: int = STEPS) -> EngineAblation:
    """The study of the saw with planted ingredients."""
    engine: Any = Planted(planted, base)  # not all of an engine
    return pursue([ablate_engine(SCENE, SAW, engine, steps, 2)], run)[0]


@pytest.fixture(scope="module")
def found() -> EngineAblation:
    known: dict[str, Measurement] = {}

    def run(cases: list[Any]) -> dict[str, Measurement]:
        known.update({case.key: answer(case) for case in cases if case.key not in known})
        return known

    return studied(run)


def named(found: EngineAblation, name: str) -> IngredientResult:
    return next(one for one in found.ingredients if one.name == name)


def model(found: EngineAblation, role: Role, name: str = "") -> VariantResult:
    made = found.variant(role, name)
    assert made is not None
    return made


def test_a_planted_harmful_ingredient_is_called_harmful_and_is_not_worn(found: EngineAblation) -> None:
    soft = named(found, "soft")
    assert (soft.verdict, soft.because) == (Verdict.HARMFUL, "position")
    dressed, harmed = model(found, Role.FULL), model(found, Role.HARMED, "soft")
    assert dressed.settings["hardening"] == HARDENING
    assert harmed.settings["hardening"] == model(found, Role.ALL).settings["hardening"] == 1.0
    assert [one.full for one in soft.evidence] == [False, True]
    assert all(one.effect is Effect.WORSE for one in soft.evidence)


def test_the_dressed_model_has_the_last_of_each_group_and_the_minimal_models_motion(found: EngineAblation) -> None:
    dressed = model(found, Role.FULL)
    assert dressed.settings["iterations"] == 200
    assert found.variant(Role.TAKEN, "more-iterations") is None
    assert dressed.change is not None
    assert max(dressed.change.values()) < 1e-9
    # Negative control: the change of a model that is off is that of its errors, not of nothing.
    soft = model(found, Role.ADDED, "soft")
    assert soft.change is not None
    assert soft.errors is not None
    assert soft.change["position"] == pytest.approx(soft.errors["position"], rel=0.01)
    assert soft.change["position"] > 1e-7


def test_what_costs_time_and_does_nothing_is_costly_alone_and_beside_others(found: EngineAblation) -> None:
    assert named(found, "most-iterations").verdict is Verdict.COSTLY
    assert named(found, "more-iterations").verdict is Verdict.COSTLY
    assert [round(one.cost.ratio, 2) for one in named(found, "most-iterations").evidence if one.cost] == [1.3, 1.3]


def test_parts_of_the_minimal_model_are_required_or_shown_not_to_be(found: EngineAblation) -> None:
    assert named(found, "hardening").verdict is Verdict.REQUIRED
    assert named(found, "flat").verdict is Verdict.FREE


def test_gravity_is_free_for_the_motion_and_required_for_the_drive_torque(found: EngineAblation) -> None:
    gravity = named(found, "gravity")
    assert gravity.verdict is Verdict.FREE
    assert gravity.torque == "required"
    minimal, heavy = model(found, Role.MINIMAL), model(found, Role.ADDED, "gravity")
    assert minimal.torque_error is not None
    assert heavy.torque_error is not None
    # The weight of the links is a few thousandths of the torque's peak at 500 rpm.
    assert minimal.torque_error > 1e-3
    assert heavy.torque_error < 1e-5
    assert named(found, "most-iterations").torque == ""


def test_grueblers_count_is_that_of_the_compiled_model(found: EngineAblation) -> None:
    count = model(found, Role.MINIMAL).mobility
    assert count is not None
    assert (count.coordinates, count.most_rank, count.freedom, count.missing) == (3, 2, 1, 0)
    assert count.empty == ("slider-pin z",)
    # Negative control: an open loop leaves two freedoms more, which are missing constraints.
    open_loop = replace(base(SAW, STEPS), dressing=("open-loops",))
    seen = measure_change(ChangeCase(SCENE, SAW, open_loop, against=base(SAW, STEPS)))
    assert seen.outcome != "completed"
    assert seen.beside is not None
    assert seen.beside["mobility"]["coordinates"] - seen.beside["mobility"]["most_rank"] == 3


def test_errors_and_torque_are_those_of_a_run_kept_whole() -> None:
    settings = MuJoCoSettings.tuned(SAW, STEPS)
    whole = compare(run(SAW, settings, 2.0), SAW)
    seen = observe(SAW, settings, 2.0)
    for point, errors in seen.errors.items():
        for quantity, sizes in errors.items():
            assert sizes["max"] == pytest.approx(getattr(whole.points[point], quantity).size.max, rel=1e-12)
    assert seen.torque_error is not None
    assert seen.torque is not None
    assert len(seen.torque.times) == 2 * STEPS


def test_runs_of_other_steps_are_compared_where_both_have_samples() -> None:
    coarse = observe(SAW, PymunkSettings.tuned(SAW, STEPS), 2.0)
    fine = observe(SAW, PymunkSettings.tuned(SAW, 2 * STEPS), 2.0)
    for point, motion in coarse.motion.items():
        change = motion["position"].difference(fine.motion[point]["position"])
        error = coarse.errors[point]["position"]["max"]
        # Order 2: three quarters of the coarser one's error.
        assert change == pytest.approx(0.75 * error, rel=0.1)
        assert change == fine.motion[point]["position"].difference(motion["position"])
        assert motion["velocity"].difference(motion["velocity"]) == 0.0


def test_deviations_are_interpolated_and_not_the_motion() -> None:
    # Two perfect runs with samples at other instants differ by nothing.
    point, step = SAW.output, SAW.period / STEPS
    times = [step * (np.arange(STEPS) + stamp) for stamp in (0.0, 0.5)]
    perfect = [Deviation(at, np.zeros((STEPS, 2))) for at in times]
    assert perfect[0].difference(perfect[1]) == 0.0
    # Negative control: the motions themselves, interpolated, would seem to.
    motions = [Deviation(at, SAW.reference(at).point(point).position / SAW.lengths[point]) for at in times]
    assert motions[0].difference(motions[1]) > 1e-4


def test_a_run_of_another_kind_of_cell_is_another_run() -> None:
    settings = base(SAW, STEPS)
    one = ChangeCase(SCENE, SAW, settings, against=settings)
    other = ChangeCase(SCENE, SAW, settings, against=replace(settings, gravity=True))
    cost = CostCase(SCENE, SAW, settings, against=settings, machine="a", rounds=2)
    keys = {one.key, other.key, cost.key, replace(cost, machine="b").key, replace(cost, rounds=3).key}
    assert len(keys) == 5
    assert one.key == ChangeCase("another name", Saw(**dict(SAW.parameters)), settings, against=settings).key


def test_a_study_that_the_ledger_has_makes_no_run_and_takes_no_cost(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "l.sqlite") as ledger, Here() as executor:
        first = studied(lambda cases: run_cases(cases, ledger, executor), PLANTED[:1], 40)
        again = studied(lambda cases: run_cases(assigned(cases, never), ledger, executor), PLANTED[:1], 40)
    assert again == first
    assert {one.cost.rounds for one in first.variants if one.cost is not None} == {2}


def never(cell: object) -> Measurement:
    raise AssertionError("the ledger has it")


def test_a_model_without_ingredients_has_no_dressed_one() -> None:
    settings = base(SAW, STEPS)
    assert [v.role for v in single_variants(settings, ())] == [Role.MINIMAL]
    assert full_variants(settings, (), set()) == ()
    assert full_variants(settings, PLANTED[:2], {"gravity", "soft"}) == ()


def test_a_difference_is_the_largest_over_the_samples_that_both_have() -> None:
    times = np.array([0.0, 1.0, 2.0])
    one = Deviation(times, np.array([[0.0, 0.0], [3.0, 4.0], [0.0, 0.0]]))
    other = Deviation(times[:2], np.zeros((2, 2)))
    assert one.difference(other) == other.difference(one) == 5.0
    half = Deviation(np.array([0.5, 2.5]), np.zeros((2, 2)))
    assert half.difference(one) == 2.5
