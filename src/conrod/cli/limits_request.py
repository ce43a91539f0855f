"""Request of `conrod limits`, from the words that were typed."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity
from conrod.studies.limits.axes import AXES, LENGTH_AXIS, Axis, Scale, measure_of
from conrod.studies.limits.plan import ITEMS, REVOLUTIONS, Request

SEPARATOR = ".."
MOST_REVOLUTIONS = 1e6


def request_of(names: Sequence[str], span: str | None, revolutions: float | None) -> Request:
    """Return the request; everything where nothing is named.

    Raises:
        InvalidInput: an unknown axis, a range that is none, is empty, or is for no single axis, or a number of
            revolutions that is out of range or for no run.
    """
    if revolutions is not None:
        check_number("--revolutions", revolutions, 1.0, MOST_REVOLUTIONS)
        if names and LENGTH_AXIS not in names:
            raise InvalidInput(f"--revolutions {revolutions:.15g} is for --axis {LENGTH_AXIS}, which is not asked for")
        if names and span is not None:
            raise InvalidInput(
                f"--revolutions {revolutions:.15g} and --range {span} both say how long a run is: give one"
            )
    for name in names:
        if name not in ITEMS:
            raise unknown_choice("axis", name, ITEMS)
    chosen = tuple(dict.fromkeys(names))
    length = REVOLUTIONS if revolutions is None else float(revolutions)
    return Request(chosen, None if span is None else _span(span, chosen), length)


def _span(text: str, names: Sequence[str]) -> tuple[float, float]:
    if len(names) != 1 or names[0] not in AXES:
        raise InvalidInput(f"--range {text} needs one --axis to be the range of")
    axis = AXES[names[0]]
    if axis.listed:
        raise InvalidInput(f"--range {text} does not go with {axis.name}: its values are a list, all of which are run")
    example = f"{axis.safe_end:g}{SEPARATOR}{axis.failing_end:g}"
    first, separator, last = text.partition(SEPARATOR)
    if not (separator and first.strip() and last.strip()):
        raise InvalidInput(f"--range {text!r} is no range: give FROM..TO, for instance {example}")
    begin, end = (_end(axis, part) for part in (first, last))
    if begin == end:
        raise InvalidInput(f"--range {text} is empty: give two different ends, for instance {example}")
    # Whichever way it was typed, a walk begins at the safe end.
    safe, failing = sorted((begin, end), key=lambda value: _distance(axis, value))
    return safe, failing


def _end(axis: Axis, text: str) -> float:
    value = parse_quantity("--range", text, "")
    check_number(f"--range of {axis.name}", value, *axis.allowed)
    if axis.scale is Scale.COUNT and value != round(value):
        raise InvalidInput(f"--range of {axis.name}: {value:g} is not a whole number")
    return value


def _distance(axis: Axis, value: float) -> float:
    return abs(measure_of(axis.scale, value) - measure_of(axis.scale, axis.safe_end))
