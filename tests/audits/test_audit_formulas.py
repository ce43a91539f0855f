"""Published formulas as formulas: the right ones hold, the mended ones too, and a planted slip is seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from audits.documents import module as module_names
from audits.documents import module_claims
from audits.formulas import listing_names, saw_listing
from audits.formulas.published import SAME, Formula, derivative, discrepancy, verdict_on
from audits.listing_survey import runs
from conrod.models.printed.verdicts import VerdictKind

DOCUMENTS = (
    "press", "press_steps", "module", "module_relations", "module_vectors", "saw", "saw_vectors", "saw_listing",
    "cam_checks",
)  # fmt: skip


def published_formulas(document: str) -> tuple[Sequence[Formula], Any]:
    """Formulas of a document, and arguments to try them with."""
    module = import_module(f"audits.formulas.{document}")
    return module.FORMULAS, module.arguments()


@pytest.mark.parametrize("document", DOCUMENTS)
def test_a_planted_factor_in_a_right_formula_is_caught(document: str) -> None:
    formulas, arguments = published_formulas(document)
    right = [f for f in formulas if verdict_on(f, arguments).kind is VerdictKind.AGREES]
    assert right
    for formula in right:
        bent = replace(formula, function=lambda f=formula.function, **k: 1.0001 * f(**k))
        assert verdict_on(bent, arguments).kind is VerdictKind.NOT_REPRODUCIBLE


@pytest.mark.parametrize("document", DOCUMENTS)
def test_a_mended_formula_holds_and_a_wrong_mend_is_not_believed(document: str) -> None:
    formulas, arguments = published_formulas(document)
    for formula in (f for f in formulas if f.mended is not None):
        assert discrepancy(formula.mended, formula.truth, arguments) <= SAME
        verdict = verdict_on(replace(formula, mended=formula.function), arguments)
        assert verdict.kind is VerdictKind.NOT_REPRODUCIBLE


def test_the_derivative_by_the_complex_step_is_good_to_rounding() -> None:
    x = np.linspace(0.1, 3.0, 20)
    slope = derivative(lambda x: np.sqrt(4.0 + np.sin(x) ** 2), "x")(x=x)
    assert np.abs(slope - np.sin(x) * np.cos(x) / np.sqrt(4.0 + np.sin(x) ** 2)).max() < 1e-15


def test_matlab_divides_two_rows_into_one_number() -> None:
    a, b = np.array([1.0, 2.0, 4.0]), np.array([2.0, 4.0, 8.5])
    solved = np.linalg.lstsq(b[:, None], a, rcond=None)[0]
    assert saw_listing.matrix_right_division(a, b) == pytest.approx(float(solved[0]), rel=1e-14)


def test_listing_requires_elementwise_operators_and_radians() -> None:
    found = {(run.speed, run.way): (run.velocity_error, run.acceleration_error) for run in runs()}
    right = "with .*, ./ and .^, the speed typed in rad/s"
    for (_, way), errors in found.items():
        assert (max(errors) <= SAME) == (way == right)
        assert way == right or min(errors) > 0.3


def test_unassigned_names_of_the_listing_are_found_until_mended() -> None:
    text = listing_names.listing()
    told = {verdict.quantity: (verdict.line, verdict.should_be) for verdict in listing_names.verdicts(text)}
    assert told == {
        "theta3": (173, "theta3b in place of theta3"),
        "kecepatanC": (175, "KecepatanC in place of kecepatanC"),
        "percepatanC": (176, "PercepatanC in place of percepatanC"),
    }
    mended = (
        text.replace("theta3*", "theta3b*").replace("kecepatanC", "KecepatanC").replace("percepatanC", "PercepatanC")
    )
    assert list(listing_names.verdicts(mended)) == []
    assert [v.quantity for v in listing_names.verdicts(mended.replace("w2=input", "w=input"))] == ["w2"]


def test_a_unit_or_a_name_that_fits_is_not_called_a_misprint() -> None:
    right = replace(module_names.UNITS[1], unit="m/s^2")
    assert module_names._unit(right).kind is VerdictKind.AGREES
    length = module_names.LENGTHS[1]
    assert module_names._length(length).kind is VerdictKind.MISPRINT
    assert module_names._length(replace(length, name="O13A", right="O13A")).kind is VerdictKind.AGREES
    # A use that does not give the printed result shows nothing.
    assert module_names._length(replace(length, length="0,66")).kind is VerdictKind.NOT_REPRODUCIBLE


def test_senses_match_the_machines_and_one_direction_does_not() -> None:
    found = {v.quantity: v for v in module_claims.verdicts()}
    assert [found[q].kind for q in ("sense of omega 3", "sense of omega 5", "omega 3 and omega 4")] == [
        VerdictKind.AGREES
    ] * 3
    assert found["direction of CY4"].kind is VerdictKind.MISPRINT
    # The speeds that the example prints, with their signs; and the other sense is not believed.
    assert module_claims.turn_of("two-slider-linkage", "A", "B") == pytest.approx(-21.88, abs=0.005)
    assert module_claims.turn_of("two-slider-linkage", "B", "C") == pytest.approx(63.457, abs=0.005)
    assert module_claims._sense(750, "omega 3", "A", "B", 1).kind is VerdictKind.MISPRINT
