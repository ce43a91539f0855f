"""Columns of a table by what they hold, with their units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from conrod.errors import InvalidInput, named_values, unknown_choice
from conrod.own.tables.headings import DIMENSIONS, TIME, Target, factor, is_unit, meant_by, parted, targets

LISTED = 20  # headings of a table that an error names
# Columns with these units speak of the same thing: in one table either all of them name their unit or none.
KINDS = (("m", "m/s", "m/s^2"), ("rad", "rad/s", "rad/s^2"))


@dataclass(frozen=True)
class Request:
    """Columns and units that a user names.

    Attributes:
        columns: heading by quantity, from `--column C.x=px`.
        units: for columns that name none, from `--unit mm`.
    """

    columns: Mapping[str, str]
    units: tuple[str, ...]


@dataclass(frozen=True)
class Column:
    """A column that is used.

    Attributes:
        target: what it is.
        index: its place in the table, from 0.
        heading: as in the table.
        unit: in words.
        factor: to SI.
        unit_from: source of the unit: heading, --unit, or assumed.
    """

    target: Target
    index: int
    heading: str
    unit: str
    factor: float
    unit_from: str


def request(columns: Sequence[str], units: Sequence[str], points: Sequence[str]) -> Request:
    """The columns and units of `--column` and `--unit`.

    Raises:
        InvalidInput: something that is no quantity of the scene, or no unit.
    """
    known = {target.name: target for target in targets(points)}
    named = named_values(columns, "--column", "QUANTITY=..., e.g. --column time=t", "quantity", known)
    for unit in units:
        if not is_unit(unit):
            raise InvalidInput(f"--unit {unit}: it is no unit of {', '.join(DIMENSIONS.values())}; give e.g. mm or deg")
    return Request(named, tuple(units))


def choose(headings: Sequence[str], points: Sequence[str], asked: Request) -> list[Column]:
    """The columns of a table that are used, in the order of `targets`.

    Args:
        headings: of all columns, with their units where they have any.
        points: names of the scene's observed points.

    Raises:
        InvalidInput: a column that is missing, may be several things, or whose unit cannot be determined.
    """
    known = targets(points)
    places = _places(headings, known, asked)
    missing = () if places.keys() - {TIME} else (f"any of {', '.join(points)} or the crank", f"{points[0]}.x")
    missing = missing if TIME in places else ("the time", TIME)
    if missing:
        raise InvalidInput(
            f"no column for {missing[0]} among {', '.join(map(repr, filter(None, headings[:LISTED])))}; "
            f"say which it is, by its name or its number from 1, with --column {missing[1]}=..."
        )
    found = [(target, place, headings[place]) for target in known if (place := places.get(target.name)) is not None]
    columns = [column_of(target, place, heading, parted(heading)[1], asked) for target, place, heading in found]
    _check_units(columns)
    return columns


def _places(headings: Sequence[str], known: Sequence[Target], asked: Request) -> dict[str, int]:
    """Place of the column of each quantity that the table has."""
    places = {name: _place_of(wanted, name, headings) for name, wanted in asked.columns.items()}
    free = [target for target in known if target.name not in places]
    for place, heading in enumerate(headings):
        found = meant_by(parted(heading)[0], free)
        if found is None or place in places.values():
            continue
        if found.name in places:
            raise InvalidInput(
                f"columns {headings[places[found.name]]!r} and {heading!r} may both be {found.name}: say which with "
                f"--column {found.name}=..."
            )
        places[found.name] = place
    return places


def _place_of(wanted: str, quantity: str, headings: Sequence[str]) -> int:
    """The column that a user named: by its heading, by the name in that, or by its number from 1."""
    for names in ([heading.strip() for heading in headings], [parted(heading)[0] for heading in headings]):
        if (count := names.count(wanted)) > 1:
            raise InvalidInput(f"--column {quantity}={wanted}: the table has {count} columns of that name")
        if count:
            return names.index(wanted)
    if wanted.isdecimal() and 1 <= int(wanted) <= len(headings):
        return int(wanted) - 1
    raise unknown_choice(f"column in --column {quantity}=", wanted, dict.fromkeys(filter(None, headings[:LISTED])))


# -- units -----------------------------------------------------------------------------------------------------------


def column_of(target: Target, place: int, heading: str, stated: str, asked: Request) -> Column:
    """A column with its unit: that which is stated, or else a named one that fits.

    Args:
        stated: its unit by the heading or another account, empty for none.

    Raises:
        InvalidInput: the unit is none of what the column holds.
    """
    # Whose lengths are in mm, its velocities are in mm/s.
    ways = [way for unit in asked.units for way in (unit, f"{unit}/s", f"{unit}/s^2")]
    general = next((way for way in ways if factor(way, target.unit) is not None), "")
    unit, source = (stated, "heading") if stated else (general, "--unit") if general else (target.unit, "assumed")
    if (scale := factor(unit, target.unit)) is None:
        raise InvalidInput(f"column {heading!r}: {unit!r} is no unit of {DIMENSIONS[target.unit]}")
    return Column(target, place, heading, unit, scale, source)


def _check_units(columns: Sequence[Column]) -> None:
    """Refuse a table in which one length has a unit and another has none: both guesses may be a factor 1000 off."""
    for kind in KINDS:
        of_kind = [column for column in columns if column.target.unit in kind]
        without = [column for column in of_kind if column.unit_from == "assumed"]
        stated = [column for column in of_kind if column.unit_from != "assumed"]
        if without and stated:
            one, other = without[0].target, stated[0]
            raise InvalidInput(
                f"mixed units: {one.name} has no unit, {other.target.name} is in {other.unit}; say with "
                "--unit what it is in"
            )
