"""Published formulas as formulas: the right ones hold, the mended ones too, and a planted slip is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from conrod.audit import Kind
from conrod.audit.formulas import cam_checks, saw_listing
from conrod.audit.formulas import module as module_formulas
from conrod.audit.formulas import press as press_formulas
from conrod.audit.formulas import saw as saw_formulas
from conrod.audit.formulas.published import SAME, derivative, discrepancy, verdict_on

ARGUMENTS = {
    "000": (press_formulas.FORMULAS, press_formulas.arguments()),
    "001": (module_formulas.FORMULAS, module_formulas.arguments()),
    "002": (saw_formulas.FORMULAS, saw_formulas.arguments()),
    "002-listing": (saw_listing.FORMULAS, saw_listing.arguments()),
    "004": (cam_checks.FORMULAS, cam_checks.arguments()),
}


@pytest.mark.parametrize("document", ARGUMENTS)
def test_a_planted_factor_in_a_right_formula_is_caught(document: str) -> None:
    formulas, arguments = ARGUMENTS[document]
    right = [f for f in formulas if verdict_on(f, arguments).kind is Kind.AGREES]
    assert right
    for formula in right:
        assert formula.function is not None
        bent = replace(formula, function=lambda f=formula.function, **k: 1.0001 * f(**k))
        assert verdict_on(bent, arguments).kind is Kind.NOT_REPRODUCIBLE


@pytest.mark.parametrize("document", ARGUMENTS)
def test_a_mended_formula_holds_and_a_wrong_mend_is_not_believed(document: str) -> None:
    formulas, arguments = ARGUMENTS[document]
    mended = [f for f in formulas if f.mended is not None]
    for formula in mended:
        assert discrepancy(formula.mended, formula.truth, arguments) <= SAME
        verdict = verdict_on(replace(formula, mended=formula.function), arguments)
        assert verdict.kind is Kind.NOT_REPRODUCIBLE


def test_the_derivative_by_the_complex_step_is_good_to_rounding() -> None:
    x = np.linspace(0.1, 3.0, 20)
    slope = derivative(lambda x: np.sqrt(4.0 + np.sin(x) ** 2), "x")(x=x)
    assert np.abs(slope - np.sin(x) * np.cos(x) / np.sqrt(4.0 + np.sin(x) ** 2)).max() < 1e-15


def test_matlab_divides_two_rows_into_one_number() -> None:
    a, b = np.array([1.0, 2.0, 4.0]), np.array([2.0, 4.0, 8.5])
    solved = np.linalg.lstsq(b[:, None], a, rcond=None)[0]
    assert saw_listing.matrix_right_division(a, b) == pytest.approx(float(solved[0]), rel=1e-14)
