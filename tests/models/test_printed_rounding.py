"""A print is reproducible where the exact value at an angle within its rounding rounds to it, and nowhere else."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from conrod import InvalidInput
from conrod.models.printed.table import audit_file, audit_table
from conrod.models.printed.verdicts import VerdictKind
from conrod.scenes import Saw, ShearPress

CASES = Path(__file__).parents[1] / "data" / "cases"
HEADING = "scene,quantity,angle_deg,printed,unit\n"
PRESS, SAW = ShearPress(), Saw(speed=4.0)


def printed(degrees: float, decimals: int = 2) -> str:
    """The velocity of A at a crank angle [mm/s]."""
    return f"{PRESS.motion([math.radians(degrees)], PRESS.speed).point('A').velocity[0, 1] * 1e3:.{decimals}f}"


def kinds(*rows: tuple[str, str]) -> list[VerdictKind]:
    text = "".join(f"shear-press,A velocity y,{angle},{value},mm/s\n" for angle, value in rows)
    return [verdict.kind for verdict in audit_table("mine", HEADING + text)]


def test_printed_zero_is_reproducible_at_the_rounded_angle() -> None:
    verdicts = audit_file(CASES / "piston-printed.csv").verdicts
    assert [v.kind for v in verdicts] == [VerdictKind.AGREES] * 3 + [VerdictKind.AFTER_ROUNDING] + [
        VerdictKind.NOT_REPRODUCIBLE
    ] * 2
    assert "at 75.62352 deg, which is printed as 75.6 deg" in verdicts[3].reason
    assert verdicts[3].should_be is None
    assert "cut off" not in verdicts[3].reason


@pytest.mark.parametrize(
    ("angle", "exact", "kind"),
    [
        ("33.3", 33.3, VerdictKind.AGREES),
        ("33.3", 33.348, VerdictKind.AFTER_ROUNDING),
        ("33.3", 33.252, VerdictKind.AFTER_ROUNDING),
        ("33,3", 33.348, VerdictKind.AFTER_ROUNDING),
        ("\u221233.3", -33.252, VerdictKind.AFTER_ROUNDING),
        ("33.3", 33.42, VerdictKind.NOT_REPRODUCIBLE),
        ("33.30", 33.348, VerdictKind.NOT_REPRODUCIBLE),
        ("33.31", 33.313, VerdictKind.AFTER_ROUNDING),
        ("33", 33.4, VerdictKind.AFTER_ROUNDING),
        ("33", 33.7, VerdictKind.NOT_REPRODUCIBLE),
        # Round angles are chosen.
        ("30", 30.3, VerdictKind.NOT_REPRODUCIBLE),
        ("35", 35.3, VerdictKind.NOT_REPRODUCIBLE),
        ("33.0", 33.04, VerdictKind.NOT_REPRODUCIBLE),
        ("0", 0.3, VerdictKind.NOT_REPRODUCIBLE),
    ],
)
def test_printed_value_agrees_at_an_angle_within_its_rounding(angle: str, exact: float, kind: VerdictKind) -> None:
    angle = f'"{angle}"' if "," in angle else angle
    assert kinds((angle, printed(exact))) == [kind]


def test_angles_at_equal_distances_are_chosen_and_not_rounded() -> None:
    rows = [(str(k), printed(k)) for k in range(31, 35)]
    rows[1] = ("32", printed(32.4))
    assert kinds(*rows)[1] is VerdictKind.NOT_REPRODUCIBLE
    assert kinds(*rows[:2], ("37", printed(37)))[1] is VerdictKind.AFTER_ROUNDING


def test_times_stand_for_angles_with_their_own_rounding() -> None:
    def at(time: float, given: str) -> VerdictKind:
        value = SAW.motion([SAW.speed * time], SAW.speed).point("C").position[0, 0] * 1e3
        text = f"saw-40rpm,C position x,{given},{value:.3f},mm,speed=4 rad/s\n"
        return audit_table("mine", "scene,quantity,time_s,printed,unit,parameters\n" + text)[0].kind

    assert at(0.123, "0.123") is VerdictKind.AGREES
    assert at(0.1233, "0.123") is VerdictKind.AFTER_ROUNDING
    assert at(0.1238, "0.123") is VerdictKind.NOT_REPRODUCIBLE
    assert at(0.1203, "0.120") is VerdictKind.NOT_REPRODUCIBLE
    both = "scene,quantity,angle_deg,time_s,printed,unit\n"
    found = audit_table("mine", both + f"shear-press,A velocity y,,0.1,{printed(math.degrees(0.1 * PRESS.speed))},mm/s")
    assert (found[0].kind, found[0].condition) == (VerdictKind.AGREES, "0.1 s")
    with pytest.raises(InvalidInput, match="row 2: angle_deg and time_s are both given"):
        audit_table("mine", both + "shear-press,A velocity y,10,0.1,1,mm/s")
    with pytest.raises(InvalidInput, match="row 2: angle_deg: nothing is given"):
        audit_table("mine", both + "shear-press,A velocity y,,,1,mm/s")
