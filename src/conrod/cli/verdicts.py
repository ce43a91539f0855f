"""Verdicts of `conrod validate` on the terminal: a line for each result, and what is to be said besides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from conrod.report.numbers import fine_order
from conrod.report.terminal import console, print_lines, print_table

if TYPE_CHECKING:
    from conrod.studies.forces.results import ForceStudy
    from conrod.studies.free_motion.results import MotionStudy
    from conrod.studies.validation.results import SceneStudy

WIDE = 180


def print_verdicts(studies: Sequence[SceneStudy]) -> None:
    """Largest errors over the observed points, observed order, verdict; why what is not judged is not."""
    from conrod.report.validation.tables import verdicts_table

    out = console()
    print_table(out, verdicts_table(studies, fine_order), folding=("verdict",))
    reasons = dict.fromkeys(
        (result.scene, result.tolerance.reason)
        for study in studies
        for result in study.results
        if result.passed is None and result.tolerance.reason
    )
    print_lines(out, (f"{scene}: tolerances: {reason}" for scene, reason in reasons))


def print_forces(found: Sequence[ForceStudy]) -> None:
    """Largest errors, observed orders, verdict; then what no quantity shows of a wrong mass."""
    from conrod.report.forces import hidden_words, tolerance_reasons, unseen_words, verdicts_table

    out = console()
    print_table(out, verdicts_table(found, fine_order), folding=("verdict",))
    print_lines(out, (f"tolerance: {reason}" for reason in tolerance_reasons(r for one in found for r in one.results)))
    for one in found:
        unseen = [*unseen_words(one.effects), *hidden_words(one.hidden)]
        if unseen:
            print_lines(out, [f"{one.name}: no quantity depends on: {'; '.join(unseen)}"])


def print_motions(studies: Sequence[MotionStudy]) -> None:
    """Errors in time, and what is to be said of the exact motion."""
    from conrod.report.free_motion import exact_words, loads_words, verdicts_table

    out = console(WIDE)
    print_table(out, verdicts_table(studies, with_clock=True), folding=("verdict",))
    print_lines(out, (f"{study.name}: {loads_words(study)} {exact_words(study)}" for study in studies))
