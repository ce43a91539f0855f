"""Boundaries are found by halving, to two per cent, by runs that depend on nothing but the answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest
from cell_tasks import answer_study
from synthetic import completed_result

from conrod.scenes import scene_named
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.plan import walk_search
from conrod.studies.limits.records import LimitResult
from conrod.studies.limits.results import Boundary, Walk

SETUP = Setup("saw-500rpm", scene_named("saw-500rpm"), "pymunk", "stock")

Rule = Callable[[float], float | str]  # value -> position error, or outcome


def started(setup: Setup, value: float) -> LimitCase:
    """Values go into a parameter of the case that no search looks at, so that answers can be made up for them."""
    return setup.case_with(start_angle=value)


RATIO = Axis("made-up", "made up", "value (1)", Scale.LOG, started, safe_end=1.0, failing_end=1e4)
EVEN = replace(RATIO, nearest=lambda value: 2.0 * max(1, round(value / 2.0)))  # only even numbers exist
WHOLE = replace(RATIO, scale=Scale.COUNT, safe_end=20000.0, failing_end=2.0)


def answer(rule: Rule, value: float, warnings: Mapping[str, int]) -> LimitResult:
    found = rule(value)
    if isinstance(found, str):
        return LimitResult(found, "made up", samples=1, warnings=warnings)
    return completed_result(found, LimitResult, samples=1, warnings=warnings)


def boundaries(axis: Axis, rule: Rule, **warnings: int) -> tuple[dict[str, Boundary], Walk]:
    walk = answer_study(
        walk_search(axis, SETUP, axis.safe_end, axis.failing_end), lambda cell: answer(rule, cell.start_angle, warnings)
    )
    return {boundary.criterion: boundary for boundary in walk.boundaries}, walk


def graded(value: float) -> float | str:
    """Worse and worse: safe to 10, rough to 100, wrong to 500, open to 2000, then not finite."""
    if value > 500.0:
        return "opened" if value <= 2000.0 else "diverged"
    return 1e-3 if value <= 10.0 else 0.05 if value <= 100.0 else 0.2


def test_every_boundary_is_found_to_two_per_cent() -> None:
    every, _ = boundaries(RATIO, graded)
    for criterion, true in (("safe", 10.0), ("rough", 100.0), ("wrong", 500.0), ("broken", 2000.0)):
        found = every[criterion]
        assert found.last_good <= true < found.first_bad <= 1.02 * found.last_good
        assert found.good_again == ()
    assert [every[criterion].outcome for criterion in ("wrong", "broken")] == ["opened", "diverged"]


def test_failure_is_undetected_unless_there_is_a_warning() -> None:
    assert boundaries(RATIO, graded)[0]["wrong"].undetected
    assert not any(probe.undetected for probe in boundaries(RATIO, graded, BADQACC=1)[1].probes)


@pytest.mark.parametrize(
    ("axis", "rule", "ends"),
    [
        (WHOLE, lambda n: 1e-4 if n >= 17 else "diverged", (17.0, 16.0)),
        (EVEN, lambda x: 1e-4 if x <= 31.0 else "opened", (30.0, 32.0)),
    ],
    ids=["whole numbers", "even numbers"],
)
def test_boundary_lies_between_neighbours_when_values_are_sparse(axis: Axis, rule: Rule, ends: object) -> None:
    found = boundaries(axis, rule)[0]["safe"]
    assert (found.last_good, found.first_bad) == ends


def test_what_holds_again_beyond_its_boundary_is_known() -> None:
    found = boundaries(RATIO, lambda x: "opened" if 5.0 < x < 50.0 else 1e-4)[0]["safe"]
    assert 5.0 < found.first_bad <= 5.1
    assert min(found.good_again) >= 50.0
