"""Verdicts on ingredients follow from numbers alone: each of the four, and what a wrong threshold would do to them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from ablations import MINIMAL, MINIMAL_ERROR, alone, timing, variant

from conrod.studies.ablate import findings as rules
from conrod.studies.ablate.findings import BESIDE_OTHERS, JUDGED, Evidence, Role, Verdict, evidence_of, levels, verdict

LEVEL = levels(MINIMAL)


def without(error: float | None, cost: float = 1.0) -> Evidence:
    """What a part of the minimal model shows without which it is like this."""
    reduced = variant(Role.REDUCED, "it", error, error or 0.0, 1.0 / cost)
    return evidence_of(reduced, MINIMAL, LEVEL)


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
    ],
)
def test_verdicts_on_one_piece_of_evidence(evidence: Evidence, expected: tuple[Verdict, str]) -> None:
    assert verdict([evidence]) == expected


def test_a_part_without_which_the_motion_is_better_is_harmful() -> None:
    rough = variant(Role.MINIMAL, error=1e-4)
    better = variant(Role.REDUCED, "it", 1e-6, 1e-4)
    found = evidence_of(better, rough, levels(rough))
    assert verdict([found]) == (Verdict.HARMFUL, "position, better without it")
    # What only improves a motion that is as good as was asked for is not required.
    finer = variant(Role.ADDED, "it", 1e-6, 1e-4, 3.0)
    assert verdict([evidence_of(finer, rough, levels(rough))])[0] is Verdict.COSTLY


@pytest.mark.parametrize("quantity", JUDGED)
def test_every_quantity_can_show_harm(quantity: str) -> None:
    errors = dict.fromkeys(JUDGED, MINIMAL_ERROR) | {quantity: 1e-5}
    added = replace(variant(Role.ADDED, "it"), errors=errors)
    found = evidence_of(added, MINIMAL, LEVEL)
    assert verdict([found]) == (Verdict.HARMFUL, quantity)


def test_a_change_below_the_minimal_models_own_error_is_no_change() -> None:
    rough = variant(Role.MINIMAL, error=1e-4)
    added = variant(Role.ADDED, "it", 1.5e-4, 0.9e-4)
    assert verdict([evidence_of(added, rough, levels(rough))])[0] is Verdict.FREE


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


def test_a_level_without_a_least_one_would_call_rounding_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    added = variant(Role.ADDED, "it", 5 * MINIMAL_ERROR, 4 * MINIMAL_ERROR)
    monkeypatch.setattr(rules, "NO_CHANGE", 0.0)
    found = evidence_of(added, MINIMAL, levels(MINIMAL))
    assert verdict([found])[0] is Verdict.HARMFUL


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
