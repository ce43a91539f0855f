"""What a sweep finds: fronts of what nothing beats, orders, and where an error has stopped falling."""

from __future__ import annotations

from dataclasses import replace

import pytest
from handmade import handmade_sweep

from conrod.runs.convergence import observed_order

STEPS = (100, 200, 400, 800)


def test_a_front_has_the_completed_and_timed_points_of_an_engine_that_nothing_beats() -> None:
    study = handmade_sweep()
    assert {p.outcome for p in study.points} == {"completed", "opened"}
    for engine in (None, "mujoco", "pymunk"):
        candidates = [p for p in study.points if p.completed and engine in (None, p.engine)]
        costs = {p.label: (p.cost or 0.0, p.error("velocity") or 0.0) for p in candidates}
        front = study.front("velocity", engine)
        assert front
        for point in candidates:
            cost, error = costs[point.label]
            beaten = any(c <= cost and e < error for c, e in costs.values())
            assert (point in front) is not beaten
        assert [p.cost for p in front] == sorted(p.cost or 0.0 for p in front)
    best = study.front("position", "pymunk")[-1]
    assert (best.errors or {})["position"] == best.error("position") == 1.6e-6
    untimed = replace(study, points=tuple(replace(p, cost=None) if p is best else p for p in study.points))
    assert best.label not in {p.label for p in untimed.front("position")}
    # Nothing beats what costs nothing, or has no error at all.
    perfect = replace(best, errors=dict.fromkeys(best.errors or {}, 0.0))
    for made in (perfect, replace(best, cost=0.0)):
        others = tuple(made if p is best else p for p in study.points)
        assert made in replace(study, points=others).front("position")


@pytest.mark.parametrize(
    ("errors", "claimed", "plateau"),
    [
        ([64e-4, 16e-4, 4e-4, 1e-4], 2.0, None),
        ([1e-2, 1.02e-4, 1.01e-4, 1e-4], None, 1e-4),
        ([1e-2, 1e-3, 1e-4, 1e-4], None, None),  # still for one pair alone
        ([1e-2, 1e-4, 1e-4, 1e-5], None, None),
        ([1e-4, 1e-4, 2e-4, 4e-4], None, None),  # grows
        ([1e-4, 0.0, 1e-4, 1e-4], None, None),
        ([1e-4, 1e-4, 1e-4], None, 1e-4),
        ([1e-4, 1e-4], None, None),
        ([1e-2, 1e-4, 1e-4 * 2.0**0.099, 1e-4], None, 1e-4),  # up to a tenth of an order
    ],
)
def test_an_error_whose_last_two_pairs_have_no_order_is_a_plateau(
    errors: list[float], claimed: float | None, plateau: float | None
) -> None:
    found = observed_order(STEPS[: len(errors)], errors)
    assert found.claimed == (None if claimed is None else pytest.approx(claimed))
    assert found.plateau == plateau
