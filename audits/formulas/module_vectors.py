"""Vector equations of document 001: sums of velocities and accelerations, each held against what it is set equal to.

A term names its kind and its points: "V:B/A" a velocity of B against A, "A:B" a whole acceleration, "n:B/A" the part
of one along the line from A to B, "t:B/A" the part across it. A is turned at constant speed about O2, C about O5.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from audits.formulas.published import Formula, Published, verdict_on
from conrod.models.printed.verdicts import PrintedVerdict, VerdictKind

PIVOTS = {"A": "O2", "C": "O5"}
POINTS = ("A", "B", "C", "D", "X4", "Y4", "O2", "O5")


def arguments() -> dict[str, Any]:
    """Places, velocities and accelerations of the points as complex arrays (40,), of no machine in particular."""
    s = np.linspace(0.1, 6.2, 40)
    given: dict[str, Any] = {}
    for count, point in enumerate(POINTS, start=1):
        given[f"place {point}"] = count + 0.3 * np.exp(1j * (s + count))
        still = point in PIVOTS.values()
        given[f"V {point}"] = 0.0 * s if still else np.exp(1j * count * s) + count
        given[f"A {point}"] = 0.0 * s if still else np.exp(1j * (count + 2.0) * s) - 0.5 * count
    arm = given["place A"] - given["place O2"]
    given["A A"] = -((2.0 + s) ** 2) * arm  # at constant speed there is a normal part alone
    return given


def verdicts() -> Iterator[PrintedVerdict]:
    """One on each equation; how far its sides are apart depends on the vectors that are put in, and is not reported."""
    for formula in FORMULAS:
        verdict = verdict_on(formula, arguments())
        if verdict.kind is VerdictKind.MISPRINT:
            reason = f"as printed its sides differ for vectors of rigid links; with {formula.change} nothing is left"
            verdict = replace(verdict, reason=reason, off=None)
        yield verdict


def term(text: str, given: dict[str, Any]) -> Any:
    """A vector, as a complex array."""
    kind, _, points = text.partition(":")
    point, _, other = points.partition("/")
    if kind in ("V", "A"):
        return given[f"{kind} {point}"] - (given[f"{kind} {other}"] if other else 0.0)
    other = other or PIVOTS[point]
    arm = given[f"place {point}"] - given[f"place {other}"]
    whole = given[f"A {point}"] - given[f"A {other}"]
    along = arm / np.abs(arm)
    normal = (whole * along.conj()).real * along
    return normal if kind == "n" else whole - normal


def _sum(terms: str, given: dict[str, Any]) -> Any:
    return sum(term(text, given) for text in terms.split())


def _equation(left: str, right: str, whole: str) -> Formula:
    """What the right side makes of the vector that the left one is meant to be; both sides as sums of terms."""

    def made(**given: Any) -> Any:
        vector = _sum(right, given) - _sum(left, given) + term(whole, given)
        return np.concatenate([vector.real, vector.imag])

    return made


def _vector(place: str, line: int, text: str, left: str, right: str, mended: str = "", change: str = "") -> Published:
    """An equation for the one vector that its left side is meant to be; `mended` has its terms put right."""
    whole, wanted = (mended.split(" = ") if mended else (left.split(maxsplit=1)[0], right))[:2]
    head = whole.split(maxsplit=1)[0]
    symbol, _, points = head.partition(":")
    name = f"{symbol}_{points}"
    return Published("001", place, line, name, text, _equation(left, right, head), _equation("", head, "V:O2"),
                     f"{name} in the motion of rigid links",
                     _equation(whole, wanted, head) if mended else None, change)  # fmt: skip


FORMULAS = (
    _vector("section 5.2", 809, "V_B = V_A + V_B/A", "V:B", "V:A V:B/A"),
    _vector("(6.2)", 981, "A_B = A_A^n + A_B/A^n + A_B/A^t", "A:B", "n:A n:B/A t:B/A"),
    _vector("(6.8)", 1216, "V_K4 = V_B + V_KB, K read as X4", "V:X4", "V:B V:X4/B"),
    _vector("(6.9a)", 1223, "V_X4 = V_A + V_B/A + V_X4/B", "V:X4", "V:A V:B/A V:X4/B"),
    _vector("section 6.8", 1239, "V_X4 = V_C + V_X4/B", "V:X4", "V:C V:X4/B", "V:X4 = V:C V:X4/C",
            "V_X4 = V_C + V_X4/C"),
    _vector("section 6.8", 1244, "V_C = V_D + V_C/D", "V:C", "V:D V:C/D"),
    _vector("(6.12)", 1298, "A_B = A^n_A/B + A^n_B/A + A^t_B/A", "A:B", "n:A/B n:B/A t:B/A",
            "A:B = n:A n:B/A t:B/A", "A_B = A^n_A + A^n_B/A + A^t_B/A"),
    _vector("(6.14)", 1304, "A_X4 = A^n_A + A^n_B/A + A^t_B/A + A^t_X4/B + A^n_X4/B", "A:X4",
            "n:A n:B/A t:B/A t:X4/B n:X4/B"),
    _vector("(6.15)", 1308, "A_X4 = A_D + A^n_X4/D + A^t_X4/D", "A:X4", "A:D n:X4/D t:X4/D"),
    _vector("section 6.8", 1314, "A_D + A^t_X4/D + A^n_X4/D = A^n_A + A^n_B/A + A^t_B/A + A^t_X4/B + A^n_X4/B",
            "A:D t:X4/D n:X4/D", "n:A n:B/A t:B/A t:X4/B n:X4/B"),
    _vector("(6.16)", 1320, "vector // V_D + A^n_X4/B = A^n_A + A^n_B/A + A^n_X4/B + vector across AB",
            "A:D t:X4/D n:X4/B", "n:A n:B/A n:X4/B t:B/A t:X4/B",
            "A:D t:X4/D n:X4/D = n:A n:B/A n:X4/B t:B/A t:X4/B", "A^n_X4/D on the left"),
    _vector("(6.17)", 1326, "A_X4 = A^n_C + A^t_C + A^n_X4/C + A^t_X4/C", "A:X4", "n:C t:C n:X4/C t:X4/C"),
    _vector("(6.18)", 1333, "A_D = A_C + A^n_D/C + A^t_D/C", "A:D", "A:C n:D/C t:D/C"),
    _vector("(6.19)", 1378, "V_B = V_A + V_B/A", "V:B", "V:A V:B/A"),
    _vector("(6.20)", 1382, "V_Y4 = V_B + V_Y4/B", "V:Y4", "V:B V:Y4/B"),
    _vector("(6.21a)", 1386, "V_Y4 = V_A + V_B/A + V_Y4/B", "V:Y4", "V:A V:B/A V:Y4/B"),
    _vector("(6.22)", 1394, "V_Y4 = V_D + V_Y4/D", "V:Y4", "V:D V:Y4/D"),
    _vector("(6.23)", 1398, "V_D = V_C + V_D/C", "V:D", "V:C V:D/C"),
    _vector("(6.24)", 1406, "A_B = A^n_A + A^n_B/A + (across AB) A^n_B/A", "A:B", "n:A n:B/A n:B/A",
            "A:B = n:A n:B/A t:B/A", "A^t_B/A across AB"),
    _vector("(6.25)", 1410, "A^n_Y4/B = A^n_A + A^n_Y4/B + (across AB) A^n_Y4/B", "n:Y4/B", "n:A n:Y4/B n:Y4/B",
            "A:Y4 = A:B n:Y4/B t:Y4/B", "A_Y4 = A_B + A^n_Y4/B + A^t_Y4/B"),
    _vector("(6.26)", 1414, "A_Y4 = A^n_A + A^n_B/A + (across AB) A^n_B/A + (across AB) A^n_Y4/B + A^n_Y4/B", "A:Y4",
            "n:A n:B/A n:B/A n:Y4/B n:Y4/B", "A:Y4 = n:A n:B/A t:B/A t:Y4/B n:Y4/B", "A^t_B/A and A^t_Y4/B across AB"),
    _vector("(6.27)", 1418, "A_Y4 = A^n_C + A^n_Y4/C + (across) A^n_C + (across) A^n_Y4/C", "A:Y4",
            "n:C n:Y4/C n:C n:Y4/C", "A:Y4 = n:C n:Y4/C t:C t:Y4/C", "A^t_C and A^t_Y4/C across"),
    _vector("Example 6.18", 1448, "V_B = V_C + V_B/C", "V:B", "V:C V:B/C"),
    _vector("Example 6.18", 1480, "A_B = A^n_C + A^t_C + A^n_B/C + A^t_B/C", "A:B", "n:C t:C n:B/C t:B/C"),
)  # fmt: skip
