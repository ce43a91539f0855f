"""From a printed number and what is known about it to a verdict.

A verdict other than agreement is given only to what a computation reproduces: a cause, a rounding or a wrong step is
named where its value, rounded or cut to the printed digits, is the print; a misprint where a neighbouring printed
quantity leaves no room for the print.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from conrod.own.printed.printed import Item, Number


class Kind(StrEnum):
    """The closed list of verdicts; the value is what a reader sees."""

    AGREES = "agrees"
    AFTER_ROUNDING = "agrees after rounding"
    EXPLAINED = "explained"
    MISPRINT = "misprint"
    WRONG_STEP = "wrong step"
    NOT_REPRODUCIBLE = "not reproducible as printed"


@dataclass(frozen=True)
class Verdict:
    """One printed item, judged.

    Attributes:
        document, place, line: where it stands; the line counts in the document's text file.
        quantity, condition, unit: what it is, when, and in what the print gives it.
        printed: the digits as they stand there, or the formula.
        exact: the value that the mechanism determines, in the printed unit; None where the print determines none.
        difference: printed - exact, in units of the last printed digit.
        kind: the verdict.
        reason: the computation that shows it, in one sentence.
        should_be: what is to be printed in its place; None where the print may stand.
        off: how far the print is off, as a share of the right value or of its peak; None where there is none.
        cause: what reproduces the print where that is not the exact motion, in words; items share it.
    """

    document: str
    place: str
    line: int
    quantity: str
    condition: str
    unit: str
    printed: str
    exact: float | None
    difference: float | None
    kind: Kind
    reason: str
    should_be: str | None = None
    off: float | None = None
    cause: str | None = None


@dataclass(frozen=True)
class Audited:
    """Verdicts on one document or table.

    Attributes:
        document: name of the user's file, or "Document" and the number of one of the four.
        title: of the document.
        verdicts: in the order of the items.
        notes: doubts about the verdicts, a sentence or two each.
    """

    document: str
    title: str
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()

    @property
    def counts(self) -> Mapping[Kind, int]:
        """Number of verdicts of each kind, in the order of the kinds."""
        return {kind: sum(verdict.kind is kind for verdict in self.verdicts) for kind in Kind}


@dataclass(frozen=True)
class Explanation:
    """Another way to a value: in words, and the value that it gives in the printed unit.

    `within` is what reading from a drawing may add to it.
    """

    text: str
    value: float
    within: float = 0.0


@dataclass(frozen=True)
class Neighbour:
    """A printed quantity that fixes another one.

    Attributes:
        text: the relation, in words.
        value: what it makes of the other, in the printed unit.
        within: how far rounding of the neighbour itself may move that.
    """

    text: str
    value: float
    within: float


@dataclass(frozen=True)
class Case:
    """A printed number with all that may be held against it; each list is tried in order.

    Attributes:
        exact: the value that the mechanism determines, in the printed unit; None where the print does not determine it.
        why: the computation of the exact value, or why there is none.
        causes: systematic causes.
        roundings: the same computation from values as they were printed.
        neighbours: printed quantities that fix this one.
        wrong_steps: formulas or substitutions in error.
        reading: half a division of the drawing that the number was measured from, in the printed unit.
        instead: what is to be printed, where that is more than the right digits.
        certain: whether the exact value is what ought to be printed; not where it leans on a fitted pose.
    """

    item: Item
    exact: float | None
    why: str
    causes: tuple[Explanation, ...] = ()
    roundings: tuple[Explanation, ...] = ()
    neighbours: tuple[Neighbour, ...] = ()
    wrong_steps: tuple[Explanation, ...] = ()
    reading: float = 0.0
    instead: str | None = None
    certain: bool = True


def judge(case: Case) -> Verdict:
    """The verdict on a printed number; the kindest that a computation supports.

    A systematic cause goes before a single number's cut: it leaves the document's habit of rounding as it is.
    """
    return (
        _agreement(case)
        or _explained(case, case.causes, Kind.EXPLAINED)
        or _explained(case, case.roundings, Kind.AFTER_ROUNDING)
        or _cut(case)
        or _contradiction(case)
        or _explained(case, case.wrong_steps, Kind.WRONG_STEP)
        or _read(case)
        or _verdict(case, Kind.NOT_REPRODUCIBLE, case.why, _correct(case))
    )


def _agreement(case: Case) -> Verdict | None:
    if case.exact is None or not case.item.number.is_rounding_of(case.exact):
        return None
    return _verdict(case, Kind.AGREES, case.why)


def _cut(case: Case) -> Verdict | None:
    if case.exact is None or not case.item.number.is_cut_of(case.exact):
        return None
    return _verdict(case, Kind.AFTER_ROUNDING, f"{case.why}; further digits are cut off instead of rounded")


def _explained(case: Case, explanations: tuple[Explanation, ...], kind: Kind) -> Verdict | None:
    """The first explanation that reproduces the print, if one does; a systematic cause has to do so without a cut."""
    number = case.item.number
    for one in explanations:
        rounded = number.is_rounding_of(one.value) or abs(number.value - one.value) <= one.within
        if rounded or (kind is not Kind.EXPLAINED and number.is_cut_of(one.value)):
            how = "" if rounded else ", cut off"
            # A value that is nothing in the printed digits by far is rounding noise.
            value = one.value if abs(one.value) > 1e-9 * number.last else 0.0
            right = None if kind is Kind.AFTER_ROUNDING else _correct(case)
            return _verdict(case, kind, f"{one.text} gives {value:.7g}{how}; {case.why}", right, cause=one.text)
    return None


def _contradiction(case: Case) -> Verdict | None:
    number = case.item.number
    for neighbour in case.neighbours:
        room = neighbour.within + 0.5 * number.last
        supported = case.exact is None or abs(neighbour.value - case.exact) <= room
        if abs(neighbour.value - number.value) > room and supported:
            right = neighbour.value if case.exact is None else case.exact
            reason = f"by {neighbour.text} it is {neighbour.value:.7g} +- {room:.2g}; {case.why}"
            return _verdict(case, Kind.MISPRINT, reason, case.instead or number.like(right), right)
    return None


def _read(case: Case) -> Verdict | None:
    if case.exact is None or abs(case.item.number.value - case.exact) > case.reading:
        return None
    return _verdict(case, Kind.AFTER_ROUNDING, f"{case.why}; measured from a drawing, good to {case.reading:.2g}")


def _correct(case: Case) -> str | None:
    if case.exact is None or not case.certain:
        return None
    return case.instead or case.item.number.like(case.exact)


def _verdict(
    case: Case,
    kind: Kind,
    reason: str,
    should_be: str | None = None,
    right: float | None = None,
    cause: str | None = None,
) -> Verdict:
    item, number, exact = case.item, case.item.number, case.exact
    against = exact if right is None else right
    difference = None if exact is None else (number.value - exact) / number.last
    off = None if against is None or should_be is None else _share(number, against)
    return Verdict(
        item.document, item.place, item.line, item.quantity, item.condition, item.unit, number.text, exact,
        difference, kind, reason, should_be, off, cause,
    )  # fmt: skip


def _share(number: Number, right: float) -> float:
    """Error of a print as a share of the right value; of itself where that is zero in the printed digits."""
    of = abs(right) if abs(right) >= 0.5 * number.last else abs(number.value)
    return abs(number.value - right) / (of or 1.0)
