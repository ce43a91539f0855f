"""What the errors depend on and should not: masses and gravity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from conrod.report import numbers
from conrod.report.styles import engine_title
from conrod.report.tables import table
from conrod.studies.results import QUANTITIES
from conrod.studies.sweep_results import COMPLETED, SweepStudy

if TYPE_CHECKING:
    from conrod.studies.sensitivity import Sensitivity, Variation

SWITCHED = "gravity switched"


def variations_table(study: SweepStudy) -> str:
    """Errors of each setting with another mass or gravity, and their ratios to those as it is."""
    rows = []
    for sensitivity in study.sensitivities:
        steps = str(sensitivity.settings.get("steps_per_revolution", numbers.MISSING))
        for variation in sensitivity.variations:
            name = variation_name(sensitivity, variation)
            errors = [_error(variation, quantity) for quantity in QUANTITIES]
            rows.append([engine_title(sensitivity.engine), sensitivity.preset, steps, name, *errors, _drive(variation)])
    head = ["engine", "preset", "steps per revolution", "what is changed"]
    return table([*head, *(f"{q} error (ratio)" for q in QUANTITIES), "ripple of the drive"], rows)


def variation_name(sensitivity: Sensitivity, variation: Variation) -> str:
    """What was changed; gravity as it was switched."""
    if variation.name == SWITCHED:
        return "gravity off" if sensitivity.settings.get("gravity") else "gravity on"
    return variation.name if variation.value is None else f"{variation.name} ({numbers.quantity(variation.value)} kg)"


def _error(variation: Variation, quantity: str) -> str:
    if variation.errors is None:
        return variation.outcome
    ratio = variation.ratios.get(quantity)
    beside = "" if ratio is None else f" (x {numbers.measured(ratio)})"
    return f"{numbers.measured(variation.errors[quantity])}{beside}"


def _drive(variation: Variation) -> str:
    if variation.outcome != COMPLETED:
        return numbers.MISSING
    return numbers.measured(variation.drive) + ("" if variation.drive_kept else ": too much, no statement")
