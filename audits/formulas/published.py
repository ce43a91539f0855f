"""Formulas as a document publishes them, and whether they hold: on whole ranges of arguments, derivatives included."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from conrod.models.printed.verdicts import PrintedVerdict, VerdictKind

# A formula takes arrays of one shape, real or complex, by name.
Formula: TypeAlias = Callable[..., Any]

STEP = 1e-30  # of the complex step: its error, of the order of the square, vanishes in double precision
SAME = 1e-11  # relative; what differs by less is the same formula, up to rounding


def derivative(formula: Formula, by: str) -> Formula:
    """The derivative of an analytic formula by one of its arguments, to rounding.

    By the complex step, f'(x) = Im f(x + i h) / h (Squire and Trapp, SIAM Review 40 (1998) 110-112).
    """

    def differentiated(**arguments: Any) -> Any:
        stepped = dict(arguments)
        stepped[by] = arguments[by] + 1j * STEP
        return np.imag(formula(**stepped)) / STEP

    return differentiated


def discrepancy(formula: Formula, truth: Formula, arguments: Mapping[str, Any]) -> float:
    """The largest difference of two formulas over all arguments, relative to the largest true value."""
    true = np.asarray(truth(**arguments))
    return float(np.max(np.abs(formula(**arguments) - true)) / np.max(np.abs(true)))


@dataclass(frozen=True)
class Published:
    """One formula of a document.

    Attributes:
        place: equation number or section; `line` in the document's text file.
        text: the formula as it stands there, in one line.
        function: the same, transcribed; None where the print cannot be evaluated at all.
        truth: what it ought to be, from elsewhere: the derivative of its function, or the geometry.
        against: says in words what `truth` is.
        mended: the formula put right, where it has to be.
        change: what is put right, in words.
        kind: the verdict where the print fails and the mended formula holds.
        hindrance: why it cannot be evaluated where there is no function.
    """

    document: str
    place: str
    line: int
    quantity: str
    text: str
    function: Formula | None
    truth: Formula
    against: str
    mended: Formula | None = None
    change: str = ""
    kind: VerdictKind = VerdictKind.MISPRINT
    hindrance: str = "cannot be evaluated"


def verdict_on(formula: Published, arguments: Mapping[str, Any]) -> PrintedVerdict:
    """Compare a formula, and its mended form, with the truth over all arguments."""
    error = None if formula.function is None else discrepancy(formula.function, formula.truth, arguments)
    if error is not None and error <= SAME:
        return _verdict(formula, VerdictKind.AGREES, f"equals {formula.against}")
    printed = f"differs from {formula.against} by {error:.2g} of its peak" if error is not None else formula.hindrance
    if formula.mended is not None:
        left = discrepancy(formula.mended, formula.truth, arguments)
        if left <= SAME:
            reason = f"as printed it {printed}; with {formula.change} nothing is left"
            return _verdict(formula, formula.kind, reason, formula.change, error)
    return _verdict(formula, VerdictKind.NOT_REPRODUCIBLE, f"as printed it {printed}", None, error)


def _verdict(
    formula: Published, kind: VerdictKind, reason: str, should_be: str | None = None, error: float | None = None
) -> PrintedVerdict:
    return PrintedVerdict(
        formula.document,
        formula.place,
        formula.line,
        formula.quantity,
        "formula",
        "",
        formula.text,
        None,
        None,
        kind,
        reason,
        should_be,
        error,
        formula.change if kind is VerdictKind.EXPLAINED else None,
    )
