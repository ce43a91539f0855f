"""The tables of a validation, on the console and on a scene's page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.results import name_of, refinement_table, results_table, verdict_cell
from conrod.report.table import Table, table
from conrod.report.validation.words import order_words
from conrod.runs.trajectory import Outcome
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.validation.results import SceneStudy, ValidationResult

MEASURES = ("max", "rms", "final")
JUDGED = (*QUANTITIES, "total", "velocity_rms")
TITLE = "largest error over the run, normalised by L, ω L, ω² L"


def dynamic(study: SceneStudy) -> list[ValidationResult]:
    """The results of real time stepping."""
    return [r for r in study.results if r.mode == "dynamic"]


def verdicts_table(studies: Sequence[SceneStudy], order: Callable[[float | None], str] = numbers.order) -> Table:
    """A row for each result: largest errors over the observed points, observed orders as asked for, verdict."""

    def orders(run: ValidationResult) -> str:
        return "" if run.order is None else ", ".join(order(run.order[q]) for q in QUANTITIES)

    columns: dict[str, Callable[[ValidationResult], str]] = {
        "steps/rev": lambda r: str(r.steps_per_revolution or ""),
        **{q: partial(_largest, quantity=q) for q in QUANTITIES},
        "order x, v, a": orders,
    }
    return results_table(studies, columns, TITLE)


def _largest(run: ValidationResult, quantity: str, measure: str = "max") -> str:
    return numbers.measured(run.largest(quantity, measure))


def errors_table(study: SceneStudy, point: str) -> Table:
    """Max, rms and final value of each error of a point."""
    names = (*QUANTITIES, "total")
    rows = [
        (*name_of(r), *(_sizes(r.errors[point].get(q)) for q in names))
        for r in dynamic(study)
        if r.errors is not None and point in r.errors
    ]
    return table(["engine", "preset", *(f"{q}: max, rms, final" for q in names)], rows)


def _sizes(size: Mapping[str, float] | None) -> str:
    return numbers.MISSING if size is None else ", ".join(numbers.measured(size[m]) for m in MEASURES)


def peaks_table(study: SceneStudy, point: str) -> Table:
    """L and the exact peaks of a point, in mm, beside what velocity and acceleration are divided by."""
    length, speed = study.scene.lengths[point], abs(study.scene.speed)
    turn = np.linspace(*study.scene.kinematics.span, 7201)
    exact = study.scene.motion(turn, study.scene.speed).point(point)
    velocity, acceleration = (
        numbers.quantity(1e3 * float(np.linalg.norm(values, axis=1).max()))
        for values in (exact.velocity, exact.acceleration)
    )
    rows = [
        ("position", f"L = {numbers.quantity(1e3 * length)} mm", "-"),
        ("velocity", f"ω L = {numbers.quantity(1e3 * speed * length)} mm/s", f"{velocity} mm/s"),
        ("acceleration", f"ω² L = {numbers.quantity(1e3 * speed**2 * length)} mm/s²", f"{acceleration} mm/s²"),
    ]
    return table(("exact motion", "errors are divided by", "exact peak"), rows)


def orders_table(study: SceneStudy) -> Table:
    """Errors along the refinement path and the order that they show."""
    return refinement_table(
        dynamic(study),
        "quantity",
        lambda _: QUANTITIES,
        lambda _, point, quantity: getattr(point, quantity),
        order_words,
    )


def closure_table(study: SceneStudy) -> Table:
    """Closure, phase and drive of every run."""
    head = ["engine", "preset", "gap, max / L", "gap rate, max / (ω L)", "gap acceleration, max / (ω² L)"]
    head += ["phase [rad], max", "final", "speed ripple", "angular acceleration / ω²"]
    rows = [
        (
            *name_of(r),
            *_values(r.closure, QUANTITIES),
            *_values(r.phase, ("max", "final")),
            *_values(r.drive, ("speed", "acceleration")),
        )
        for r in dynamic(study)
        if r.closure is not None
    ]
    return table(head, rows)


def prediction_table(study: SceneStudy) -> Table:
    """Errors predicted from the joints alone, beside the measured ones."""
    rows = [
        (*name_of(r), *(", ".join(_predicted(r, q)) for q in QUANTITIES))
        for r in dynamic(study)
        if r.prediction is not None
    ]
    return table(["engine", "preset", *(f"{q}: measured, predicted, difference" for q in QUANTITIES)], rows)


def _predicted(run: ValidationResult, quantity: str) -> list[str]:
    found = None if run.prediction is None else run.prediction[quantity]
    return [_largest(run, quantity), *_values(found, ("predicted", "difference"))]


def _values(values: Mapping[str, float | None] | None, names: tuple[str, ...]) -> list[str]:
    return [numbers.measured(None if values is None else values.get(name)) for name in names]


def kinematic_table(study: SceneStudy) -> Table:
    """Kinematic mode: the proof of the model."""
    head = ["engine", "position error / L, max", "velocity error / (ω L), max", "gap / L, max"]
    head += ["position allowed", "velocity allowed", "because", "verdict"]
    rows = [
        (
            engine_title(r.engine),
            *(_largest(r, q) for q in ("position", "velocity")),
            *_values(r.closure, ("position",)),
            *(numbers.measured(allowed) for allowed in (r.tolerance.position, r.tolerance.velocity)),
            r.tolerance.reason,
            verdict_cell(r),
        )
        for r in study.results
        if r.mode == "kinematic"
    ]
    return table(head, rows)


def tolerances_table(study: SceneStudy) -> Table:
    """The errors allowed in dynamic mode, and why."""
    head = ["engine", "preset", "position", "velocity", "acceleration", "total", "velocity, rms", "because"]
    rows = []
    for r in dynamic(study):
        unsupported = r.outcome == Outcome.UNSUPPORTED.slug
        because = r.tolerance.reason or ("unsupported" if unsupported else "not judged")
        rows.append((*name_of(r), *(numbers.measured(getattr(r.tolerance, n)) for n in JUDGED), because))
    return table(head, rows)


def printed_table(study: SceneStudy) -> Table:
    """The document's printed table against the runs; no row where there is none."""
    rows = [
        (*name_of(r), f"{r.printed.engine_agrees} of {r.printed.exact_agrees}", numbers.measured(r.printed.worst))
        for r in study.results
        if r.printed is not None
    ]
    return table(["engine", "preset", "cells met", "largest distance from a print [last printed units]"], rows)


def contact_table(study: SceneStudy) -> Table:
    """Lift and rms errors of a cam's follower."""
    head = ["engine", "preset", "lift error / lift", "velocity error / (ω L), rms", "acceleration error / (ω² L), rms"]
    rows = [
        (
            *name_of(r),
            numbers.measured(r.lift_error),
            *(_largest(r, q, "rms") for q in ("velocity", "acceleration")),
        )
        for r in dynamic(study)
        if r.errors is not None
    ]
    return table(head, rows)
