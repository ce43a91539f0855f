"""The report on ingredients: what it says, what a folder keeps of it, and that no engine is needed to make it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from ablations import (
    COUNT,
    MINIMAL_ERROR,
    SCENE,
    ablation_study,
    alone,
    engine_study,
    ingredient,
    timing,
    variant,
)

from conrod.cli.ablate import print_ablations
from conrod.report.ablate import tables
from conrod.report.ablate.report import KIND, merged
from conrod.report.kind import Reproduction
from conrod.report.table import text_of
from conrod.report.writer import report_batch
from conrod.studies.ablate.case import COUNTED
from conrod.studies.ablate.findings import MEANINGS, Effect, IngredientResult, Role, Verdict

COMMAND = Reproduction("conrod ablate {scene} --out reports/ablate")


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """The files of a report of two engines."""
    study = ablation_study(engine_study(), engine_study("pymunk", "7.0.0"))
    batch = report_batch(KIND, {SCENE: study}, Path("/nowhere"), COMMAND)
    return {name: str(text) for name, text in batch.files.items()}


def row(page: str, start: str) -> list[str]:
    """The cells of the first line of a table that begins so."""
    line = next(line for line in page.splitlines() if line.startswith(f"| {start}"))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_the_page_has_of_every_ingredient_cost_change_verdict_and_who_needs_it(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    costly = row(page, "sensors")
    assert costly[1:3] == ["1.20 (1.19 .. 1.21)", "1.30 (1.29 .. 1.31)"]
    assert costly[4] == "costly"
    harmful = row(page, "noslip")
    assert harmful[3:] == ["1.0e-6", "**harmful (position)**", "n/a", "wear"]
    required = row(page, "closure")
    assert "part of the minimal model" in required[0]
    assert required[4] == "required (opened)"
    assert required[6] == "drive torque, joint reactions"
    assert row(page, "looks")[4] == "free"
    assert row(page, "looks")[6] == "impact"
    for verdict, meaning in MEANINGS.items():
        assert f"**{verdict.value}**: {meaning}" in page


def test_the_page_begins_with_how_much_faster_the_minimal_model_is(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    assert "The minimal model is **1.80 times** as fast as the full one (1.79 .. 1.81)" in page[:600]
    assert "3.0e-11 in position, 3.0e-11 in velocity and 3.0e-11 in acceleration: they are equal within 1e-9." in page
    assert "Left out of it, as it does harm alone: `noslip`." in page
    assert "1.80 (1.79 .. 1.8" in pages["README.md"]
    # Negative control: a motion that is not equal is not called so.
    found = engine_study()
    changed = {**(found.variants[5].change or {}), "velocity": 2e-9}
    other = replace(found, variants=(*found.variants[:5], replace(found.variants[5], change=changed)))
    assert "equal within" not in tables.speed_up(other)
    assert "2.0e-9 in velocity" in tables.speed_up(other)
    broken = replace(found.variants[5], outcome="opened", reason="a gap", change=None, cost=None)
    assert "did not run to its end: a gap" in tables.speed_up(replace(found, variants=(broken,)))
    assert "no ingredient" in tables.speed_up(replace(found, variants=found.variants[:1]))


def test_the_page_counts_as_gruebler_does_and_names_what_is_redundant_or_missing(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    assert "n = 4 links, j = 4 lower pairs, h = 0 higher pairs: 3 (n - 1) - 2 j - h = 9 - 8 - 0 = 1" in page
    minimal = row(page, "minimal; minimal + ")
    assert minimal[1:] == ["3", "3", "2", "1, as counted", "empty: slider-pin z", "none"]
    open_loop = row(page, "minimal - closure | 3")
    assert open_loop[4:] == ["3, **Gruebler: 1**", "none", "2, of closure"]
    assert row(page, "full - sensors | 3")[5] == "redundant: 2 of slider-pin/again; empty: slider-pin z"
    assert f"at {COUNTED} crank angles" in page
    singular = replace(engine_study(), variants=(variant(Role.FULL, mobility=replace(COUNT, least_rank=1)),))
    assert tables.counts_table(singular, 1).rows[0][3:5] == ("1 .. 2", "1 (2 at some poses), as counted")


def shown(one: IngredientResult, heading: str) -> str:
    """A cell of the only row of a table of ingredients."""
    found = tables.ingredients_table(replace(engine_study(), ingredients=(one,)))
    return text_of(found.rows[0][found.headings.index(heading)])


def test_what_makes_a_right_motion_better_is_reported_though_it_is_not_required() -> None:
    fine = engine_study()
    rough, finer = variant(Role.MINIMAL, error=1e-5), variant(Role.ADDED, "sensors", 1e-7, 1e-5)
    costly = fine.ingredients[1]
    found = replace(fine, variants=(rough, finer))
    assert tables.finer_text(found, costly) == "position 100 times as accurate with it"
    part = replace(costly, minimal=True)
    lacking = replace(fine, variants=(variant(Role.MINIMAL), variant(Role.REDUCED, "sensors", 4e-9, 4e-9)))
    assert tables.finer_text(lacking, part) == "position 4.0 times as accurate with it"
    # Negative controls: below 1e-9 nothing is better, no better is not called so, and what is required is no extra.
    assert tables.finer_text(fine, costly) == ""
    assert tables.finer_text(replace(fine, variants=(rough, replace(finer, errors=rough.errors))), costly) == ""
    assert tables.finer_text(found, replace(costly, verdict=Verdict.REQUIRED)) == ""


def test_torque_and_time_saved_in_words() -> None:
    seen = alone(MINIMAL_ERROR, 0.0, 1.0)
    gravity = ingredient("gravity", (replace(seen, torque_effect=Effect.REQUIRED),), needed_by=("wear",))
    assert shown(gravity, "drive torque") == "required"
    assert shown(gravity, "needed by") == "drive torque, wear"
    damping = ingredient("damping", (replace(seen, torque_effect=Effect.CHANGED, torque_change=0.02),))
    assert shown(damping, "drive torque") == "changes it, by 0.020"
    beside = replace(seen, torque_effect=Effect.CHANGED, torque_change=0.03, full=True)
    both = ingredient("damping", (replace(seen, torque_effect=Effect.NONE), beside))
    assert shown(both, "drive torque") == "changes it, by 0.030 (beside all others)"
    assert shown(ingredient("looks", (replace(seen, torque_effect=Effect.NONE),)), "drive torque") == "no change"
    assert shown(ingredient("looks", (seen,)), "drive torque") == "n/a"
    assert shown(ingredient("looks", (seen,)), "verdict") == "free"
    assert shown(ingredient("one", (replace(seen, cost=timing(0.8)),)), "verdict") == "free; faster with it"
    assert tables.cost_text(timing(140.8, 20.0)) == "140.8 (120.8 .. 160.8)"
    assert tables.cost_text(None) == "n/a"


def test_the_console_has_a_line_for_every_ingredient(capsys: pytest.CaptureFixture[str]) -> None:
    print_ablations([ablation_study(unsupported={"newcomer": "newcomer has no ingredients"})])
    printed = capsys.readouterr().out
    for text in ("saw-500rpm, mujoco", "noslip", "harmful (position)", "required (opened)", "costly", "1.80 times",
                 "newcomer unsupported: newcomer has no ingredients"):  # fmt: skip
        assert text in printed


# -- folders ---------------------------------------------------------------------------------------------------------


def test_one_engine_after_the_other_adds_up_to_both() -> None:
    both = merged(ablation_study(), ablation_study(engine_study("pymunk")))
    assert [found.engine for found in both.engines] == ["mujoco", "pymunk"]
    # Nothing is kept of another machine.
    longer = ablation_study(parameters={"crank": 0.1, "rod": 0.5})
    assert merged(both, longer) == longer
