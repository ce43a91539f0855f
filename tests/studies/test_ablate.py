"""Ingredients: planted ones are seen for what they do, verdicts follow from numbers, and costs hold on any machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from cell_tasks import Here, assigned

from conrod import MuJoCoSettings
from conrod.engines import engine_named
from conrod.engines.engine import with_fields
from conrod.engines.mujoco import HARDENING, STIFF_SOLIMP
from conrod.engines.mujoco.engine import MuJoCo
from conrod.engines.variants import Ingredient, Quantity
from conrod.runs.plain import plain
from conrod.scenes import SCENES, catalogue_scene
from conrod.studies import ablate_findings as rules
from conrod.studies.ablate import CostCase, ablate_engine, change
from conrod.studies.ablate_findings import (
    BESIDE_OTHERS,
    JUDGED,
    Effect,
    EngineAblation,
    Evidence,
    IngredientResult,
    Role,
    VariantResult,
    Verdict,
    costs_time,
    evidence_of,
    levels,
    verdict,
)
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.frame.case import Measurement, pursue
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.paired_timing import PairedTiming, time_pair
from conrod.studies.frame.run import RunCase, measure

SCENE = "saw-500rpm"


MINIMAL_ERROR = 4e-11


def timing(ratio: float, half: float = 0.01) -> PairedTiming:
    """A ratio with an interval of so much on both sides."""
    return PairedTiming(ratio, ratio - half, ratio + half, 0.02 * ratio, 0.02, 200)


def variant(
    role: Role,
    ingredient: str = "",
    error: float | None = MINIMAL_ERROR,
    change: float = 0.0,
    cost: float | None = 1.0,
    **others: Any,
) -> VariantResult:
    """A model whose errors are all of one size; one without an error did not complete."""
    completed = error is not None
    made = VariantResult(
        role=role,
        ingredient=ingredient,
        outcome="completed" if completed else "opened",
        reason="" if completed else "a gap of 0.4 m",
        errors=dict.fromkeys(JUDGED, error) if error is not None else None,
        change=dict.fromkeys(JUDGED[:3], change) if completed else None,
        cost=None if cost is None or not completed else timing(cost),
        cost_in_full=None,
        settings={"timestep": 1e-3},
    )
    return replace(made, **others)


MINIMAL = variant(Role.MINIMAL)


def alone(error: float | None, change: float, cost: float | None) -> Evidence:
    """What an ingredient shows that makes the minimal model like this."""
    added = variant(Role.ADDED, "it", error, change, cost)
    return evidence_of(added, MINIMAL, levels(MINIMAL))


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
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MuJoCo, "ingredients", lambda self, machine, minimal: planted)
        patch.setattr(MuJoCo, "minimal", lambda self, machine, steps: base(machine, steps))
        return pursue([ablate_engine(SCENE, SAW, engine_named("mujoco"), steps, 2)], run)[0]


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


LEVEL = levels(MINIMAL)


def without(error: float | None, cost: float = 1.0) -> Evidence:
    """What a part of the minimal model shows without which it is like this."""
    reduced = variant(Role.REDUCED, "it", error, error or 0.0, 1.0 / cost)
    return evidence_of(reduced, MINIMAL, LEVEL)


def of_rough(role: Role, error: float, change: float, cost: float = 1.0) -> Evidence:
    """What an ingredient shows beside a minimal model whose motion is rough."""
    rough = variant(Role.MINIMAL, error=1e-4)
    return evidence_of(variant(role, "it", error, change, cost), rough, levels(rough))


def in_full(before: float | None, after: float | None, cost: float = 1.0) -> Evidence:
    """What an ingredient shows beside all others."""
    taken, full = variant(Role.TAKEN, "it", before, cost_in_full=timing(1.0 / cost)), variant(Role.FULL, "", after)
    return evidence_of(taken, full, LEVEL)


@pytest.mark.parametrize(
    ("evidence", "expected"),
    [
        # What changes nothing is free, or costly where the whole interval of its cost says so.
        (alone(MINIMAL_ERROR, 1e-12, 1.01), (Verdict.FREE, "")),
        (alone(MINIMAL_ERROR, 1e-12, 0.7), (Verdict.FREE, "")),
        (alone(MINIMAL_ERROR, 1e-12, 1.2), (Verdict.COSTLY, "")),
        (replace(alone(MINIMAL_ERROR, 0.0, 1.2), cost=timing(1.2, half=0.19)), (Verdict.FREE, "")),
        # What makes the motion worse is harmful, whatever it costs.
        *((alone(1e-6, 1e-6, cost), (Verdict.HARMFUL, "position")) for cost in (0.5, 1.0, 3.0)),
        (alone(None, 0.0, None), (Verdict.HARMFUL, "opened")),
        # What the motion is wrong without is required; a part that it does not need is no better than what is added.
        (without(1e-5), (Verdict.REQUIRED, "position")),
        (without(None), (Verdict.REQUIRED, "opened")),
        (without(MINIMAL_ERROR), (Verdict.FREE, "")),
        (without(MINIMAL_ERROR, cost=1.3), (Verdict.COSTLY, "")),
        # Twenty times the minimal model's own error, and yet nothing that anybody asks for.
        (alone(20 * MINIMAL_ERROR, 20 * MINIMAL_ERROR, 1.0), (Verdict.FREE, "")),
        (alone(MINIMAL_ERROR, 0.0, None), (Verdict.UNDECIDED, "it could not be timed")),
        # A part without which a rough motion is better is harmful; what only improves it is not required.
        (of_rough(Role.REDUCED, 1e-6, 1e-4), (Verdict.HARMFUL, "position, better without it")),
        (of_rough(Role.ADDED, 1e-6, 1e-4, 3.0), (Verdict.COSTLY, "")),
        # A change below the minimal model's own error is none.
        (of_rough(Role.ADDED, 1.5e-4, 0.9e-4), (Verdict.FREE, "")),
    ],
)
def test_verdicts_on_one_piece_of_evidence(evidence: Evidence, expected: tuple[Verdict, str]) -> None:
    assert verdict([evidence]) == expected


@pytest.mark.parametrize("quantity", JUDGED)
def test_every_quantity_can_show_harm(quantity: str) -> None:
    errors = dict.fromkeys(JUDGED, MINIMAL_ERROR) | {quantity: 1e-5}
    added = replace(variant(Role.ADDED, "it"), errors=errors)
    found = evidence_of(added, MINIMAL, LEVEL)
    assert verdict([found]) == (Verdict.HARMFUL, quantity)


@pytest.mark.parametrize(
    ("name", "value", "right", "wrong", "evidence"),
    [
        ("COSTS", 1.5, Verdict.COSTLY, Verdict.FREE, lambda: alone(MINIMAL_ERROR, 0.0, 1.2)),
        ("COSTS", 0.9, Verdict.FREE, Verdict.COSTLY, lambda: alone(MINIMAL_ERROR, 0.0, 1.0)),
        ("AS_GOOD", 1e6, Verdict.HARMFUL, Verdict.FREE, lambda: alone(1e-6, 1e-6, 1.0)),
        ("AS_GOOD", 1e-3, Verdict.FREE, Verdict.UNDECIDED, lambda: alone(MINIMAL_ERROR, 0.0, 1.0)),
        ("AS_GOOD", 1e6, Verdict.REQUIRED, Verdict.FREE, lambda: without(1e-5)),
    ],
)
def test_a_wrong_threshold_is_seen(
    name: str, value: float, right: Verdict, wrong: Verdict, evidence: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert callable(evidence)
    assert verdict([evidence()])[0] is right
    monkeypatch.setattr(rules, name, value)
    assert verdict([evidence()])[0] is wrong


def test_harm_beside_all_others_counts_and_is_told_so() -> None:
    harmless = alone(MINIMAL_ERROR, 0.0, 1.0)
    assert verdict([harmless, in_full(MINIMAL_ERROR, 1e-5)]) == (Verdict.HARMFUL, f"position, {BESIDE_OTHERS}")
    assert verdict([harmless, in_full(1e-5, MINIMAL_ERROR)]) == (Verdict.REQUIRED, f"position, {BESIDE_OTHERS}")
    assert verdict([harmless, in_full(MINIMAL_ERROR, MINIMAL_ERROR, 1.4)]) == (Verdict.COSTLY, BESIDE_OTHERS)
    # Where a model is wrong with it and without, it tells nothing, and what is known otherwise stays.
    assert verdict([harmless, in_full(1e-5, 1e-5)])[0] is Verdict.FREE
    assert verdict([in_full(1e-5, 1e-5)])[0] is Verdict.UNDECIDED


def test_what_an_engine_cannot_do_is_not_told() -> None:
    refused = replace(variant(Role.ADDED, "it", None), outcome="unsupported", reason="it has no rod")
    found = evidence_of(refused, MINIMAL, LEVEL)
    assert verdict([found]) == (Verdict.UNDECIDED, "it has no rod")
    assert verdict([]) == (Verdict.UNDECIDED, "")


STEP = 10_000  # [ns] that a step of the minimal model takes
MINIMAL_SETTINGS = MuJoCoSettings.stock(SAW, 1000)
WITH_IT = MuJoCoSettings.tuned(SAW, 1000)


@dataclass
class FakeEngine:
    """An engine whose steps cost what a function of the settings and the time says, on a clock of its own."""

    cost: Callable[[Any, float], float]  # (settings, seconds since the start) -> [ns] a step
    now: float = 0.0
    blocks: list[tuple[str, int]] = field(default_factory=list)

    def clock(self) -> int:
        return round(self.now)

    def reference_loop(self) -> Callable[[int], None]:
        raise AssertionError("a pair is timed against each other")

    def stepper(self, machine: object, settings: Any) -> Callable[[int], None]:
        def advance(steps: int) -> None:
            self.blocks.append((settings.preset, steps))
            self.now += steps * self.cost(settings, 1e-9 * self.now)

        return advance


def timed(engine: Any, settings: Any = WITH_IT, other: Any = MINIMAL_SETTINGS, rounds: int = 100) -> PairedTiming:
    return time_pair(engine, SAW, settings, other, rounds=rounds, clock=engine.clock)


def dearer(share: float) -> Callable[[Any, float], float]:
    return lambda settings, now: STEP * (1.0 + share * (settings.preset == "tuned"))


def test_a_pass_is_made_anew_in_every_block_and_never_driven_beyond_its_end() -> None:
    machine, made = catalogue_scene("swinging-four-bar"), list[list[int]]()

    class Counting(FakeEngine):
        def stepper(self, machine: object, settings: Any) -> Callable[[int], None]:
            advance, taken = super().stepper(machine, settings), list[int]()
            made.append(taken)
            self.now += 50 * STEP  # to make a machine takes time, which is in no block

            def advanced(steps: int) -> None:
                taken.append(steps)
                advance(steps)

            return advanced

    engine: Any = Counting(dearer(0.5))
    twice = replace(WITH_IT, steps_per_revolution=2000)
    found = time_pair(engine, machine, twice, MINIMAL_SETTINGS, rounds=10, clock=engine.clock)
    assert found.ratio == pytest.approx(3.0, rel=0.01)  # of a revolution, with twice as many steps
    assert found.other_seconds == pytest.approx(1000 * 1e-9 * STEP, rel=1e-4)
    assert {sum(taken) for taken in made} == {194, 388}
    # Negative control: what turns goes on and on, in the same two machines.
    made.clear()
    time_pair(engine, SAW, WITH_IT, MINIMAL_SETTINGS, rounds=10, clock=engine.clock)
    assert len(made) == 2
    assert min(sum(taken) for taken in made) > 1000


def test_the_ratio_is_that_of_the_costs() -> None:
    found = timed(FakeEngine(dearer(0.5)))
    assert found.ratio == pytest.approx(1.5, rel=1e-4)
    assert found.low == pytest.approx(1.5, rel=1e-4)
    assert found.seconds == pytest.approx(1.5 * found.other_seconds, rel=1e-4)
    assert found.other_seconds == pytest.approx(1000 * 1e-9 * STEP, rel=1e-4)
    assert found.inverse.ratio == pytest.approx(1.0 / 1.5, rel=1e-4)
    assert found.rounds == 100


def test_a_machine_that_slows_down_meanwhile_does_not_change_the_ratio() -> None:
    def slower_and_slower(settings: Any, now: float) -> float:
        return dearer(0.2)(settings, now) * (1.0 + 2.0 * now)

    engine = FakeEngine(slower_and_slower)
    found = timed(engine)
    assert engine.now > 0.3e9  # by two thirds at its end
    assert found.ratio == pytest.approx(1.2, rel=0.01)
    # Negative control: one after the other the same machine would give a ratio far off.
    alone = FakeEngine(slower_and_slower)
    one, two = alone.stepper(SAW, WITH_IT), alone.stepper(SAW, MINIMAL_SETTINGS)
    spent = []
    for stepper in (one, two):
        begin = alone.now
        stepper(1)
        for _ in range(10_000):
            stepper(1)
        spent.append(alone.now - begin)
    assert spent[0] / spent[1] < 1.0


def judged(share: float) -> Verdict:
    """The verdict on an ingredient that costs a share of time and does nothing else."""
    found = timed(FakeEngine(dearer(share)))
    added = replace(variant(Role.ADDED, "sleep", MINIMAL_ERROR), cost=found)
    return verdict([evidence_of(added, MINIMAL, levels(MINIMAL))])[0]


def test_a_planted_sleep_is_costly() -> None:
    assert judged(0.25) is Verdict.COSTLY
    # Negative controls: nothing is free, and so is what no clock could tell from nothing.
    assert judged(0.0) is Verdict.FREE
    assert judged(0.02) is Verdict.FREE
    assert not costs_time(None)
