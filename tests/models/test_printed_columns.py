"""A column of printed values that is wrong as a whole has its slip named, where one alone reproduces it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.models.printed.report import cause_lines
from conrod.models.printed.table import audit_table
from conrod.models.printed.verdicts import AuditedDocument, PrintedVerdict, VerdictKind
from conrod.scenes import ShearPress

HEADING = "scene,quantity,angle_deg,printed,unit\n"
PRESS = ShearPress()
TENS = tuple(range(10, 190, 10))
UNEVEN = (11.3, 23.4, 31.7, 52.6, 68.9, 83.2, 97.1, 121.4)
NEXT, PREVIOUS = "a slip by a row (the next row's values)", "a slip by a row (the previous row's values)"
SPEED = "another speed (6.325 rad/s in place of 5.75 rad/s)"


def column(
    quantity: str,
    *,
    speed: float = 1.0,
    factor: float = 1.0,
    turned: float = 0.0,
    at: Sequence[float] = TENS,
    decimals: int = 2,
) -> list[str]:
    """Printed values of G in mm and s, at angles turned on [deg], at a multiple of the speed, times a factor."""
    derivative, axis = quantity.split()
    motion = PRESS.motion([math.radians(angle + turned) for angle in at], speed * PRESS.speed)
    values = getattr(motion.point("G"), derivative)[:, "xy".index(axis)] * 1e3 * factor
    return [f"{value:.{decimals}f}" for value in values]


def audit(columns: dict[str, list[str]], at: Sequence[float] = TENS) -> tuple[PrintedVerdict, ...]:
    units = {"position": "mm", "velocity": "mm/s", "acceleration": "mm/s^2"}
    rows = (
        f"shear-press,G {quantity},{angle},{value},{units[quantity.split()[0]]}\n"
        for quantity, values in columns.items()
        for angle, value in zip(at, values, strict=True)
    )
    return audit_table("mine", HEADING + "".join(rows))


def causes(verdicts: Sequence[PrintedVerdict]) -> set[str]:
    return {v.cause for v in verdicts if v.cause}


def unexplained(verdicts: Sequence[PrintedVerdict]) -> list[int]:
    return [v.line for v in verdicts if v.kind is VerdictKind.NOT_REPRODUCIBLE]


@pytest.mark.parametrize(("turned", "cause"), [(10.0, NEXT), (-10.0, PREVIOUS)])
def test_slip_by_a_row_is_named_with_the_rows_left_over(turned: float, cause: str) -> None:
    verdicts = audit({"velocity x": column("velocity x", turned=turned)})
    assert (causes(verdicts), unexplained(verdicts)) == ({cause}, [])
    # With a wrong digit besides, both are named.
    slipped = column("velocity x", turned=turned)
    slipped[4] = "99.99"
    verdicts = audit({"velocity x": slipped})
    assert (causes(verdicts), unexplained(verdicts)) == ({cause}, [6])
    assert f"left over by {cause}, which gives" in verdicts[4].reason
    assert "left over: line 6" in "".join(cause_lines(AuditedDocument("mine", "Mine", verdicts)))


def test_slip_at_rounded_angles_leaves_the_end_without_a_row() -> None:
    right = column("velocity y", at=UNEVEN)
    verdicts = audit({"velocity y": [*right[1:], "1.23"]}, UNEVEN)
    assert (causes(verdicts), unexplained(verdicts)) == ({NEXT}, [9])
    assert "has none for it" in verdicts[-1].reason
    assert not causes(audit({"velocity y": right}, UNEVEN))


def test_swapped_components_are_named_in_both_columns() -> None:
    x, y = column("velocity x"), column("velocity y")
    verdicts = audit({"velocity x": y, "velocity y": x})
    assert causes(verdicts) == {"a swap of components (y for x)", "a swap of components (x for y)"}
    assert not unexplained(verdicts)


def test_speed_that_fits_is_told_where_orders_tell_it_apart() -> None:
    quantities = ("velocity x", "acceleration x", "acceleration y")
    fast = {quantity: column(quantity, speed=1.1) for quantity in quantities}
    verdicts = audit({**fast, "position x": column("position x")})
    assert (causes(verdicts), unexplained(verdicts)) == ({SPEED}, [])
    # Velocities alone leave it open, and accelerations that are right rule the speed out.
    velocities = {"velocity x": fast["velocity x"]}
    assert causes(audit(velocities)) == {f"a constant factor of 1.1, or {SPEED}"}
    assert causes(audit({**velocities, "acceleration x": column("acceleration x")})) == {"a constant factor of 1.1"}
    confused = {quantity: column(quantity, speed=30.0 / math.pi) for quantity in quantities}
    assert causes(audit(confused)) == {"another speed (rpm taken for rad/s)"}


@pytest.mark.parametrize(
    ("factor", "cause"),
    [
        (1.03, "a constant factor of 1.03"),
        (1.0 / 25.4, "a factor of 0.03937 (inches in place of mm)"),
        (math.pi / 180.0, "a factor of 0.01745 (rad in place of deg)"),
    ],
)
def test_constant_factor_is_named_by_size_and_unit(factor: float, cause: str) -> None:
    verdicts = audit({"position x": column("position x", factor=factor, decimals=4)})
    assert (causes(verdicts), unexplained(verdicts)) == ({cause}, [])


def test_one_wrong_digit_names_no_slip_and_a_right_table_nothing() -> None:
    right = {quantity: column(quantity) for quantity in ("position x", "velocity x", "velocity y", "acceleration x")}
    assert {v.kind for v in audit(right)} == {VerdictKind.AGREES}
    right["velocity x"][3] = "99.99"
    verdicts = audit(right)
    assert (causes(verdicts), unexplained(verdicts)) == (set(), [2 + len(TENS) + 3])


def test_wrong_columns_without_one_cause_stay_unexplained() -> None:
    for wrong in (
        column("velocity x", turned=20.0),  # two rows
        [f"{float(text) * (1.0 + 0.01 * k):.2f}" for k, text in enumerate(column("velocity y"), start=1)],
    ):
        verdicts = audit({"velocity x": wrong})
        assert not causes(verdicts)
        assert len(unexplained(verdicts)) >= len(TENS) - 1


def test_slips_that_explain_a_column_equally_are_not_named() -> None:
    # Angles at which each velocity is half the one before: the next row's values are those of a factor of 0.5 as well.
    fine = np.linspace(10.0, 90.0, 1001)
    falling = PRESS.motion(np.radians(fine), PRESS.speed).point("G").velocity[:, 0]
    angles = [round(float(np.interp(-0.1 * 0.5**k, -falling, fine)), 4) for k in range(6)]
    halves = column("velocity x", at=angles)
    verdicts = audit(
        {"velocity x": [*halves[1:], "9.99"], "acceleration x": column("acceleration x", at=angles)}, angles
    )
    assert not causes(verdicts)
    assert "reproduced equally by" in verdicts[0].reason
    assert "a slip by a row" in verdicts[0].reason
    assert "a constant factor of 0.5" in verdicts[0].reason


def test_span_is_checked_before_any_cause_is_looked_for() -> None:
    rows = "".join(f"swinging-four-bar,B velocity {axis},170,1.0,m/s\n" for axis in "xy")
    with pytest.raises(InvalidInput, match="row 2: angle_deg = 170: swinging-four-bar is driven from"):
        audit_table("mine", HEADING + rows)
