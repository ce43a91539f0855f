"""Document 001, chapters 1 to 5: what its worked examples print, and the computation of each.

Lengths in m, speeds in m/s, angular ones in rad/s. "From the print" is a computation from rounded printed values.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations

from audits.judging import Case, Explanation, Item

CaseOf = Callable[[Item], Case]

RPM = 2.0 * math.pi / 60.0
FAST = 1000.0 * RPM  # the crank of Examples 4.10 and 5.6
# Example 4.10: distances from instant centres, as the example uses them (its list names them otherwise).
O12_A, O13_A, O13_B, O12_O25, O15_B, O15_C, O15_O25 = 0.14, 0.67, 0.58, 0.49, 0.20, 0.06, 0.81
V_A = FAST * O12_A
V_B = V_A / O13_A * O13_B
V_C = V_B / O15_B * O15_C
V_O25 = FAST * O12_O25


def plain(exact: float, why: str) -> CaseOf:
    """A number with its computation alone."""
    return lambda item: Case(item, exact, why)


def chained(exact: float, why: str, printed: str, value: float) -> CaseOf:
    """A number that the document computes from rounded printed ones."""
    return lambda item: Case(item, exact, why, roundings=(Explanation(printed, value),))


def caused(exact: float, why: str, cause: str, value: float) -> CaseOf:
    """A number that a systematic cause moves."""
    return lambda item: Case(item, exact, why, causes=(Explanation(cause, value),))


def slipped(exact: float, why: str, slip: str, value: float, within: float = 0.0, reading: float = 0.0) -> CaseOf:
    """A number that a wrong step gives."""
    return lambda item: Case(item, exact, why, wrong_steps=(Explanation(slip, value, within),), reading=reading)


def contradicted(exact: float | None, why: str, neighbour: str, value: float, within: float = 0.0) -> CaseOf:
    """A number that another printed one fixes."""
    return lambda item: Case(item, exact, why, neighbours=(Explanation(neighbour, value, within),))


def read_only(why: str) -> CaseOf:
    """A number read from a lost drawing, that nothing printed determines."""
    return lambda item: Case(item, None, why)


def gruebler(links: int, lower_pairs: int, higher_pairs: int = 0) -> int:
    """Degrees of freedom of a planar mechanism."""
    return 3 * (links - 1) - 2 * lower_pairs - higher_pairs


FOUR_BAR_PAIRS = sum(1 for _ in combinations(range(4), 2))
LOST = "read from a polygon whose drawing is lost; the printed lengths allow any closed triangle, and this one closes"

CASES: dict[str, CaseOf] = {
    "mobility": plain(gruebler(4, 4), "3 (n - 1) - 2 j"),
    "arrow": plain(120.0 / 30.0, "the speed over the scale"),
    "walker": plain(60.0 - 20.0, "60 - 20"),
    "centres": plain(FOUR_BAR_PAIRS, "pairs of four links"),
    "centres-left": plain(FOUR_BAR_PAIRS - 4, "pairs of four links, less four pins"),
    "4.10-w2": plain(FAST, "1000 x 2 pi/60"),
    "4.10-vb-first": slipped(
        V_B,
        "B is no point of link 2: omega 3 x O13B, 12,69 m/s as the example itself has it (line 754); line 744 goes on "
        "with V_A = 104,72 x 0,14 = 14,66 m/s, which is perhaps what is meant here",
        "omega 2 times 0,67 m, which is O13A,",
        FAST * O13_A,
    ),
    "4.10-va": plain(V_A, "omega 2 x O12A"),
    "4.10-w3": plain(V_A / O13_A, "V_A/O13A"),
    "4.10-vb": plain(V_B, "omega 3 x O13B"),
    "4.10-w5": chained(V_B / O15_B, "V_B/O15B", "12,69/0,2 from the print", 12.69 / 0.2),
    "4.10-arm": contradicted(
        O15_C,
        "O15C of the example's list",
        "V_C = 3,8 over omega 5 = 63,45",
        3.8 / 63.45,
        0.05 / 63.45,
    ),
    "4.10-vc": plain(V_C, "omega 5 x O15C"),
    "4.10-vo": plain(V_O25, "omega 2 x O12O25"),
    "4.10-w5-second": chained(V_O25 / O15_O25, "V_O25/O15O25", "51,31/0,81 from the print", 51.31 / 0.81),
    "4.10-vc-second": plain(V_O25 / O15_O25 * O15_C, "omega 5 x O15C"),
    "5.1-va": plain(30.0 * 0.3, "omega 2 x O12A"),
    "5.1-drawn": plain(9.0 / 2.0, "V_A over the scale"),
    "5.6-w2": contradicted(
        FAST,
        f"1000 x 2 pi/60; with {60.0 / RPM:.0f} rpm in the task 60 rad/s and all that follows from it stand",
        "1000 rpm of the task (line 887)",
        FAST,
    ),
    "5.6-va": slipped(FAST * 0.11, "omega 2 x O12A at 1000 rpm", "60 rad/s in place of 1000 rpm", 60.0 * 0.11),
    "5.6-read": read_only(LOST),
    "5.6-w3": plain(6.4 / 0.21, "V_B/A over AB"),
    "5.6-w4": slipped(5.8 / 0.145, "V_B over O14B", "omega 3 = 6,4/0,21 in its place", 6.4 / 0.21),
}
