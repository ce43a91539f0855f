"""What a sweep turned: every knob of each engine and where it stood.

How far a choice of settings carries: chosen on some scenes, tried on the one left out.

What the errors depend on and should not: masses and gravity.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.sweep.naming import tolerance
from conrod.report.tables import table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import COMPLETED, SweepStudy

if TYPE_CHECKING:
    from conrod.studies.recommend.transfer import Transfer
    from conrod.studies.sweep.sensitivity import Sensitivity, Variation

MEANINGS = {
    "integrator": "how a step is made from forces",
    "stabilisation": "time constant with which an open joint is closed: in seconds, steps h or shares of the period T",
    "regularisation": "how far a joint gives way under load: `solimp`, or inverse weights multiplied by a factor",
    "solver": "how the joint forces are solved for",
    "iterations": "passes of that solver, at most",
    "tolerance": "improvement at which the solver stops early",
    "rod": "the connecting rod as a body of its own, or as a distance joint without mass",
    "impedance": "how far a contact gives way under load",
    "vertices": "corners of the cam's polygon, about",
    "error_bias": "share of a joint's error left after a second; 0 mends all of it at each step",
    "slop": "overlap that a contact may keep",
    "bias": "share of a contact's error left after a second; 0 mends all of it at each step",
}


def knobs_table(study: SweepStudy) -> str:
    """Knob, meaning and values, the number of steps among them."""
    rows = []
    for engine in study.engines:
        points = [point for point in study.points if point.engine == engine]
        steps = sorted({point.steps_per_revolution for point in points})
        rows.append([engine_title(engine), "steps per revolution", "length of a step", ", ".join(map(str, steps))])
        for knob in dict.fromkeys(name for point in points for name in point.knobs):
            values = dict.fromkeys(point.knobs[knob] for point in points if knob in point.knobs)
            rows.append([engine_title(engine), f"`{knob}`", MEANINGS.get(knob, ""), ", ".join(values)])
    return table(["engine", "knob", "what it does", "values"], rows)


def size_of_grid(study: SweepStudy) -> str:
    """How many settings and runs, in a sentence."""
    parts = []
    for engine in study.engines:
        points = [point for point in study.points if point.engine == engine]
        completed = sum(point.completed for point in points)
        rules = len({point.rule for point in points})
        parts.append(f"{engine_title(engine)} {rules} settings in {len(points)} runs, of which {completed} completed")
    return f"The grid `{study.grid}`: " + "; ".join(parts) + "."


def transfers_table(transfers: Sequence[Transfer]) -> str:
    """A row for each scene left out, engine and tolerance."""
    rows = [
        [
            found.left_out,
            engine_title(found.engine),
            f"{found.quantity} {tolerance(found.allowed)}",
            found.rule,
            str(found.steps_per_revolution),
            "; ".join(f"{scene} {numbers.measured(error)}" for scene, error in found.errors.items()),
            "did not complete" if found.error is None else numbers.measured(found.error),
            "yes" if found.held else "**no**",
            numbers.MISSING if found.best is None or not found.held else numbers.measured(1.0 / found.best),
        ]
        for found in transfers
    ]
    head = ["left out", "engine", "within", "cheapest settings of the others", "steps per revolution"]
    return table([*head, "errors there", "error on the one left out", "held", "cost over its own cheapest"], rows)


def transfers_sentence(transfers: Sequence[Transfer]) -> str:
    """How many held; nothing where none was tried."""
    if not transfers:
        return ""
    held = sum(found.held for found in transfers)
    return (
        f"Of {len(transfers)} settings that were the cheapest within a tolerance on all scenes but one, {held} kept "
        "that tolerance on the scene left out. (Scenes of one kind differ in speed alone.)"
    )


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
