"""`conrod lint` finds what was planted, by what it does: no name in the models says anything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from four_bars import four_bar
from planted_models import CLOSURE, MJCF, PLANTED, SAW, renamed, replaced

from conrod.mjcf.lint.findings import Report, Request
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


@pytest.mark.parametrize("off", [0.0, 1e-4])
def test_a_loop_twice_is_redundant_and_a_pin_across_a_tilted_plane_is_not(off: float, look: Look) -> None:
    twice = four_bar().replace('pos="0.3 0 0"/>', f'pos="0.3 0 0"/><site name="D" pos="{0.3 + off} 0 0"/>')
    twice = twice.replace("</equality>", '<connect name="again" site1="B" site2="D"/></equality>')
    # Also where both contradict each other by a tenth of a millimetre.
    (found,) = (one for one in look(twice).findings if one.rule == "redundant-closure")
    assert (found.subjects, found.evidence["redundant"]) == (("again",), 2)
    # Negative control: the one pin has three rows, of which the plane leaves two.
    assert "redundant-closure" not in rules_of(look(four_bar()))


def test_every_rule_that_makes_findings_has_something_planted() -> None:
    found = set().union(*(plant.expected for plant in PLANTED.values()))
    assert set(RULES) == found


SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in ("shear-press", "saw-40rpm", "cam-follower")]


@pytest.mark.parametrize("name", ["saw-500rpm", *SLOW])
def test_conrods_own_models_have_no_finding(name: str) -> None:
    report = lint(MJCF / f"{name}.xml", Request())
    assert report.findings == ()


def test_the_clean_model_with_random_names_has_no_finding(look: Look) -> None:
    assert look(renamed(SAW)).findings == ()


def test_evidence_is_the_same_in_every_run(look: Look) -> None:
    text = renamed(replaced('tolerance="0"', 'jacobian="sparse"')(SAW))
    assert look(text) == look(text)


def test_a_model_whose_step_is_too_long_is_judged_with_one_that_is_not(look: Look) -> None:
    text = replaced('timestep="0.00012"', 'timestep="0.05"')(replaced('autoreset="disable" ', "")(SAW))
    report = look(text, Request(seconds=10.0))
    assert rules_of(report) == {"step-too-long", "silent-reset"}
    evidence = next(finding.evidence for finding in report.findings if finding.rule == "step-too-long")
    assert evidence["step [s]"] == 0.05
    # RK4 follows a crank with four to five steps a turn, of 0.12 s.
    assert evidence["longest stable step [s]"] == 0.025
    assert report.notes == ("all other rules are judged with a step of 0.0125 s",)


def test_the_worst_findings_come_first_and_a_rule_can_be_left_out(look: Look) -> None:
    text = replaced('tolerance="0" ', "")(replaced('autoreset="disable" ', "")(SAW))
    assert [finding.rule for finding in look(text).findings] == ["solver-stops-early", "silent-reset"]
    assert rules_of(look(text, replace(SHORT, ignored=("silent-reset",)))) == {"solver-stops-early"}


def test_a_soft_closure_is_found_where_the_step_alone_opens_a_stiff_one(look: Look) -> None:
    text = replaced('timestep="0.00012" integrator="RK4"', 'timestep="0.004" integrator="Euler"')(SAW)
    request = Request(seconds=0.12, ignored=("step-too-long",))
    (finding,) = look(replaced(f" {CLOSURE}", "")(text), request).findings
    assert finding.evidence["with a step of [s]"] < 0.004
    assert finding.evidence["opening when stiff [m]"] <= 0.1 * finding.evidence["opening [m]"]
    # Negative control: what opens by the step and not by its softness is none.
    assert look(text, request).findings == ()
