"""What a user of `conrod limits` asked for, from the words that were typed."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity
from conrod.studies.limits.axes import AXES, LENGTH_AXIS
from conrod.studies.limits.axis import Axis, Scale, measure_of
from conrod.studies.limits.maps import PAIRS
from conrod.studies.limits.parts import PARTS
from conrod.studies.limits.plan import REVOLUTIONS, Request

SEPARATOR = ".."
MOST_REVOLUTIONS = 1e6


def request_of(names: Sequence[str], span: str | None, revolutions: float | None) -> Request:
    """The request; everything where nothing is named.

    Raises:
        InvalidInput: an unknown axis, a range that is none, is empty, or is for no single axis, or a number of
            revolutions that is out of range or for no run.
    """
    if revolutions is not None:
        _check_revolutions(revolutions, names, span)
    length = REVOLUTIONS if revolutions is None else float(revolutions)
    if not names:
        if span is not None:
            raise InvalidInput(f"--range {span} needs one --axis to be the range of")
        return Request(revolutions=length)
    pairs = {pair.name: pair for pair in PAIRS}
    for name in names:
        if name not in AXES and name not in pairs and name not in PARTS:
            raise unknown_choice("axis", name, [*AXES, *pairs, *PARTS])
    axes = tuple(AXES[name] for name in dict.fromkeys(names) if name in AXES)
    mapped = tuple(pairs[name] for name in dict.fromkeys(names) if name in pairs)
    parts = tuple(PARTS[name] for name in dict.fromkeys(names) if name in PARTS)
    return Request(axes, mapped, _span(span, axes, (*mapped, *parts)), length, parts)


def _check_revolutions(revolutions: float, names: Sequence[str], span: str | None) -> None:
    check_number("--revolutions", revolutions, 1.0, MOST_REVOLUTIONS)
    if names and LENGTH_AXIS not in names:
        raise InvalidInput(f"--revolutions {revolutions:.15g} is for --axis {LENGTH_AXIS}, which is not asked for")
    if names and span is not None:
        raise InvalidInput(f"--revolutions {revolutions:.15g} and --range {span} both say how long a run is: give one")


def _span(text: str | None, axes: Sequence[Axis], pairs: Sequence[object]) -> tuple[float, float] | None:
    if text is None:
        return None
    if len(axes) != 1 or pairs:
        raise InvalidInput(f"--range {text} needs one --axis to be the range of")
    axis = axes[0]
    if axis.scale is Scale.LISTED:
        raise InvalidInput(f"--range {text} does not go with {axis.name}: its values are a list, all of which are run")
    first, separator, last = text.partition(SEPARATOR)
    if not (separator and first.strip() and last.strip()):
        raise InvalidInput(f"--range {text!r} is no range: give FROM..TO, for instance {_example(axis)}")
    ends = tuple(parse_quantity("--range", part, "") for part in (first, last))
    for value in ends:
        check_number(f"--range of {axis.name}", value, *axis.allowed)
        if axis.scale is Scale.COUNT and value != round(value):
            raise InvalidInput(f"--range of {axis.name}: {value:g} is not a whole number")
    if ends[0] == ends[1]:
        raise InvalidInput(f"--range {text} is empty: give two different ends, for instance {_example(axis)}")
    # Whichever way it was typed, a walk begins at the harmless end.
    first_value, last_value = sorted(ends, key=lambda value: _harm(axis, value))
    return first_value, last_value


def _harm(axis: Axis, value: float) -> float:
    return abs(measure_of(axis.scale, value) - measure_of(axis.scale, axis.harmless))


def _example(axis: Axis) -> str:
    return f"{axis.harmless:g}{SEPARATOR}{axis.hopeless:g}"
