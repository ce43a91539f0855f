"""Columns of a table by what they hold, and their units: from headings as "C.x [mm]", "time (s)", "x_C"."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from conrod.errors import InvalidInput, as_mapping, unknown_choice
from conrod.exact.link_rotations import ROTATION_COLUMNS, ROTATION_UNITS
from conrod.mechanism.units import parse_quantity

TIME, CRANK_ANGLE, CRANK_SPEED, CRANK_ACCELERATION = "time", "crank_angle", "crank_speed", "crank_acceleration"
CRANK = {CRANK_ANGLE: "rad", CRANK_SPEED: "rad/s", CRANK_ACCELERATION: "rad/s^2"}
OTHER_NAMES = {TIME: "t", CRANK_ANGLE: "theta", CRANK_SPEED: "omega", CRANK_ACCELERATION: "alpha"}
# What else the columns of a link's rotation are called, by the words of conrod's own headings.
ROTATION_WORDS = {
    "angle": ("theta", "phi", "rotation"),
    "omega": ("angular_velocity", "w"),
    "alpha": ("angular_acceleration",),
}
AXES = "xy"
# Quantity -> letter in conrod's own headings, SI unit.
MOTION = {"position": ("", "m"), "velocity": ("v", "m/s"), "acceleration": ("a", "m/s^2")}
# What may stand in a table, and what a user calls it.
DIMENSIONS = {
    "s": "time",
    "m": "length",
    "m/s": "velocity",
    "m/s^2": "acceleration",
    "rad": "angle",
    "rad/s": "angular speed",
    "rad/s^2": "angular acceleration",
    "N*m": "torque",
}
# Columns with these units speak of the same thing: in one table either all of them name their unit or none.
UNIT_FAMILIES = (("m", "m/s", "m/s^2"), ("rad", "rad/s", "rad/s^2"))
FIRST_UNREAD_LETTER = "\u0400"  # Cyrillic and beyond; Latin and Greek letters, which stand for quantities, come before
MAX_LISTED_HEADINGS = 20  # headings of a table that an error names


@dataclass(frozen=True)
class ColumnRequest:
    """Columns and units that a user names.

    Attributes:
        columns: heading by quantity, from `--column C.x=px`.
        units: units for columns that state none, from `--unit mm`.
        links: names of the links whose rotation a table may have.
    """

    columns: Mapping[str, str]
    units: tuple[str, ...]
    links: tuple[str, ...] = ()


@dataclass(frozen=True)
class Column:
    """A column of a table that is used.

    Attributes:
        name: name of the quantity, a key of `quantities`.
        index: its place in the table, from 0.
        heading: heading in the table.
        unit: name of the unit.
        factor: factor from the unit to SI.
        unit_from: source of the unit: heading, --unit, or assumed.
    """

    name: str
    index: int
    heading: str
    unit: str
    factor: float
    unit_from: str


def quantities(points: Sequence[str], links: Sequence[str] = ()) -> dict[str, str]:
    """SI unit of each quantity that a table of points and links may hold, as `C.x`, `crank_angle`, `omega_rod`."""
    own = {f"{p}.{letter}{axis}": unit for p in points for letter, unit in MOTION.values() for axis in AXES}
    turning = {rotation_column(q, link): unit for link in links for q, unit in ROTATION_UNITS.items()}
    return {TIME: "s", **CRANK, **own, **turning}


def rotation_column(quantity: str, link: str) -> str:
    """Name of the column of a quantity of a link's rotation, as `angle_rod`, `omega_rod`, `alpha_rod`."""
    return f"{ROTATION_COLUMNS[quantity]}_{link}"


def column_request(
    columns: Mapping[str, str], units: Sequence[str], points: Sequence[str], links: Sequence[str] = ()
) -> ColumnRequest:
    """Check the columns that a user names by quantity, and the units of columns without one.

    Raises:
        InvalidInput: something that is no quantity of the scene, or no unit.
    """
    known = quantities(points, links)
    columns = as_mapping("columns", columns, "{'C.x': 'px'}")
    for name in columns:
        if name not in known:
            raise unknown_choice("quantity", name, known)
    for unit in units:
        if not is_unit(unit):
            raise InvalidInput(f"--unit {unit}: it is no unit of {', '.join(DIMENSIONS.values())}; give e.g. mm or deg")
    return ColumnRequest(columns, tuple(units), tuple(links))


def choose_columns(headings: Sequence[str], points: Sequence[str], request: ColumnRequest) -> list[Column]:
    """Choose the columns of a table that are used, in the order of `quantities`.

    Args:
        headings: headings of all columns, with their units where they have any.
        points: names of the scene's observed points.

    Raises:
        InvalidInput: a column that is missing, may be several things, or whose unit cannot be determined.
    """
    places, known = _match_columns(headings, points, request), quantities(points, request.links)
    missing = () if places.keys() - {TIME} else (f"any of {', '.join(points)} or the crank", f"{points[0]}.x")
    missing = missing if TIME in places else ("the time", TIME)
    if missing:
        raise InvalidInput(
            f"no column for {missing[0]} among {', '.join(map(repr, filter(None, headings[:MAX_LISTED_HEADINGS])))}; "
            f"say which it is, by its name or its number from 1, with --column {missing[1]}=..."
        )
    columns = [
        column_with_unit(
            name, dimension, places[name], headings[places[name]], split_heading(headings[places[name]])[1], request
        )
        for name, dimension in known.items()
        if name in places
    ]
    # Of a length that has a unit and one that has none either guess may be a factor 1000 off.
    for kind in UNIT_FAMILIES:
        units = {column.name: column for column in columns if known[column.name] in kind}
        without = [name for name, column in units.items() if column.unit_from == "assumed"]
        if without and (stated := [name for name in units if name not in without]):
            raise InvalidInput(
                f"mixed units: {without[0]} has no unit, {stated[0]} is in {units[stated[0]].unit}; say with --unit "
                "what it is in"
            )
    return columns


def _match_columns(headings: Sequence[str], points: Sequence[str], request: ColumnRequest) -> dict[str, int]:
    """Index of the column of each quantity that the table has."""
    places = {name: _find_column(wanted, name, headings) for name, wanted in request.columns.items()}
    free = [name for name in quantities(points, request.links) if name not in places]
    for place, heading in enumerate(headings):
        # Words of other alphabets, which are not read, may say that x is a velocity; t is always the time.
        name = quantity_named(split_heading(heading)[0], free, points) or quantity_named(
            _latin_words(heading), {TIME} & set(free), points
        )
        if name is None or place in places.values():
            continue
        if name in places:
            raise InvalidInput(
                f"columns {headings[places[name]]!r} and {heading!r} may both be {name}: say which with "
                f"--column {name}=..."
            )
        places[name] = place
    return places


def _find_column(wanted: str, quantity: str, headings: Sequence[str]) -> int:
    """Index of a column that a user named by its heading, by the name in it, or by its number from 1."""
    for names in ([heading.strip() for heading in headings], [split_heading(heading)[0] for heading in headings]):
        if (count := names.count(wanted)) > 1:
            raise InvalidInput(f"--column {quantity}={wanted}: the table has {count} columns of that name")
        if count:
            return names.index(wanted)
    if wanted.isdecimal() and 1 <= int(wanted) <= len(headings):
        return int(wanted) - 1
    raise unknown_choice(
        f"column in --column {quantity}=", wanted, dict.fromkeys(filter(None, headings[:MAX_LISTED_HEADINGS]))
    )


def quantity_named(heading: str, among: Collection[str], points: Sequence[str]) -> str | None:
    """The only quantity that a heading can name; None if it names none, or may name several.

    Upper and lower case tell things apart before they are taken for the same: `Ax` is x of a point A, `ax` an
    acceleration. The only point needs no name.
    """
    if heading in among:
        return heading
    for way in (str, str.casefold):
        found = [name for name in among if way(_letters(heading)) in map(way, _spellings(name, len(points) == 1))]
        if found:
            return found[0] if len(found) == 1 else None
    return None


def _spellings(name: str, is_only: bool) -> list[str]:
    """Names, without signs, by which a heading may call a quantity."""
    point, _, component = name.rpartition(".")
    if point:
        others = [f"{component}{_letters(point)}", *([component] if is_only else [])]
    elif name in OTHER_NAMES:
        others = [OTHER_NAMES[name]]
    else:
        letter, _, link = name.partition("_")
        others = [_letters(f"{link}{letter}"), *(_letters(f"{word}{link}") for word in ROTATION_WORDS[letter])]
    return [_letters(name), *others]


def _latin_words(heading: str) -> str:
    """Words of a heading next to words of other alphabets, as t in `时间 t`; empty if all are alike."""
    words = re.findall(r"\w+", split_heading(heading)[0])
    symbols = [word for word in words if not all(letter >= FIRST_UNREAD_LETTER for letter in word)]
    return " ".join(symbols) if len(symbols) < len(words) else ""


def _letters(name: str) -> str:
    """A name without signs and blanks."""
    return re.sub(r"[\W_]+", "", name)


# -- units -----------------------------------------------------------------------------------------------------------

# What begins with a digit is no unit but an index: r_0[1].
HEADING_WITH_UNIT = re.compile(r"(?P<name>.*\S)\s*[\[(]\s*(?P<unit>[^\])\d\s][^\])]*)[\])]\s*")
NO_UNIT = ("", "-", "1")
# Brackets as Chinese and Japanese texts have them.
FULL_WIDTH = str.maketrans("\uff08\uff09\uff3b\uff3d", "()[]")


def split_heading(heading: str) -> tuple[str, str]:
    """Split a heading into its name and the unit in brackets after it, empty if it has none."""
    found = HEADING_WITH_UNIT.fullmatch(" ".join(heading.translate(FULL_WIDTH).split()))
    return (found["name"], found["unit"].strip()) if found else (heading.strip(), "")


def bare_unit(cell: str) -> str | None:
    """The unit in a cell of a row of units, with or without brackets; empty for none, None if it is no unit."""
    text = cell.strip().strip("[]()").strip()
    return "" if text in NO_UNIT else text if is_unit(text) else None


def is_unit(text: str) -> bool:
    """True if a text is a unit of any quantity that a table may hold."""
    return any(factor_to_si(text, dimension) is not None for dimension in DIMENSIONS)


@cache
def factor_to_si(unit: str, dimension: str) -> float | None:
    """Factor from a unit to SI; None where it is no unit of the dimension, which is a key of `DIMENSIONS`."""
    try:
        return parse_quantity("unit", f"1 {unit.replace('°', 'deg')}", dimension) if unit.strip() else None
    except InvalidInput:
        return None


def column_with_unit(
    name: str, dimension: str, place: int, heading: str, stated: str, request: ColumnRequest
) -> Column:
    """Build a column with the unit that is stated or, without one, with a unit that the user gave.

    Args:
        dimension: SI unit of the column's quantity.
        stated: its unit by the heading or another account, empty for none.

    Raises:
        InvalidInput: the unit does not fit the quantity of the column.
    """
    # Whose lengths are in mm, its velocities are in mm/s.
    ways = [way for unit in request.units for way in (unit, f"{unit}/s", f"{unit}/s^2")]
    general = next((way for way in ways if factor_to_si(way, dimension) is not None), "")
    unit, source = (stated, "heading") if stated else (general, "--unit") if general else (dimension, "assumed")
    if (scale := factor_to_si(unit, dimension)) is None:
        raise InvalidInput(f"column {heading!r}: {unit!r} is no unit of {DIMENSIONS[dimension]}")
    return Column(name, place, heading, unit, scale, source)
