"""Errors told from the joints' gaps alone, beside the measured ones (guard 6), of the presets."""

from __future__ import annotations

from collections.abc import Mapping

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.sweep.choice import preset_curves
from conrod.report.tables import table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import SweepStudy, SweptPoint

SMALL = 0.1  # of L: above it, what is of second order is not small
CLEAR = 1e3 * numbers.ROUNDING


def told_table(study: SweepStudy) -> str:
    """A row for each completed run of a preset."""
    rows = [
        [
            engine_title(curve.engine),
            curve.preset,
            str(point.steps_per_revolution),
            *(_entry(point, prediction, quantity) for quantity in QUANTITIES),
        ]
        for curve in preset_curves(study)
        for point in curve.points
        if (prediction := point.measurement.prediction) is not None
    ]
    head = ["engine", "preset", "steps per revolution", *(f"{q}: measured, told, difference" for q in QUANTITIES)]
    return table(head, rows)


def _entry(point: SweptPoint, prediction: Mapping[str, Mapping[str, float]], quantity: str) -> str:
    told = prediction[quantity]
    sizes = (point.error(quantity), told["predicted"], told["difference"])
    return ", ".join(numbers.measured(size) for size in sizes)


def largest_difference(study: SweepStudy) -> tuple[float, int] | None:
    """The largest difference of told and measured position errors, over the measured one; and of how many runs.

    Of all completed runs of the sweep whose error is neither rounding nor too large for a first-order statement.
    """
    shares = []
    for point in study.points:
        error, prediction = point.error("position"), point.measurement.prediction
        if error is not None and prediction is not None and CLEAR <= error <= SMALL:
            shares.append(prediction["position"]["difference"] / error)
    return (max(shares), len(shares)) if shares else None
