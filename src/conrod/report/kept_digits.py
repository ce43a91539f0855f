"""Digits of an earlier report that stay where a new measurement says the same.

Processors add up in different orders, so the last kept digit of a rounded number may come out one higher elsewhere. A
report keeps the number that it has while the new one is as close as that: then its files are the same on every machine.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from decimal import Decimal
from typing import Any

from conrod.report.numbers import ROUNDING, round_reproducibly

# Units of the last kept digit by which a new number may differ from the one that is kept: two, and a little more, since
# differences of decimal fractions are rounded.
ROOM = 2.001
NOISE = 1e-13  # of a normalised error, by which another order of summation changes it, however small it is
ALL_DIGITS = 15  # reproducible significant digits of a number of which all are kept
MIN_DRAWN = 8  # numbers in a list from which on its digits are those that its numbers have, as in a curve
Digits = Mapping[str, int | None]
WITNESS = "misfit"  # field with what fits least in a run, wherever that is: noise decides where, while it is allowed


def keep_earlier_digits(before: Any, now: Any, digits: int | None, digits_of: Digits, places: Mapping[str, str]) -> Any:
    """Return new findings with the earlier numbers where both are the same but for their last kept digit.

    Where given values, texts or counts of a mapping differ, it is another run, and all of its numbers are new.

    Args:
        before: rounded earlier findings, as plain values.
        now: new findings as plain values, rounded or not.
        digits, digits_of: significant digits, as `round_findings` takes them; fields with None are given values.
        places: by field, the field of the largest values whose places it has; where these are kept, so are the places.
    """
    if isinstance(now, dict) and isinstance(before, dict):
        return _kept_mapping(before, now, digits, digits_of, places)
    if isinstance(now, list) and isinstance(before, list) and len(now) == len(before):
        if (array := _kept_array(before, now, digits)) is not None:
            return array
        return [keep_earlier_digits(*pair, digits, digits_of, places) for pair in zip(before, now, strict=True)]
    if (
        isinstance(now, float)
        and isinstance(before, float)
        and abs(now - before) <= _largest_kept_difference(before, now, digits)
    ):
        return before
    return now


def _kept_mapping(
    before: Mapping[str, Any], now: Mapping[str, Any], digits: int | None, digits_of: Digits, places: Mapping[str, str]
) -> Any:
    """Return a mapping with the earlier numbers, or as it is if it is of another run."""
    kept = {
        key: keep_earlier_digits(before[key], part, digits_of.get(key, digits), digits_of, places)
        if key in before
        else part
        for key, part in now.items()
    }
    given = [key for key, part in now.items() if digits_of.get(key, 0) is None or isinstance(part, str | int | None)]
    if any(key not in before or kept[key] != before[key] for key in given):
        return now
    for place, largest in places.items():
        if place in kept and place in before and largest in kept:
            kept[place] = _kept_places(before, kept, place, largest)
    if WITNESS in kept and all(key == WITNESS or kept[key] == before.get(key) for key in kept):
        kept[WITNESS] = _kept_witness(before.get(WITNESS), now[WITNESS])
    return kept


def _kept_witness(before: Any, now: Any) -> Any:
    """Return the earlier misfits of a run that is found again; the new misfits if one is out of bounds."""
    if not isinstance(before, dict) or not isinstance(now, dict) or before.keys() != now.keys():
        return now
    within = all(one["difference"] <= one["allowed"] for one in (*before.values(), *now.values()))
    return before if within else now


def _kept_places(before: Mapping[str, Any], kept: Mapping[str, Any], place: str, largest: str) -> Any:
    """Return the places of largest values, the earlier one of each value that is kept."""
    was, now = before[place], kept[place]
    if not isinstance(now, list):
        return was if kept[largest] == before[largest] else now
    columns = (was, now, before[largest], kept[largest])
    if not all(isinstance(one, list) and len(one) == len(now) for one in columns):
        return now
    return [old if was == is_ else new for old, new, was, is_ in zip(*columns, strict=True)]


def _kept_array(before: list[Any], now: list[Any], digits: int | None) -> list[Any] | None:
    """Return the numbers of nested lists, the earlier ones where they are the same; None if these are no array."""
    old, new = _flatten_lists(before), _flatten_lists(now)
    if len(old) != len(new) or not all(isinstance(one, float) for one in (*old, *new)):
        return None
    if digits is not None:
        new = [round_reproducibly(one, digits) for one in new]
    texts = [Decimal(repr(one)).normalize().as_tuple() for one in {*old, *new} if one]
    if len(texts) < MIN_DRAWN:
        return None
    # An array is rounded to significant digits, or to decimals; the coarser of both is the unit of a number.
    significant = max(len(text.digits) for text in texts)
    decimal = 10.0 ** min(int(text.exponent) for text in texts)
    pairs = (
        (was, is_, max(decimal, _unit(max(abs(was), abs(is_)), significant))) for was, is_ in zip(old, new, strict=True)
    )
    noise = 0.0 if digits is None else NOISE
    kept = iter([was if abs(is_ - was) <= max(ROOM * unit, noise) else is_ for was, is_, unit in pairs])
    return _refill_lists(now, kept)


def _flatten_lists(values: Any) -> list[Any]:
    """Return the numbers, or other values, in nested lists, in order."""
    return [leaf for part in values for leaf in _flatten_lists(part)] if isinstance(values, list) else [values]


def _refill_lists(values: list[Any], leaves: Iterator[Any]) -> list[Any]:
    """Return nested lists of the same shape that hold other values."""
    return [_refill_lists(part, leaves) if isinstance(part, list) else next(leaves) for part in values]


def _largest_kept_difference(before: float, now: float, digits: int | None) -> float:
    """Return the largest difference of two numbers that are the same but for their last kept digit."""
    unit = _unit(max(abs(before), abs(now)), ALL_DIGITS if digits is None else digits)
    if digits is None:
        return ROOM * unit
    return max(ROOM * unit, ROUNDING + NOISE if before == 0.0 else NOISE)


def _unit(size: float, digits: int) -> float:
    """Return the size of a number's last significant digit."""
    return 10.0 ** (math.floor(math.log10(size)) - digits + 1) if size > 0.0 else 0.0
