"""Document 001: the worked examples of a course module, and its formulas."""

from __future__ import annotations

from conrod.audit.documents import module_accelerations, module_velocities
from conrod.audit.formulas.module import FORMULAS, arguments
from conrod.audit.formulas.published import verdict_on
from conrod.audit.judging import judge
from conrod.audit.printed import shipped_items
from conrod.audit.verdict import Verdict

DOCUMENT = "001"
CASES = module_velocities.CASES | module_accelerations.CASES


def verdicts() -> tuple[Verdict, ...]:
    """Every printed number, then every formula."""
    values = tuple(judge(CASES[item.key](item)) for item in shipped_items(DOCUMENT, "module.csv"))
    return values + tuple(verdict_on(formula, arguments()) for formula in FORMULAS)
