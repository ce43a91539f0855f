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

from conrod import MuJoCoSettings
from conrod.engines.mujoco.settings import HARDENING, STIFF_SOLIMP
from conrod.runs.plain import plain
from conrod.scenes import SCENES
from conrod.studies.ablate.findings import Effect, EngineAblation, IngredientResult, Role, VariantResult, Verdict
from conrod.studies.ablate.study import CostCase, ablate_engine, change, full_variants, single_variants
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.frame.case import pursue
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase, measure

SAW = SCENES[SCENE]
STEPS = 100


def base(machine: Any, steps: int) -> MuJoCoSettings:
    """Hardened without gravity: right in motion, wrong in torque."""
    return replace(MuJoCoSettings.hardened(machine, steps), preset="custom", gravity=False)


# Without an ingredient fields are as the base has them.
PLANTED = (
    field_ingredient("gravity", {"gravity": True}, {"gravity": False}),
    field_ingredient("soft", {"hardening": 1.0}, {"hardening": HARDENING}),  # planted harm
    field_ingredient("more-iterations", {"iterations": 200}, {"iterations": 100}),
    field_ingredient("hardening", {"hardening": HARDENING}, {"hardening": None}, minimal=True),
    field_ingredient("flat", {"solimp": STIFF_SOLIMP}, {"solimp": (0.9999, 0.9999, 0.002, 0.5, 2.0)}, minimal=True),
)


def answer(case: RunCase) -> Measurement:
    """A run in the engine; a timing that no clock took: more iterations cost a third, all else nothing."""
    if not isinstance(case, CostCase):
        return measure(case)
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
    assert model(found, Role.ADDED, "soft").settings["hardening"] == 1.0
    assert model(found, Role.FULL).settings["hardening"] == HARDENING
    assert [(one.full, one.effect) for one in soft.evidence] == [(False, Effect.WORSE)]


def test_the_dressed_model_has_what_does_no_harm_and_the_minimal_models_motion(found: EngineAblation) -> None:
    dressed = model(found, Role.FULL)
    assert dressed.settings["iterations"] == 200
    assert dressed.change is not None
    assert max(dressed.change.values()) < 1e-9
    # Negative control: the change of a model that is off is that of its errors, not of nothing.
    soft = model(found, Role.ADDED, "soft")
    assert soft.change is not None
    assert soft.errors is not None
    assert soft.change["position"] == pytest.approx(soft.errors["position"], rel=0.01)
    assert soft.change["position"] > 1e-7


def test_what_costs_time_and_does_nothing_is_costly_alone_and_beside_others(found: EngineAblation) -> None:
    assert named(found, "more-iterations").verdict is Verdict.COSTLY
    assert [round(one.cost.ratio, 2) for one in named(found, "more-iterations").evidence if one.cost] == [1.3, 1.3]
    assert named(found, "gravity").verdict is Verdict.FREE


def test_parts_of_the_minimal_model_are_required_or_shown_not_to_be(found: EngineAblation) -> None:
    assert named(found, "hardening").verdict is Verdict.REQUIRED
    assert named(found, "flat").verdict is Verdict.FREE
    # What is needed alone is needed beside others; what is not might be.
    assert found.variant(Role.TAKEN, "hardening") is None
    assert found.variant(Role.TAKEN, "flat") is not None


def test_a_change_is_that_of_the_deviations_of_two_runs_and_of_none_that_did_not_complete() -> None:
    one, other = (
        Measurement("completed", signed={"C": dict.fromkeys(("position", "velocity", "acceleration"), values)})
        for values in ([[0.0, 0.0], [3.0, 4.0]], [[0.0, 1.0], [0.0, 0.0]])
    )
    assert change(one, other) == {"position": 5.0, "velocity": 5.0, "acceleration": 5.0} == change(other, one)
    assert change(one, one) == {"position": 0.0, "velocity": 0.0, "acceleration": 0.0}
    assert change(one, Measurement("opened")) is None


def test_a_change_is_most_of_what_the_whole_runs_differ_by(found: EngineAblation) -> None:
    runs = [measure(RunCase(SCENE, SAW, base(SAW, n), signed_angles=20)) for n in (STEPS, 2 * STEPS)]
    seen, error = change(*runs), runs[0].largest("position")
    assert seen is not None
    assert error is not None
    # Order 4: all but a sixteenth of the coarser one's error, which is largest at some other angle.
    assert 0.5 * error < seen["position"] < error
    assert np.isclose(seen["position"], error, rtol=0.3)


def test_a_timing_of_other_models_elsewhere_or_in_more_rounds_is_another_one() -> None:
    settings = base(SAW, STEPS)
    cost = CostCase(SCENE, SAW, settings, against=settings, machine="a", rounds=2)
    heavy = replace(cost, against=replace(settings, gravity=True))
    keys = {RunCase(SCENE, SAW, settings).key, cost.key, heavy.key, replace(cost, machine="b").key}
    assert len(keys | {replace(cost, rounds=3).key}) == 5


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
    assert full_variants(settings, ()) == ()
