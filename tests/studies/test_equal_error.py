"""Presets at equal error: the fewest steps are found, the order decides, and nothing is tried in vain."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from measured import FAILED, measured

from conrod.engines import engine_named
from conrod.engines.variants import PRESETS
from conrod.report.sweep.equal_error import cheapest, presets_table, winners_lines, winners_table
from conrod.scenes import SCENES
from conrod.studies.frame.case import pursue
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.equal_error import BARS, MOST_STEPS, sweep_presets
from conrod.studies.sweep.findings import SweepStudy
from conrod.studies.sweep.study import SweepPlan, plan_sweep

SAW = SCENES["saw-500rpm"]
STEP_COSTS = {"mujoco": 4e-6, "pymunk": 1e-6}  # [s]
# Of a preset its error at a step of one radian, and its order; None of one whose runs fail.
LAWS: dict[tuple[str, str], tuple[float, float] | None] = {
    ("mujoco", "stock"): None,
    ("mujoco", "tuned"): (0.05, 0.0),
    ("mujoco", "hardened"): (0.1, 4.0),
    ("pymunk", "stock"): (0.1, 1.0),
    ("pymunk", "tuned"): (0.05, 2.0),
}


def of_size(error: float) -> Measurement:
    """A run with this error at every angle."""
    return measured({name: np.tile([0.6 * error, 0.8 * error], (20, 1)) for name in SAW.lengths})


def plan() -> SweepPlan:
    return plan_sweep("saw-500rpm", SAW, [engine_named(name) for name in STEP_COSTS], PRESETS)


def studied(asked: list[int], slow: float = 1.0) -> SweepStudy:
    """The study with errors by their laws, and costs as of steps; how many steps each run took is kept.

    Args:
        slow: by how much the machine is slower while pymunk is timed.
    """

    def run(cases: Any) -> Any:
        found = {}
        for case in cases:
            law, steps = LAWS[case.settings.engine, case.settings.preset], case.settings.steps_per_revolution
            asked.append(steps)
            found[case.key] = FAILED if law is None else of_size(law[0] * (2.0 * math.pi / steps) ** law[1])
        return found

    def time(cases: Any) -> dict[str, Timing]:
        return {case.key: timing(case.settings, slow) for case in cases}

    return pursue([sweep_presets(plan(), time)], run)[0]


def timing(settings: Any, slow: float) -> Timing:
    """Of every second pymunk timing, by a machine that is slower then."""
    steps, cost = settings.steps_per_revolution, STEP_COSTS[settings.engine]
    factor = slow if settings.engine == "pymunk" and steps % 40 else 1.0
    return Timing(factor * cost * steps, factor * cost, float(steps), steps, 3, "a machine")


@pytest.fixture(scope="module")
def study() -> SweepStudy:
    return studied([])


def fewest(law: tuple[float, float], bar: float) -> float:
    """Steps of a revolution at which an error law gives the bar."""
    return 2.0 * math.pi * (law[0] / bar) ** (1.0 / law[1])


@pytest.mark.parametrize("preset", [("mujoco", "hardened"), ("pymunk", "stock"), ("pymunk", "tuned")])
def test_the_fewest_steps_that_keep_a_bar_are_found_to_a_seventh(study: SweepStudy, preset: tuple[str, str]) -> None:
    law = LAWS[preset]
    assert law is not None
    own = [p for p in study.points if (p.engine, p.preset) == preset]
    for bar in BARS:
        within = [p for p in own if (p.error("position") or 0.0) <= bar and p.cost is not None]
        wanted = max(fewest(law, bar), 20.0)
        if wanted > MOST_STEPS:
            assert not within
        else:
            steps = min(p.steps_per_revolution for p in within)
            assert wanted <= steps <= wanted * 8.0 / 7.0 + 4.0


def test_what_cannot_meet_a_bar_is_not_tried_at_many_steps() -> None:
    asked: list[int] = []
    studied(asked)
    assert 40_000 < max(asked) < 60_000  # of pymunk at order 2; at order 1 1e-6 would take it 600000
    assert len(asked) < 80


def test_the_engine_that_wins_is_the_cheapest_within_the_bar(study: SweepStudy) -> None:
    won = [cheapest(study, ("position",), bar) for bar in BARS]
    assert [p and (p.engine, p.preset) for p in won] == [
        ("mujoco", "hardened") if bar < 1e-4 else ("pymunk", "tuned") for bar in BARS
    ]
    assert winners_lines([study]) == [
        f"{bar}: {engine} (saw-500rpm); position alone: {engine} (saw-500rpm)"
        for bar, engine in (("1e-3", "pymunk"), ("1e-6", "MuJoCo"), ("1e-9", "MuJoCo"))
    ]
    # Negative control: with pymunk a hundred times as dear, it wins nothing.
    dear = tuple(replace(p, cost=100.0 * (p.cost or 0.0)) if p.engine == "pymunk" else p for p in study.points)
    assert winners_lines([replace(study, points=dear)])[0].startswith("1e-3: MuJoCo (saw-500rpm);")


def test_another_load_of_the_machine_at_another_minute_does_not_decide(study: SweepStudy) -> None:
    disturbed = studied([], slow=3.0)
    assert disturbed.reference_spread == {"mujoco": 1.0, "pymunk": 3.0}
    costs = {(p.rule, p.cost) for p in study.points if p.engine == "mujoco"}
    assert costs == {(p.rule, p.cost) for p in disturbed.points if p.engine == "mujoco"}
    share = {(q.cost or 1.0) / (p.cost or 1.0) for p, q in zip(study.points, disturbed.points, strict=True)
             if p.engine == "pymunk" and p.cost}  # fmt: skip
    assert max(share) == pytest.approx(min(share))


def test_every_preset_has_its_row_and_what_fails_or_is_refused_says_so(study: SweepStudy) -> None:
    rows = {(row[0], row[1]): dict(zip(presets_table([study]).headings, row, strict=True))
            for row in presets_table([study]).rows}  # fmt: skip
    assert {(p.engine, p.preset) for p in study.points} == {(str(e).lower(), str(p).strip("`")) for e, p in rows}
    assert rows["MuJoCo", "`tuned`"]["order"] == "plateau 0.050, plateau 0.050, plateau 0.050"
    assert rows["pymunk", "`tuned`"]["order"] == "2.0, 2.0, 2.0"
    assert rows["MuJoCo", "`stock`"]["outcome"] == "20 to 20000: exploded"
    assert "no" in {rows["pymunk", "`stock`"]["below 1e-9"]}
    refused = tuple(
        replace(p, outcome="unsupported", reason="mujoco has no such joint") if p.preset == "stock" else p
        for p in study.points
    )
    cells = [str(cell) for row in presets_table([replace(study, points=refused)]).rows for cell in row]
    assert "unsupported: mujoco has no such joint" in cells


def test_tables_name_the_machine_where_there_are_several(study: SweepStudy) -> None:
    assert winners_table([study]).headings[0] == "every error below"
    both = [study, replace(study, name="another")]
    assert {row[0] for row in winners_table(both).rows} == {"saw-500rpm", "another"}
    assert winners_lines(both)[0].startswith("1e-3: pymunk (saw-500rpm and another);")
