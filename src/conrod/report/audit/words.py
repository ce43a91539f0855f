"""How an item of an audit is put: with as many digits as come out the same on every machine."""

from __future__ import annotations

import re
from collections.abc import Iterable

from conrod.own.printed.judging import Kind, Verdict
from conrod.own.printed.printed import DIGITS, Number
from conrod.report.numbers import quantity, rounded

NONE = "-"
# Digits of an exact value beyond the printed ones.
MORE = 3
MEANINGS = {
    Kind.AGREES: "the print is the exact value, rounded",
    Kind.AFTER_ROUNDING: "it is once further digits are cut off instead of rounded, or it is computed from values as "
    "they were printed, or measured from a drawing to half a division",
    Kind.EXPLAINED: "a systematic cause reproduces the print: a constant cut short, a truncated series, a coarse grid",
    Kind.MISPRINT: "another printed quantity, or the formula beside it, contradicts the print",
    Kind.WRONG_STEP: "a formula or a substitution in error reproduces the print",
    Kind.NOT_REPRODUCIBLE: "nothing that was tried gives the print, or what it was measured from is lost",
}


def is_formula(verdict: Verdict) -> bool:
    """Whether the item is no number."""
    return not DIGITS.fullmatch(verdict.printed)


def exact_text(verdict: Verdict) -> str:
    """The exact value with some digits more than the print."""
    if verdict.exact is None:
        return NONE
    return signless(f"{verdict.exact:.{Number(verdict.printed).decimals + MORE}f}")


def difference_text(verdict: Verdict) -> str:
    """Printed less exact in units of the last printed digit."""
    return NONE if verdict.difference is None else signless(f"{verdict.difference:+.2f}")


def signless(text: str) -> str:
    """The same without the sign of a zero, which is rounding noise."""
    return text.lstrip("+-") if not re.search("[1-9]", text) else text


def off_text(verdict: Verdict) -> str:
    """How far the print is off, in percent."""
    if verdict.off is None:
        return NONE
    return f"{share_text(verdict.off)} %"


def share_text(share: float) -> str:
    """A share in percent, in two significant digits and without an exponent."""
    percent = rounded(100.0 * share, 2)
    return f"{percent:.0f}" if percent >= 10.0 else quantity(percent, 2)


def plain(text: str) -> str:
    """Text in which Markdown sees no mark of its own."""
    return re.sub(r"([*_<>\[\]`])", r"\\\1", text)


def code(text: str) -> str:
    """A formula as it stands."""
    return f"`{text.replace('`', ' ')}`"


def printed_text(verdict: Verdict) -> str:
    """The print with its unit, or the formula."""
    return code(verdict.printed) if is_formula(verdict) else f"{verdict.printed} {plain(verdict.unit)}".strip()


def right_text(verdict: Verdict) -> str:
    """What is to stand in its place, with the unit."""
    if verdict.should_be is None:
        return NONE
    number = DIGITS.fullmatch(verdict.should_be)
    if not number and re.search(r"[*^]", verdict.should_be) and " in place of " not in verdict.should_be:
        # A formula is to be copied: no mark of Markdown may come into it.
        return f"**{code(verdict.should_be)}**"
    return f"**{plain(verdict.should_be)}**" + (f" {plain(verdict.unit)}".rstrip() if number else "")


def lines_text(lines: Iterable[int]) -> str:
    """Lines of the document's text."""
    return ", ".join(str(line) for line in dict.fromkeys(lines))


def counted(number: int, noun: str) -> str:
    """A count with its noun."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
