"""Ingredients: planted ones are seen for what they do, verdicts follow from numbers, and costs hold on any machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from cell_tasks import answer_study

from conrod import InvalidInput, MuJoCoSettings
from conrod.comparison.plain_values import plain_values
from conrod.engines import engine_named
from conrod.engines.engine import with_fields
from conrod.engines.mujoco import HARDENING_FACTOR, STIFF_SOLIMP
from conrod.engines.mujoco.engine import MuJoCo
from conrod.engines.variants import Ingredient, Quantity
from conrod.execution.paired_timing import PairedTiming
from conrod.execution.run import RunCase, RunResult, measure
from conrod.execution.timing import machine_fingerprint
from conrod.scenes import SCENES
from conrod.studies.ablate import study as ablation
from conrod.studies.ablate.findings import (
    IN_FULL_MODEL,
    JUDGED_ERRORS,
    AblationStudy,
    Effect,
    EngineAblation,
    Evidence,
    IngredientVerdict,
    Role,
    VariantResult,
    evidence_of,
    ingredient_verdict,
    reference_errors,
)
from conrod.studies.ablate.study import (
    AblationCases,
    CostCase,
    CostResult,
    Variant,
    ablate_engine,
    ablation_study,
    motion_change,
)

SCENE = "saw-500rpm"
MINIMAL_ERROR = 4e-11


def timing(ratio: float, half: float = 0.01) -> PairedTiming:
    """A ratio with an interval of so much on both sides."""
    return PairedTiming(ratio, ratio - half, ratio + half, 0.02 * ratio, 0.02, 200)


def variant(
    role: Role, error: float | None = MINIMAL_ERROR, change: float = 0.0, cost: float | None = 1.0, **others: Any
) -> VariantResult:
    """A model whose errors are all of one size; one without an error did not complete."""
    completed = error is not None
    made = VariantResult(
        role=role,
        ingredient="it",
        outcome="completed" if completed else "opened",
        reason="" if completed else "a gap of 0.4 m",
        errors=dict.fromkeys(JUDGED_ERRORS, error) if error is not None else None,
        change=dict.fromkeys(JUDGED_ERRORS[:3], change) if completed else None,
        cost=None if cost is None or not completed else timing(cost),
        cost_in_full=None,
        settings={"timestep": 1e-3},
    )
    return replace(made, **others)


MINIMAL, ROUGH = variant(Role.MINIMAL), variant(Role.MINIMAL, 1e-4)


def shown(role: Role, *facts: Any, base: VariantResult = MINIMAL, **others: Any) -> Evidence:
    """What an ingredient shows that makes a model like this out of a base."""
    return evidence_of(variant(role, *facts, **others), base, reference_errors(ROUGH if base is ROUGH else MINIMAL))


def alone(*facts: Any, **others: Any) -> Callable[[], Evidence]:
    """What an ingredient shows in the minimal model; made in the test, not before it."""
    return lambda: shown(Role.ADDED_TO_MINIMAL, *facts, **others)


def without(*facts: Any, **others: Any) -> Callable[[], Evidence]:
    """What a part of the minimal model shows where it is taken out."""
    return lambda: shown(Role.REMOVED_FROM_MINIMAL, *facts, **others)


def in_full(before: float, after: float, cost: float = 1.0) -> Evidence:
    """What an ingredient shows beside all others."""
    return shown(Role.REMOVED_FROM_FULL, before, base=variant(Role.FULL, after), cost_in_full=timing(1.0 / cost))


def field_ingredient(name: str, values: Any, without: Any, *, minimal: bool = False) -> Ingredient[MuJoCoSettings]:
    """An ingredient that is a value of some fields; without it they have another one."""
    ways = [lambda settings, fields=fields: with_fields(settings, **fields) for fields in (values, without)]
    return Ingredient(name, f"what {name} is", ways[0], ways[1], (Quantity.WEAR,), minimal)


SAW = SCENES[SCENE]
STEPS = 100


def base(machine: Any, steps: int) -> MuJoCoSettings:
    """Hardened without gravity: right in motion, wrong in torque."""
    return replace(MuJoCoSettings.hardened(machine, steps), preset="custom", gravity=False)


# Without an ingredient fields are as the base has them.
PLANTED = (
    field_ingredient("gravity", {"gravity": True}, {"gravity": False}),
    field_ingredient("soft", {"hardening": 1.0}, {"hardening": HARDENING_FACTOR}),  # planted harm
    field_ingredient("more-iterations", {"iterations": 200}, {"iterations": 100}),
    field_ingredient("hardening", {"hardening": HARDENING_FACTOR}, {"hardening": None}, minimal=True),
    field_ingredient("flat", {"solimp": STIFF_SOLIMP}, {"solimp": (0.9999, 0.9999, 0.002, 0.5, 2.0)}, minimal=True),
)


def answer(case: RunCase) -> RunResult:
    """A run in the engine; a timing that no clock took: more iterations cost a third, all else nothing."""
    if not isinstance(case, CostCase):
        return measure(case)
    dear = [settings.iterations > 100 for settings in (case.settings, case.against)]
    return CostResult(timing=timing(1.3 ** (dear[0] - dear[1])))


def test_each_planted_ingredient_is_seen_for_what_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MuJoCo, "ingredients", lambda self, machine, minimal: PLANTED)
    monkeypatch.setattr(MuJoCo, "minimal_settings", lambda self, machine, steps: base(machine, steps))
    cases: list[RunCase] = []

    def noting(case: RunCase) -> RunResult:
        cases.append(case)
        return answer(case)

    found = answer_study(ablate_engine(SCENE, SAW, engine_named("mujoco"), STEPS, 2), noting)
    assert (found.engine, found.version) == ("mujoco", engine_named("mujoco").version)
    assert (found.steps_per_revolution, found.revolutions, found.distrust) == (STEPS, 2.0, "")
    assert found.machine == machine_fingerprint()
    assert {(case.name, case.scene, case.rounds, case.machine) for case in cases if isinstance(case, CostCase)} == {
        (SCENE, SAW, 2, machine_fingerprint())
    }
    verdicts = {one.name: (one.verdict, one.because) for one in found.ingredients}
    assert verdicts == {
        "gravity": (IngredientVerdict.FREE, ""),
        "soft": (IngredientVerdict.HARMFUL, "position"),
        "more-iterations": (IngredientVerdict.COSTLY, ""),
        "hardening": (IngredientVerdict.REQUIRED, verdicts["hardening"][1]),
        "flat": (IngredientVerdict.FREE, ""),
    }
    models = {(one.role, one.ingredient): one for one in found.variants}
    # What does harm, or is needed anyway, is not in the full model, whose motion is the minimal one's.
    full, soft = models[Role.FULL, ""], models[Role.ADDED_TO_MINIMAL, "soft"]
    # Without the iterations the full model costs less, over the full model and not over the minimal one.
    taken = models[Role.REMOVED_FROM_FULL, "more-iterations"]
    assert (taken.cost, taken.cost_in_full) == (timing(1.0), timing(1.3**-1))
    assert (full.cost, full.cost_in_full) == (timing(1.3), None)
    assert (soft.settings["hardening"], full.settings["hardening"]) == (1.0, HARDENING_FACTOR)
    assert full.settings["iterations"] == 200
    assert {name for role, name in models if role is Role.REMOVED_FROM_FULL} == {"gravity", "more-iterations", "flat"}
    assert max((full.change or {"": 1.0}).values()) < 1e-9
    # Negative control: the change of a model that is off is that of its errors, not of nothing.
    assert (soft.change or {})["position"] == pytest.approx((soft.errors or {})["position"], rel=0.01)
    assert (soft.change or {})["position"] > 1e-7


def test_motion_change_needs_two_runs_that_completed() -> None:
    one, other = (
        RunResult("completed", signed={"C": dict.fromkeys(("position", "velocity", "acceleration"), values)})
        for values in ([[0.0, 0.0], [3.0, 4.0]], [[0.0, 1.0], [0.0, 0.0]])
    )
    assert (
        motion_change(one, other)
        == {"position": 5.0, "velocity": 5.0, "acceleration": 5.0}
        == motion_change(other, one)
    )
    assert motion_change(one, one) == {"position": 0.0, "velocity": 0.0, "acceleration": 0.0}
    assert motion_change(one, RunResult("opened")) is None


def test_a_run_without_an_error_is_exact() -> None:
    cases, settings = AblationCases(SCENE, SAW, 2), base(SAW, STEPS)
    sizes = dict.fromkeys(JUDGED_ERRORS, dict.fromkeys(("max", "rms", "final"), 0.0))
    minimal, runs = Variant(Role.MINIMAL, "", settings, settings), dict[str, RunResult]()
    for errors in ({"C": sizes}, {}, None):
        runs[cases.run_case(settings).key] = RunResult("completed", errors=errors)
        found = cases.variant_results([minimal], runs, {})[Role.MINIMAL, ""].errors
        assert found == (None if errors is None else dict.fromkeys(JUDGED_ERRORS, 0.0))


def test_timing_has_a_key_of_both_models_machine_and_rounds() -> None:
    cost = CostCase(SCENE, SAW, base(SAW, STEPS), against=base(SAW, STEPS), machine="a", rounds=2)
    others = ({"against": replace(cost.against, gravity=True)}, {"machine": "b"}, {"rounds": 3})
    keys = {replace(cost, **change).key for change in others}
    assert len(keys | {cost.key, RunCase(SCENE, SAW, cost.settings).key}) == 5
    identity = cost.identity()
    assert [identity[name] for name in ("study", "machine", "rounds")] == ["ablate", "a", 2]
    assert identity["against"] == {k: v for k, v in cost.against.as_dict().items() if k != "preset"}


@pytest.mark.parametrize(
    "kept", [CostResult(timing=timing(1.5)), CostResult("crashed", "signal 11")], ids=["timed", "crashed"]
)
def test_a_kept_timing_is_read_only_whole(kept: CostResult) -> None:
    cost = CostCase(SCENE, SAW, base(SAW, STEPS), against=base(SAW, STEPS), machine="a", rounds=2)
    assert cost.restore_result(plain_values(kept)) == kept
    with pytest.raises(InvalidInput, match="timing"):
        cost.restore_result(plain_values(kept) | {"timing": {"ratio": 1.0}})


def test_a_study_has_the_facts_of_its_scene() -> None:
    found = EngineAblation("mujoco", "1", 100, 2.0, "here", (), ())
    assert ablation_study("mine", SAW, [found], {"exudyn": "no ingredients"}) == AblationStudy(
        name="mine",
        kind=SAW.kind,
        title=SAW.title,
        parameters=dict(SAW.parameters),
        engines=(found,),
        unsupported={"exudyn": "no ingredients"},
        lengths=dict(SAW.lengths),
    )


@pytest.mark.parametrize(
    ("evidence", "expected"),
    [
        # What changes nothing is free, or costly where the whole interval of its cost says so.
        (alone(MINIMAL_ERROR, 1e-12, 1.01), (IngredientVerdict.FREE, "")),
        (alone(MINIMAL_ERROR, 1e-12, 0.7), (IngredientVerdict.FREE, "")),
        (alone(MINIMAL_ERROR, 1e-12, 1.2), (IngredientVerdict.COSTLY, "")),
        (lambda: replace(alone(MINIMAL_ERROR, 0.0, 1.2)(), cost=timing(1.2, half=0.19)), (IngredientVerdict.FREE, "")),
        (lambda: replace(alone(MINIMAL_ERROR, 0.0, 1.2)(), cost=timing(1.06, half=0.03)), (IngredientVerdict.FREE, "")),
        # What makes the motion worse is harmful, whatever it costs.
        *((alone(1e-6, 1e-6, cost), (IngredientVerdict.HARMFUL, "position")) for cost in (0.5, 1.0, 3.0)),
        (alone(None, 0.0, None), (IngredientVerdict.HARMFUL, "opened")),
        # What the motion is wrong without is required; a part that it does not need is no better than what is added.
        (without(1e-5, 1e-5), (IngredientVerdict.REQUIRED, "position")),
        (without(None), (IngredientVerdict.REQUIRED, "opened")),
        (without(MINIMAL_ERROR), (IngredientVerdict.FREE, "")),
        (without(MINIMAL_ERROR, cost=1.0 / 1.3), (IngredientVerdict.COSTLY, "")),
        # Twenty times the minimal model's own error, and yet nothing that anybody asks for.
        (alone(20 * MINIMAL_ERROR, 20 * MINIMAL_ERROR, 1.0), (IngredientVerdict.FREE, "")),
        (alone(MINIMAL_ERROR, 0.0, None), (IngredientVerdict.UNDECIDED, "it could not be timed")),
        # A part without which a rough motion is better is harmful; what only improves it is not required.
        (without(1e-6, 1e-4, base=ROUGH), (IngredientVerdict.HARMFUL, "position, better without it")),
        (alone(1e-6, 1e-4, 3.0, base=ROUGH), (IngredientVerdict.COSTLY, "")),
        # A change below the minimal model's own error is none.
        (alone(1.5e-4, 0.9e-4, base=ROUGH), (IngredientVerdict.FREE, "")),
        # Any quantity can show harm; what an engine cannot do is not told.
        *(
            (
                alone(errors=dict.fromkeys(JUDGED_ERRORS, MINIMAL_ERROR) | {quantity: 1e-5}),
                (IngredientVerdict.HARMFUL, quantity),
            )
            for quantity in JUDGED_ERRORS
        ),
        (alone(None, outcome="unsupported", reason="it has no rod"), (IngredientVerdict.UNDECIDED, "it has no rod")),
    ],
)
def test_verdicts_on_one_piece_of_evidence(
    evidence: Callable[[], Evidence], expected: tuple[IngredientVerdict, str]
) -> None:
    assert ingredient_verdict([evidence()]) == expected


def test_harm_beside_all_others_counts_and_is_told_so() -> None:
    harmless = alone(MINIMAL_ERROR, 0.0, 1.0)()
    assert ingredient_verdict([harmless, in_full(MINIMAL_ERROR, 1e-5)]) == (
        IngredientVerdict.HARMFUL,
        f"position, {IN_FULL_MODEL}",
    )
    assert ingredient_verdict([harmless, in_full(1e-5, MINIMAL_ERROR)]) == (
        IngredientVerdict.REQUIRED,
        f"position, {IN_FULL_MODEL}",
    )
    assert ingredient_verdict([harmless, in_full(MINIMAL_ERROR, MINIMAL_ERROR, 1.4)]) == (
        IngredientVerdict.COSTLY,
        IN_FULL_MODEL,
    )
    # Where a model is wrong with it and without, it tells nothing, and what is known otherwise stays.
    assert ingredient_verdict([harmless, in_full(1e-5, 1e-5)])[0] is IngredientVerdict.FREE
    assert ingredient_verdict([in_full(1e-5, 1e-5)])[0] is IngredientVerdict.UNDECIDED
    # Nor is a quantity said to be seen beside all others where nothing else was tried.
    assert ingredient_verdict([in_full(MINIMAL_ERROR, 1e-5)]) == (IngredientVerdict.HARMFUL, "position")
    assert ingredient_verdict([alone(1e-6)(), in_full(1e-5, MINIMAL_ERROR)]) == (IngredientVerdict.HARMFUL, "position")


def test_evidence_has_the_change_and_cost_of_an_ingredient() -> None:
    added = alone(MINIMAL_ERROR, 1e-12, 1.25)()
    assert (added.full, added.cost, added.change) == (False, timing(1.25), dict.fromkeys(JUDGED_ERRORS[:3], 1e-12))
    # What a model costs without a part is the inverse of what the part costs.
    removed = without(MINIMAL_ERROR, 0.0, 0.8)()
    assert removed.cost == timing(0.8).inverse
    full = in_full(MINIMAL_ERROR, MINIMAL_ERROR, 1.25)
    assert (full.full, full.cost) == (True, timing(0.8).inverse)
    assert without(None)().cost is None


def test_ingredient_is_undecided_when_wrong_with_and_without_it() -> None:
    found = shown(Role.REMOVED_FROM_FULL, 1e-5, base=variant(Role.FULL, None))
    assert (found.effect, found.because) == (Effect.UNDECIDED, "wrong with it and without: opened")
    assert ingredient_verdict([found]) == (IngredientVerdict.UNDECIDED, "wrong with it and without: opened")
    assert ingredient_verdict([]) == (IngredientVerdict.UNDECIDED, "")


def test_reference_errors_are_the_minimal_models_or_a_floor() -> None:
    own = variant(Role.MINIMAL, errors={"position": 1e-3, "velocity": 1e-12})
    assert reference_errors(own) == {"position": 1e-3, "velocity": 1e-9, "acceleration": 1e-9, "total": 1e-9}
    assert reference_errors(variant(Role.MINIMAL, None)) == dict.fromkeys(JUDGED_ERRORS, 1e-9)


@pytest.mark.parametrize(
    ("before", "after", "harmful"),
    [
        (1.0e-4, 1.9e-4, False),  # not twice as large
        (0.9e-4, 1.9e-4, True),
        (1e-13, 1.0e-4, True),
        (1e-13, 0.9e-4, False),  # below the minimal model's
    ],
)
def test_a_part_without_which_the_error_halves_is_harmful(before: float, after: float, harmful: bool) -> None:
    found = evidence_of(
        variant(Role.REMOVED_FROM_MINIMAL, before), variant(Role.MINIMAL, after), reference_errors(ROUGH)
    )
    expected = (Effect.WORSE, "position, better without it") if harmful else (Effect.NONE, "")
    assert (found.effect, found.because) == expected


def test_a_model_is_found_by_its_role_and_ingredient() -> None:
    models = (variant(Role.MINIMAL, ingredient=""), variant(Role.FULL, ingredient=""), variant(Role.ADDED_TO_MINIMAL))
    found = EngineAblation("mujoco", "1", 100, 2.0, "here", (), models)
    assert (found.variant(Role.FULL), found.variant(Role.MINIMAL)) == (models[1], models[0])
    assert found.variant(Role.ADDED_TO_MINIMAL, "it") is models[2]
    assert found.variant(Role.ADDED_TO_MINIMAL) is found.variant(Role.REMOVED_FROM_FULL, "it") is None
    study = AblationStudy(
        "saw", "saw", "Saw", {}, (found, replace(found, distrust="a"), replace(found, distrust="b")), {}
    )
    assert study.distrust == "a; b"


def test_a_cost_is_timed_of_both_settings_in_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def time_pair(*given: Any, **named: Any) -> PairedTiming:
        asked.append((given, named))
        return timing(1.5)

    monkeypatch.setattr(ablation, "time_settings_pair", time_pair)
    settings, against = base(SAW, STEPS), base(SAW, 2 * STEPS)
    found = CostCase(SCENE, SAW, settings, against=against, machine="a", rounds=7).perform()
    assert found == CostResult(timing=timing(1.5))
    assert asked == [((engine_named("mujoco"), SAW, settings, against), {"rounds": 7})]


@pytest.mark.parametrize(("factor", "effect"), [(2.0, Effect.NONE), (2.001, Effect.REQUIRED)])
def test_ingredient_is_required_beyond_twice_the_minimal_error(factor: float, effect: Effect) -> None:
    assert shown(Role.REMOVED_FROM_MINIMAL, factor * 1e-4, base=ROUGH).effect is effect
