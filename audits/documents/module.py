"""Units and names of document 001 that its own numbers contradict.

Document 001: the worked examples of a course module, and its formulas.
"""

from __future__ import annotations

from dataclasses import dataclass

from audits.documents import module_accelerations, module_claims, module_velocities
from audits.formulas import module_relations, module_vectors
from audits.formulas.module import FORMULAS, arguments
from audits.formulas.published import verdict_on
from audits.items import shipped_items
from audits.judging import judge
from conrod.errors import InvalidInput
from conrod.mechanism.units import parse_quantity
from conrod.models.printed.verdicts import PrintedNumber, PrintedVerdict, VerdictKind


@dataclass(frozen=True)
class PrintedUnit:
    """A unit of a printed number, and the one that the number is of."""

    place: str
    line: int
    quantity: str
    text: str
    unit: str
    wanted: str
    right: str


@dataclass(frozen=True)
class PrintedLength:
    """A length of Example 4.10 under a name, and where the example uses it under another one.

    Attributes:
        first, by, result: the printed numbers of that use, and `divides` whether the length divides.
    """

    line: int
    name: str
    length: str
    right: str
    used: int
    first: str
    divides: bool
    result: str


UNITS = (
    PrintedUnit("section 2.5", 381, "acceleration of the train", "percepatan 60 km/jam", "km/hour", "m/s^2",
                "kecepatan (velocity) 60 km/jam"),
    PrintedUnit("Example 6.15", 1350, "scale of the accelerations", "1 cm = 81 m/s", "m/s", "m/s^2", "m/s^2"),
    PrintedUnit("Example 6.15", 1355, "tangential A_B/A", "727,5 rad/s^2", "rad/s^2", "m/s^2", "727,5 m/s^2"),
    PrintedUnit("Example 6.15", 1358, "tangential A_D/C", "187,5 rad/s^2", "rad/s^2", "m/s^2", "187,5 m/s^2"),
    PrintedUnit("Example 6.15", 1362, "tangential A_C", "25,5 rad/s^2", "rad/s^2", "m/s^2", "225 m/s^2"),
)  # fmt: skip
LENGTHS = (
    PrintedLength(718, "O1A", "0,14", "O12A", 744, "104,72", False, "14,66"),
    PrintedLength(720, "O1B", "0,67", "O13A", 744, "14,66", True, "21,88"),
    PrintedLength(722, "AB", "0,58", "O13B", 754, "21,88", False, "12,69"),
    PrintedLength(724, "O1C", "0,49", "O12O25", 768, "104,72", False, "51,31"),
    PrintedLength(726, "BC", "0,2", "O15B", 758, "12,69", True, "63,45"),
    PrintedLength(728, "O1O14", "0,06", "O15C", 778, "63,34", False, "3,8"),
    PrintedLength(730, "O1O14", "0,81", "O15O25", 774, "51,31", True, "63,34"),
)


def name_verdicts() -> tuple[PrintedVerdict, ...]:
    """One on each unit and each name of a length."""
    return tuple(_unit(unit) for unit in UNITS) + tuple(_length(length) for length in LENGTHS)


def _unit(unit: PrintedUnit) -> PrintedVerdict:
    try:
        parse_quantity("unit", f"1 {unit.unit}", unit.wanted)
    except InvalidInput:
        kind, reason, right = (
            VerdictKind.MISPRINT,
            f"{unit.unit} is not a unit of an acceleration, {unit.wanted}",
            unit.right,
        )
    else:
        kind, reason, right = VerdictKind.AGREES, f"a unit of {unit.wanted}", ""
    return _verdict(unit.place, unit.line, f"unit of the {unit.quantity}", unit.text, kind, reason, right)


def _length(length: PrintedLength) -> PrintedVerdict:
    """The name under which the example itself computes with the length; O1 alone stands for O12 throughout."""
    first, by, result = (PrintedNumber(text) for text in (length.first, length.length, length.result))
    value = first.value / by.value if length.divides else first.value * by.value
    sign = "/" if length.divides else " x "
    reason = f"line {length.used} uses {length.length} m as {length.right}: {first.text}{sign}{by.text} = {value:.4f}"
    text = f"{length.name} = {length.length} m"
    if not (result.is_rounding_of(value) or result.is_truncation_of(value)):
        return _verdict("Example 4.10", length.line, "a length", text, VerdictKind.NOT_REPRODUCIBLE, reason, "")
    same = length.right in (length.name, length.name.replace("O1", "O12"))
    kind = VerdictKind.AGREES if same else VerdictKind.MISPRINT
    finding = f"{reason}, printed there as {result.text}"
    return _verdict("Example 4.10", length.line, "name of a length", text, kind, finding, "" if same else length.right)


def _verdict(
    place: str, line: int, quantity: str, text: str, kind: VerdictKind, reason: str, right: str
) -> PrintedVerdict:
    return PrintedVerdict("001", place, line, quantity, "statement", "", text, None, None, kind, reason, right or None)


DOCUMENT = "001"
CASES = module_velocities.CASES | module_accelerations.CASES


def verdicts() -> tuple[PrintedVerdict, ...]:
    """Every printed number, then every formula, unit and name."""
    values = tuple(judge(CASES[item.key](item)) for item in shipped_items(DOCUMENT, "module.csv"))
    formulas = [verdict_on(formula, arguments()) for formula in FORMULAS]
    formulas += [verdict_on(formula, module_relations.arguments()) for formula in module_relations.FORMULAS]
    formulas += module_vectors.verdicts()
    formulas += name_verdicts()
    formulas += module_claims.verdicts()
    return values + tuple(sorted(formulas, key=lambda verdict: verdict.line))
