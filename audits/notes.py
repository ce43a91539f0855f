"""Doubts about the verdicts on the four documents."""

from __future__ import annotations

from collections.abc import Mapping

SCAN = (
    "The text was read from a scan by a machine. A misprint of a formula or of a single digit may be an error of that "
    "reading: look at the paper before correcting it."
)
DOTS = (
    "Dots over letters, for derivatives by time, are lost in the scan's text: where a formula fails for want of a dot "
    "alone, the paper may have it."
)
NOTES: Mapping[str, tuple[str, ...]] = {
    "000": (
        SCAN,
        DOTS.replace("are lost", "are lost or misplaced here and there"),
        "That the factors 1/18 and 1/324 of the velocity and the acceleration were whole, not cut short, cannot be "
        "told from the table; the cause named for the explained cells is the set of constants that reproduces every "
        "cell but two, not a listing that was seen.",
    ),
    "001": (
        SCAN,
        "The drawings are lost. A number that was measured from one is judged only as far as printed lengths and "
        "speeds fix it.",
        "Example 6.15 is partly circular: two angles of its pose, those of O12-A and O15-C, were fitted to the "
        "velocities that are printed. Where such a number agrees, that says little; where it does not, the reason "
        "is that no pose at all gives the printed polygon, and no value is named as the right one.",
        "In Examples 4.10, 5.6 and 6.18 the links' directions follow from the printed speeds themselves, which are "
        "therefore not tested by them.",
    ),
    "002": (
        SCAN,
        DOTS,
        "The figures are lost. What a curve in them shows cannot be held against the listing.",
    ),
    "004": (
        SCAN,
        "The cause named for the jerk of -89,616 is only probable: the series of rho = 88 mm at the joint angle of "
        "rho = 118 mm gives these digits, and of the document's other radii and angles no pair does, but one "
        "value of five digits can be met by chance.",
        "The figures and tables are lost: only the numbers that the text quotes are judged.",
    ),
}
