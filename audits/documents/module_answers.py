"""Answers that document 001 asks for and does not print: those that its printed lengths and speeds give."""

from __future__ import annotations

import math
from dataclasses import dataclass

from audits.documents.module_claims import second_auxiliary
from audits.documents.module_linkages import RackLinkage
from audits.documents.module_velocities import gruebler
from audits.pin_instant import size

SLIDER = (
    "a slider does not turn. The drawing is lost; six links and seven joints with these instant centres make a machine "
    "of one degree of freedom if link 4 is the slider at B, as in the catalogue's two-slider-linkage; nothing printed "
    "shows it"
)


@dataclass(frozen=True)
class Answer:
    """A number that a reader of the document misses, with its computation; `line` is where it is asked for."""

    place: str
    line: int
    quantity: str
    value: float
    unit: str
    why: str


def answers() -> tuple[Answer, ...]:
    """All that the print determines; omega 4 of Example 4.10 and BY4 also take an assumption, which is stated."""
    across_c, across_rod = RackLinkage().tangential(6.0**2 / 0.3)
    normal_c = 6.9**2 / 0.13
    return (
        Answer("section 3.6", 488, "instant centres of a six-bar", math.comb(6, 2), "", "pairs of six links"),
        Answer("Example 4.10", 706, "degrees of freedom", gruebler(6, 7), "", "n = 6, j = 7"),
        Answer("Example 4.10", 707, "omega 4", 0.0, "rad/s", SLIDER),
        Answer("Example 6.15", 1179, "degrees of freedom", gruebler(6, 7), "", "n = 6, j = 7"),
        Answer("Example 6.15", 1272, "omega 4", 9.4 / 0.45, "rad/s", "V_D/C over CD, as the line sets it out"),
        Answer(
            "Figure 6.16",
            1370,
            "BY4",
            size(second_auxiliary()),
            "m",
            "O15C and AB meet there; by the catalogue's fitted pose of O15C, which the print does not fix",
        ),
        Answer("Example 6.18", 1428, "degrees of freedom", gruebler(5, 5, 1), "", "n = 5, j = 5, h = 1"),
        Answer("Example 6.18", 1429, "omega 2", 6.9 / 0.13, "rad/s", "V_C over O12C"),
        Answer("Example 6.18", 1429, "alpha 3", across_rod / 0.25, "rad/s^2", "A_B/C over BC, with A_B = 120 m/s^2"),
        Answer("Example 6.18", 1430, "A_C", math.hypot(normal_c, across_c), "m/s^2", "its normal and tangential parts"),
    )
