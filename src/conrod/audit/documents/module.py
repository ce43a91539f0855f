"""Document 001: the worked examples of a course module, and its formulas."""

from __future__ import annotations

from conrod.audit.documents import module_accelerations, module_claims, module_names, module_velocities
from conrod.audit.formulas import module_relations, module_vectors
from conrod.audit.formulas.module import FORMULAS, arguments
from conrod.audit.formulas.published import verdict_on
from conrod.audit.judging import judge
from conrod.audit.printed import shipped_items
from conrod.audit.verdict import Verdict

DOCUMENT = "001"
CASES = module_velocities.CASES | module_accelerations.CASES


def verdicts() -> tuple[Verdict, ...]:
    """Every printed number, then every formula, unit and name."""
    values = tuple(judge(CASES[item.key](item)) for item in shipped_items(DOCUMENT, "module.csv"))
    formulas = [verdict_on(formula, arguments()) for formula in FORMULAS]
    formulas += [verdict_on(formula, module_relations.arguments()) for formula in module_relations.FORMULAS]
    formulas += module_vectors.verdicts()
    formulas += module_names.verdicts()
    formulas += module_claims.verdicts()
    return values + tuple(sorted(formulas, key=lambda verdict: verdict.line))
