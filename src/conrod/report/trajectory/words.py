"""What is said of a judged table, on the console and on its page: mm and degrees, two digits for what was measured."""

from __future__ import annotations

import math

from conrod.own.tables.error_hypotheses import Cause
from conrod.own.tables.estimation import Estimation
from conrod.own.tables.study import TableStudy
from conrod.report import numbers

SHOWN = {"s": ("ms", 1e3), "rad": ("deg", 180.0 / math.pi), "m": ("mm", 1e3)}
LEAST_DIGITS, MOST_DIGITS = 2, 10
# Below a part in so many of its unit an estimate is rounding.
ROUNDING = 1e-13


def summary_line(study: TableStudy) -> str:
    """What the table is, in a line."""
    first, last = (f"{t:.6g}" for t in study.span)
    turns = f"{study.revolutions:.4g} revolution{'' if study.revolutions == 1.0 else 's'}"
    return f"{study.file}: {study.rows} rows, {first} to {last} s, {turns} of {study.scene_name} ({study.form})"


def figure_line(study: TableStudy) -> str:
    """The one figure that counts."""
    turns = f"{study.revolutions:.4g} revolution{'' if study.revolutions == 1.0 else 's'}"
    return f"largest position error / L over {turns}: {numbers.measured(study.largest('total'))}"


def verdict_text(study: TableStudy) -> str:
    """The verdict, with what is out of tolerance."""
    if study.passed is None:
        return "measured, not judged: give --tolerance"
    if study.passed:
        judged = ", ".join(f"{name} {_found(study, name)} <= {limit:g}" for name, limit in study.tolerance.items())
        return f"within tolerance: {judged}"
    missed = ", ".join(
        f"{name} {numbers.measured(found)} > {limit:g}" for name, (found, limit) in study.exceeded.items()
    )
    return f"OUT OF TOLERANCE: {missed}"


def _found(study: TableStudy, name: str) -> str:
    return numbers.measured(study.largest(name))


def estimate_rows(estimation: Estimation) -> list[tuple[str, str, str, str, str]]:
    """Rows of a table: what, value, standard error, unit, meaning. A value has the digits that its error leaves it."""
    rows = []
    for one in estimation.estimates:
        unit, factor = SHOWN[one.unit]
        value, error = one.value * factor, one.error * factor
        rows.append((one.name, _with_digits(value, error), numbers.measured(error), unit, one.meaning))
    return rows


def _with_digits(value: float, error: float) -> str:
    if abs(value) < ROUNDING:
        return numbers.measured(value)
    digits = LEAST_DIGITS + math.ceil(math.log10(abs(value) / error)) if 0.0 < error < abs(value) else LEAST_DIGITS
    return f"{value:.{min(digits, MOST_DIGITS) if error else MOST_DIGITS}g}"


def sense_text(sense: tuple[int, float, float]) -> str:
    """The sense of rotation, with what each leaves."""
    value, left, opposite = sense
    name = "the scene's" if value > 0 else "opposite to the scene's"
    return (
        f"sense of rotation: {name} (leaves {numbers.measured(left)} rms, the other one {numbers.measured(opposite)})"
    )


def remaining_text(study: TableStudy) -> str:
    """What is left after the estimate."""
    assert study.estimation is not None
    unit = "of L" if study.errors else "rad"
    return f"what is left after it: {numbers.measured(study.estimation.remaining)} {unit} rms"


def explained(cause: Cause) -> str:
    """What a cause explains, in words."""
    return ", ".join(
        f"{name} is {numbers.measured(after)} instead of {numbers.measured(before)}"
        for name, (before, after) in cause.explains.items()
    )
