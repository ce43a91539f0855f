"""`conrod lint` finds what was planted, by what it does: no name in the models says anything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from planted_models import (
    CLOSURE,
    MJCF,
    PLANTED,
    SAW,
    closed_twice,
    colliding_but_apart,
    floating_rod,
    renamed,
    replaced,
)

from conrod.mjcf.lint.findings import Harm, Report, Request
from conrod.mjcf.lint.linting import RULES, lint

SHORT = Request(seconds=0.03)  # a quarter of a turn of the saw's crank
Look = Callable[..., Report]


@pytest.fixture
def look(tmp_path: Path) -> Look:
    def at(text: str, request: Request = SHORT) -> Report:
        path = tmp_path / "model.xml"
        path.write_text(text, encoding="utf-8")
        return lint(path, request)

    return at


def rules_of(report: Report) -> set[str]:
    return {finding.rule for finding in report.findings}


@pytest.mark.parametrize("planted", PLANTED)
def test_what_is_planted_is_found_and_nothing_else(planted: str, look: Look) -> None:
    plant = PLANTED[planted]
    text = renamed(plant.edit(SAW), seed=len(planted))
    assert rules_of(look(text, Request(seconds=plant.seconds))) == plant.expected


@pytest.mark.parametrize(("constant", "found"), [(0.003, set()), (0.0034, {"soft-closure"})])
def test_a_closure_is_soft_where_it_gives_more_than_a_bearings_play(
    constant: float, found: set[str], look: Look
) -> None:
    """By 0.88 and 1.1 ten-thousandths of the machine's size."""
    assert rules_of(look(replaced(CLOSURE, f'solref="{constant} 1" solimp="0.99 0.99 0.001 0.5 2"')(SAW))) == found


def test_every_rule_that_makes_findings_has_something_planted() -> None:
    found = set().union(*(plant.expected for plant in PLANTED.values()))
    assert {rule.name for rule in RULES} == found


SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in ("shear-press", "saw-40rpm", "cam-follower")]


@pytest.mark.parametrize("name", ["saw-500rpm", *SLOW])
def test_conrods_own_models_have_no_finding(name: str) -> None:
    report = lint(MJCF / f"{name}.xml", Request())
    assert report.findings == ()


def test_the_clean_model_with_random_names_has_no_finding(look: Look) -> None:
    assert look(renamed(SAW)).findings == ()


def test_evidence_is_the_same_in_every_run(look: Look) -> None:
    text = renamed(closed_twice(replaced("tolerance", 'jacobian="sparse" tolerance')(SAW)))
    assert look(text) == look(text)


def test_a_history_without_a_delay_is_none(look: Look) -> None:
    text = replaced('<framepos name="C.position"', '<framepos nsample="20" name="C.position"')(SAW)
    assert look(text).findings == ()


def test_empty_rows_of_a_planar_closure_are_not_redundant(look: Look) -> None:
    assert "redundant-closure" not in rules_of(look(SAW))
    report = look(closed_twice(SAW))
    evidence = dict(report.findings[0].evidence)
    # Two connects have six rows, of which the two across the plane say nothing.
    assert (evidence["constraint rows that say anything"], evidence["rank"], evidence["redundant"]) == (4, 2, 2)


def test_the_count_of_a_floating_rod_is_told(look: Look) -> None:
    evidence = dict(look(floating_rod(SAW)).findings[0].evidence)
    assert (evidence["degrees of freedom"], evidence["rank of the closures"]) == (8, 6)
    assert (evidence["degrees of freedom if it hung there"], evidence["constraint rows if it hung there"]) == (3, 3)


def test_geoms_that_never_met_in_part_of_a_turn_are_no_finding(look: Look) -> None:
    assert look(colliding_but_apart(SAW), Request(seconds=0.05)).findings == ()


@pytest.mark.parametrize("across", [0.0, 1e-6, 0.01, 3.0])
def test_gravity_is_across_the_plane_from_a_hundredth_of_a_degree(across: float, look: Look) -> None:
    report = look(replaced('gravity="0 -9.81 0"', f'gravity="0 -9.81 {-across}"')(SAW))
    assert rules_of(report) == ({"gravity-across"} if across >= 0.01 else set())


def test_a_model_whose_step_is_too_long_is_judged_with_one_that_is_not(look: Look) -> None:
    text = replaced('timestep="0.00012"', 'timestep="0.05"')(closed_twice(SAW))
    report = look(text, Request(seconds=10.0))
    assert rules_of(report) == {"step-too-long", "redundant-closure"}
    (step,) = (finding for finding in report.findings if finding.rule == "step-too-long")
    evidence = dict(step.evidence)
    assert evidence["step [s]"] == 0.05
    # RK4 follows a crank with four to five steps a turn, of 0.12 s.
    assert evidence["longest stable step [s]"] == 0.025


def test_findings_come_by_harm_and_a_rule_can_be_left_out(look: Look) -> None:
    text = closed_twice(replaced('tolerance="0" ', "")(replaced('autoreset="disable" ', "")(SAW)))
    assert [finding.harm for finding in look(text).findings] == [Harm.WRONG, Harm.HIDES, Harm.WASTE]
    assert "silent-reset" not in rules_of(look(text, replace(SHORT, ignored=("silent-reset",))))
