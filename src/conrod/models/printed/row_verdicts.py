"""Verdicts on the rows of one quantity: by the exact value, a slip of the whole column, or the angle's rounding."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.models.printed.column_slips import column_causes
from conrod.models.printed.exact_ranges import angle_roundings, exact_ranges, exact_values, nearest_in_rounding
from conrod.models.printed.fixed_slips import CAUSES, fixed_causes
from conrod.models.printed.rows import PrintedRow
from conrod.models.printed.verdicts import ACCEPTED_KINDS, PrintedVerdict, VerdictKind

NOISE_DIGITS = 8  # after the last printed digit, beyond which a double's value says nothing


def check_span(rows: Sequence[PrintedRow]) -> None:
    """Refuse angles of a group that its machine is not driven through.

    Raises:
        InvalidInput: names the row, its angle and the machine's span.
    """
    exact = exact_values(rows, np.radians([row.degrees for row in rows]))
    for k in np.flatnonzero(np.isnan(exact))[:1]:
        first, last = np.degrees(rows[k].scene.mechanism().driver.span or (0.0, 0.0))
        driven = f"{rows[k].fields['scene']} is driven from {first:g} to {last:g} deg"
        raise InvalidInput(f"row {rows[k].line}: angle_deg = {rows[k].degrees:g}: {driven}")


def verdicts_on(
    document: str, rows: Sequence[PrintedRow], speed: tuple[str, float] | None = None
) -> Iterator[PrintedVerdict]:
    """Judge the rows of a group, which `check_span` has passed.

    Args:
        speed: another speed that reproduces the rows of the machine, in words, and its ratio to the right one.
    """
    exact = exact_values(rows, np.radians([row.degrees for row in rows]))
    fixed = fixed_causes(rows, exact)
    # A slip of one size needs no fit: where one reproduces the column, no other is looked for.
    found = {} if fixed else column_causes(rows, exact_ranges(rows), speed)
    # Several that reproduce it equally are no cause: which of them it was cannot be told.
    doubt = f"; reproduced equally by {' and by '.join(found)}, so that no cause is named" if len(found) > 1 else ""
    for k, row in enumerate(rows):
        ways = {text: float(values[k]) for text, values in fixed.items()}
        if len(found) == 1:
            ways |= {text: _nearest_value(row, ranges[:, k]) for text, ranges in found.items()}
        yield _verdict(document, row, float(exact[k]), ways, float(angle_roundings(rows)[k]), doubt)


def _nearest_value(row: PrintedRow, bounds: Array) -> float:
    """The value within bounds (2,) that is nearest to a printed value, without rounding noise."""
    return round(float(np.clip(row.number.value, *bounds)), row.number.decimals + NOISE_DIGITS) + 0.0


def _given_words(value: float) -> str:
    """Describe the value that a slip of most rows would give in a row that it does not explain."""
    return "has none for it" if math.isnan(value) else f"gives {value:.7g} here"


def _verdict(
    document: str, row: PrintedRow, exact: float, made: Mapping[str, float], rounding: float, doubt: str
) -> PrintedVerdict:
    """The most lenient verdict that the exact value, or a systematic slip of the whole column, supports.

    Args:
        made: value that each slip gives, which reproduces the column as a whole.
        rounding: largest difference of the angle from the printed one [deg].
        doubt: said of a print that nothing explains.
    """
    fields, number, kind, why = (
        row.fields,
        row.number,
        VerdictKind.NOT_REPRODUCIBLE,
        f"exact motion of {row.fields['scene']}",
    )
    cause = next((text for text, value in made.items() if number.is_rounding_of(value)), None)
    if number.is_rounding_of(exact):
        kind, cause = VerdictKind.AGREES, None
    elif cause in CAUSES:
        kind = VerdictKind.EXPLAINED
    elif number.is_truncation_of(exact):
        kind, cause = VerdictKind.AFTER_ROUNDING, None
    elif cause:
        kind = VerdictKind.WRONG_STEP
    elif nearest := nearest_in_rounding(row, rounding):
        kind = VerdictKind.AFTER_ROUNDING
        why += f"; it is {nearest[1]:.7g} at {nearest[0]:.7g} deg, which is printed as {row.condition}"
    else:
        why += doubt or "".join(f"; left over by {text}, which {_given_words(value)}" for text, value in made.items())
    reason = f"{cause} gives {made[cause]:.7g}; {why}" if cause else why
    if kind is VerdictKind.AFTER_ROUNDING and number.is_truncation_of(exact):
        reason += "; further digits are cut off instead of rounded"
    return PrintedVerdict(
        document, fields.get("place", ""), row.line, fields["quantity"], row.condition, fields["unit"],
        number.text, exact, (number.value - exact) / number.last, kind, reason,
        should_be=None if kind in ACCEPTED_KINDS else number.format_like(exact), cause=cause,
    )  # fmt: skip
