"""Printed values of a user's own: judged by the same rules, and refused in one line where they cannot be read."""

from __future__ import annotations

import math
from typing import Any

import pytest

from conrod.errors import InvalidInput
from conrod.own.printed.judging import Case, Explanation, Item, Kind, Number, judge
from conrod.own.printed.table import audit_table
from conrod.scenes import ShearPress, scene_named

HEADING = "scene,quantity,angle_deg,printed,unit\n"
PRESS = ShearPress()


def number_of(text: str) -> Item:
    return Item("test", "key", "here", 1, "length", "", Number(text), "mm", "")


def speeds(turn: float = math.pi / 180.0, factor: float = 1e3) -> list[str]:
    """Printed velocities of A every ten degrees, mm/s with two digits."""
    angles = range(10, 180, 10)
    return [f"{PRESS.motion([k * turn], PRESS.speed).point('A').velocity[0, 1] * factor:.2f}" for k in angles]


def table(printed: list[str]) -> str:
    rows = (f"shear-press,A velocity y,{10 * k},{text},mm/s" for k, text in enumerate(printed, start=1))
    return HEADING + "\n".join(rows)


def test_a_short_pi_is_named_where_it_reproduces_the_column() -> None:
    verdicts = audit_table("mine", table(speeds(3.14 / 180.0)))
    assert Kind.EXPLAINED in {v.kind for v in verdicts} <= {Kind.EXPLAINED, Kind.AGREES}
    assert all("3.14 " in v.reason for v in verdicts if v.kind is Kind.EXPLAINED)


def test_a_wrong_unit_is_a_wrong_step_with_the_right_value() -> None:
    verdict = audit_table("mine", table(speeds(factor=1.0)))[8]
    assert (verdict.kind, verdict.should_be) == (Kind.WRONG_STEP, "-186.88")


def test_a_single_wrong_value_among_right_ones_is_given_no_cause() -> None:
    printed = speeds()
    printed[3] = speeds(3.14 / 180.0)[3]
    assert printed[3] != speeds()[3]
    verdict = audit_table("mine", table(printed))[3]
    assert (verdict.kind, verdict.should_be) == (Kind.NOT_REPRODUCIBLE, speeds()[3])


def test_a_machine_of_one_pass_is_audited_where_it_goes_and_its_slips_do_not_lead_out() -> None:
    scene = scene_named("swinging-four-bar")
    angles = range(-10, 60, 10)
    values = scene.motion([math.radians(k) for k in angles], scene.speed).point("B").velocity[:, 0]
    rows = [
        f"swinging-four-bar,B velocity x,{k},{value / 10.0:.3f},m/s" for k, value in zip(angles, values, strict=True)
    ]
    found = audit_table("mine", HEADING + "\n".join(rows))
    assert Kind.WRONG_STEP in {v.kind for v in found}
    assert all("a unit 10 times as large" in v.reason for v in found if v.kind is Kind.WRONG_STEP)


def test_parameters_of_a_row_are_used() -> None:
    text = HEADING.replace("unit\n", "unit,parameters\n") + "saw-40rpm,C position x,180,-250,mm,crank=125mm; offset=0\n"
    assert audit_table("mine", text)[0].kind is Kind.AGREES
    assert audit_table("mine", text.replace("125", "124"))[0].kind is not Kind.AGREES


GOOD = "shear-press,G velocity y,10,-33.3,mm/s"


@pytest.mark.parametrize(("text", "message"), [
    (HEADING + GOOD.replace("G velocity", "H velocity"), "unknown point 'H': choose from A, G"),
    (HEADING + GOOD.replace("-33.3", "1e3"), "is not a decimal number"),
    (HEADING + GOOD.replace("mm/s", "mm"), "'mm' is not a unit of m/s"),
    (HEADING + "shear-press", "row 2: quantity: nothing is given"),
    (HEADING.replace(",unit", ""), "no column 'unit'"),
    (HEADING.replace("unit", "units"), "unknown column 'units': did you mean 'unit'"),
])  # fmt: skip
def test_a_table_or_a_row_that_cannot_be_used_is_named(text: str, message: str) -> None:
    assert audit_table("mine", HEADING + GOOD)[0].kind is Kind.AGREES
    with pytest.raises(InvalidInput, match=message):
        audit_table("mine", text)


def test_fields_apart_by_semicolons_with_decimal_commas_and_a_typeset_minus_are_read() -> None:
    text = HEADING.replace(",", ";") + "shear-press;A velocity y;12,5;\u221244,04;mm/s\n"
    found = audit_table("mine", text)[0]
    exact = PRESS.motion([math.radians(12.5)], PRESS.speed).point("A").velocity[0, 1] * 1e3
    assert (found.exact, found.condition, found.printed) == (pytest.approx(exact), "12.5 deg", "-44,04")


# -- the engine of verdicts ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("exact", "more", "kind"), [
    (2.3541, {}, Kind.AGREES),
    (2.3591, {}, Kind.AFTER_ROUNDING),
    (2.40, {"causes": (Explanation("pi = 3.14", 2.3502),)}, Kind.EXPLAINED),
    (2.85, {"neighbours": (Explanation("beside", 2.85, 0.01),)}, Kind.MISPRINT),
    # A neighbour that contradicts the exact value too proves no misprint.
    (2.85, {"neighbours": (Explanation("beside", 3.85, 0.01),)}, Kind.NOT_REPRODUCIBLE),
    (2.40, {"wrong_steps": (Explanation("5 for 6", 2.3549),)}, Kind.WRONG_STEP),
    (2.40, {"reading": 0.1}, Kind.AFTER_ROUNDING),
    (2.40, {}, Kind.NOT_REPRODUCIBLE),
])  # fmt: skip
def test_each_kind_of_verdict_is_reached_and_only_by_what_reproduces_the_print(
    exact: float, more: dict[str, Any], kind: Kind
) -> None:
    assert judge(Case(number_of("2.35"), exact, "sum", **more)).kind is kind


def test_a_cause_that_does_not_reproduce_the_print_is_not_named() -> None:
    near_misses = (Explanation("pi = 3.14", 2.3551), Explanation("pi = 22/7", 2.3449))
    verdict = judge(Case(number_of("2.35"), 2.40, "sum", causes=near_misses, wrong_steps=(near_misses[1],)))
    assert verdict.kind is Kind.NOT_REPRODUCIBLE
    assert "pi" not in verdict.reason


@pytest.mark.parametrize(("text", "value", "rounds", "cuts"), [
    ("63,45", 63.457, False, True),
    ("63.46", 63.457, True, False),
    ("-2.3", 2.34, False, False),
    ("520,408", 520.40816, True, True),
])  # fmt: skip
def test_printed_digits_round_and_cut(text: str, value: float, rounds: bool, cuts: bool) -> None:
    assert (Number(text).is_rounding_of(value), Number(text).is_cut_of(value)) == (rounds, cuts)
