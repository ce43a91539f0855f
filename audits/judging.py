"""From a printed number of a document and what is known about it to a verdict.

A verdict other than agreement is given only to what a computation reproduces: a cause, a rounding or a wrong step is
named where its value, rounded or cut to the printed digits, is the print; a misprint where a neighbouring printed
quantity leaves no room for the print.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from conrod.models.printed.verdicts import PrintedNumber, PrintedVerdict, VerdictKind


@dataclass(frozen=True)
class Item:
    """A printed number that a mechanism determines.

    Attributes:
        key: names the computation that determines it.
        mechanism: the scene or the worked example that it is tied to.
        The others as in `PrintedVerdict`.
    """

    document: str
    key: str
    place: str
    line: int
    quantity: str
    condition: str
    number: PrintedNumber
    unit: str
    mechanism: str


@dataclass(frozen=True)
class Explanation:
    """Another way to a value: a computation, or a neighbouring printed quantity that fixes it.

    Attributes:
        text: in words.
        value: in the printed unit.
        within: what reading from a drawing, or rounding of the neighbour, may add to it.
    """

    text: str
    value: float
    within: float = 0.0


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
        certain: whether the exact value is what ought to be printed; not where it leans on a fitted pose.
    """

    item: Item
    exact: float | None
    why: str
    causes: tuple[Explanation, ...] = ()
    roundings: tuple[Explanation, ...] = ()
    neighbours: tuple[Explanation, ...] = ()
    wrong_steps: tuple[Explanation, ...] = ()
    reading: float = 0.0
    certain: bool = True


def judge(case: Case) -> PrintedVerdict:
    """The verdict on a printed number; the kindest that a computation supports.

    A systematic cause goes before a single number's cut: it leaves the document's habit of rounding as it is.
    """
    return next(_verdicts(case))


def _verdicts(case: Case) -> Iterator[PrintedVerdict]:
    number, exact, why = case.item.number, case.exact, case.why
    right = None if exact is None or not case.certain else number.format_like(exact)
    if exact is not None and number.is_rounding_of(exact):
        yield _verdict(case, VerdictKind.AGREES, why)
    yield from _explained(case, case.causes, VerdictKind.EXPLAINED, right)
    yield from _explained(case, case.roundings, VerdictKind.AFTER_ROUNDING)
    if exact is not None and number.is_truncation_of(exact):
        yield _verdict(case, VerdictKind.AFTER_ROUNDING, f"{why}; further digits are cut off instead of rounded")
    for neighbour in case.neighbours:
        room = neighbour.within + 0.5 * number.last
        supported = exact is None or abs(neighbour.value - exact) <= room
        if abs(neighbour.value - number.value) > room and supported:
            against = neighbour.value if exact is None else exact
            reason = f"by {neighbour.text} it is {neighbour.value:.7g} +- {room:.2g}; {why}"
            yield _verdict(case, VerdictKind.MISPRINT, reason, number.format_like(against), against)
    yield from _explained(case, case.wrong_steps, VerdictKind.WRONG_STEP, right)
    if exact is not None and abs(number.value - exact) <= case.reading:
        yield _verdict(case, VerdictKind.AFTER_ROUNDING, f"{why}; measured from a drawing, good to {case.reading:.2g}")
    yield _verdict(case, VerdictKind.NOT_REPRODUCIBLE, why, right)


def _explained(
    case: Case, explanations: tuple[Explanation, ...], kind: VerdictKind, right: str | None = None
) -> Iterator[PrintedVerdict]:
    """Explanations that reproduce the print; a systematic cause has to do so without a cut."""
    number = case.item.number
    for one in explanations:
        rounded = number.is_rounding_of(one.value) or abs(number.value - one.value) <= one.within
        if rounded or (kind is not VerdictKind.EXPLAINED and number.is_truncation_of(one.value)):
            how = "" if rounded else ", cut off"
            # A value that is nothing in the printed digits by far is rounding noise.
            value = one.value if abs(one.value) > 1e-9 * number.last else 0.0
            yield _verdict(case, kind, f"{one.text} gives {value:.7g}{how}; {case.why}", right, cause=one.text)


def _verdict(
    case: Case,
    kind: VerdictKind,
    reason: str,
    should_be: str | None = None,
    right: float | None = None,
    cause: str | None = None,
) -> PrintedVerdict:
    item, number, exact = case.item, case.item.number, case.exact
    against, off = exact if right is None else right, None
    if against is not None and should_be is not None:
        # As a share of the right value; of the print where that is zero in the printed digits.
        of = abs(against) if abs(against) >= 0.5 * number.last else abs(number.value)
        off = abs(number.value - against) / (of or 1.0)
    difference = None if exact is None else (number.value - exact) / number.last
    return PrintedVerdict(
        item.document, item.place, item.line, item.quantity, item.condition, item.unit, number.text, exact,
        difference, kind, reason, should_be, off, cause,
    )  # fmt: skip
