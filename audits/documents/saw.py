"""Document 002: the one printed number that the saw determines, its formulas, and its MATLAB listing as MATLAB runs it.

Its other numbers are given lengths and speeds, and its results are figures, which are lost.
"""

from __future__ import annotations

from audits.formulas import listing_names, saw, saw_listing, saw_vectors
from audits.formulas.published import verdict_on
from audits.items import shipped_items
from audits.judging import Case, Item, judge
from conrod.models.printed.verdicts import PrintedVerdict
from conrod.scenes import Saw

DOCUMENT = "002"


def verdicts() -> tuple[PrintedVerdict, ...]:
    """The number, then every formula, then the listing with its names."""
    values = tuple(judge(_reference_place(item)) for item in shipped_items(DOCUMENT, "saw.csv"))
    formulas = tuple(verdict_on(formula, saw.arguments()) for formula in (*saw_vectors.FORMULAS, *saw.FORMULAS))
    lines = [verdict_on(line, saw_listing.arguments()) for line in saw_listing.FORMULAS]
    lines += listing_names.verdicts(listing_names.listing())
    return values + formulas + tuple(sorted(lines, key=lambda verdict: verdict.line))


def _reference_place(item: Item) -> Case:
    return Case(item, Saw().shaft[0] / 1e-3, "sqrt(r3^2 - (r1 - r5)^2) - r2")
