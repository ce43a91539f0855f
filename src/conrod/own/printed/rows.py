"""Rows of a user's table of printed values: read from CSV, each tied to a machine.

The format is described in docs/audit.md. Nothing in a table is executed; a path in one cannot lead out of its folder.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache

import numpy as np

from conrod.errors import InvalidInput, named_values, unknown_choice
from conrod.exact.motion import BREAK_WIDTH, Array
from conrod.mechanism.units import check_number, parse_quantity
from conrod.own.printed.judging import DIGITS, Item, Number
from conrod.scenes import Scene

NEEDED = ("scene", "quantity", "angle_deg", "printed", "unit")
OPTIONAL = ("parameters", "document", "table", "row", "equation", "place", "line")
COLUMNS = (*NEEDED, *OPTIONAL)
UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s^2", "jerk": "m/s^3"}
AXES = ("x", "y", "size")
MINUS = "\u2212"  # as typeset text has it
LARGEST_TABLE = 10_000  # rows
LARGEST_ANGLE = 36_000.0  # [deg], a hundred turns
# A line at the top, "# scene: shear-press", gives a column's value for rows that have none of their own.
SETTING = re.compile(r"#\s*([a-z_]+)\s*:(.*)")


@dataclass(frozen=True)
class Row:
    """One printed value with what it is of.

    Attributes:
        number: of its line in the file.
        factor: turns SI into the printed unit.
        exact: the exact value at its angle, in the printed unit.
    """

    number: int
    item: Item
    scene: Scene
    point: str
    derivative: str
    axis: str
    degrees: float
    factor: float
    exact: float = math.nan

    @property
    def machine(self) -> tuple[str, str]:
        """Name and parameters of the machine."""
        return self.item.mechanism, self.scene.parameters_text

    @property
    def group(self) -> tuple[object, ...]:
        """Properties that rows share of which one cause can be behind all."""
        return (self.machine, self.point, self.derivative, self.axis, self.item.unit)


def values(rows: Sequence[Row], angles: Array) -> Array:
    """Exact values (N,) of a quantity at crank angles (N,) [rad], in the printed unit; NaN where it is not reached.

    Args:
        rows: N of one group.
    """
    scene, axis, found = rows[0].scene, rows[0].axis, np.full(len(rows), np.nan)
    low, high = scene.mechanism().driver.span or (-np.inf, np.inf)
    there = (angles >= low - BREAK_WIDTH) & (angles <= high + BREAK_WIDTH)
    if there.any():
        vectors = getattr(scene.motion(angles[there], scene.speed).point(rows[0].point), rows[0].derivative)
        found[there] = np.hypot(*vectors.T) if axis == "size" else vectors[:, AXES.index(axis)]
    return np.asarray(found * np.array([row.factor for row in rows]))


def grouped(rows: Sequence[Row], key: Callable[[Row], tuple[object, ...]]) -> list[list[Row]]:
    """Rows that share something, in the order of their first ones."""
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return list(groups.values())


def read_rows(name: str, text: str, scene_of: Callable[[str], Scene]) -> list[Row]:
    """All rows of a table.

    Args:
        name: what the table is called in errors.
        scene_of: finds the machine that a row names.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row, the field and what is wanted.
    """
    try:
        rows = list(_rows(name, text.lstrip("\ufeff").splitlines(), cache(scene_of)))
        if not rows:
            raise InvalidInput("no rows below the heading")
        return sorted(
            (row for group in grouped(rows, lambda row: row.group) for row in _solved(group)),
            key=lambda row: row.number,
        )
    except csv.Error as error:
        raise InvalidInput(f"{name}: not a table in CSV ({error})") from None
    except InvalidInput as error:
        raise InvalidInput(f"{name}: {error}") from None


def _rows(name: str, lines: Sequence[str], scene_of: Callable[[str], Scene]) -> Iterator[Row]:
    settings, first = _settings(lines)
    for count, (number, fields) in enumerate(_fields(lines, first, settings)):
        if count == LARGEST_TABLE:
            raise InvalidInput(f"more than {LARGEST_TABLE} rows")
        try:
            yield _row(name, number, fields, scene_of)
        except InvalidInput as error:
            raise InvalidInput(f"row {number}: {error}") from None


def _solved(group: Sequence[Row]) -> Iterator[Row]:
    """Rows of one group with their exact values, all worked out together."""
    for row, exact in zip(group, values(group, np.radians([row.degrees for row in group])), strict=True):
        if math.isnan(exact):
            first, last = np.degrees(row.scene.mechanism().driver.span or (0.0, 0.0))
            given = f"row {row.number}: angle_deg = {row.degrees:g}"
            raise InvalidInput(f"{given}: {row.item.mechanism} is driven from {first:g} to {last:g} deg")
        yield replace(row, exact=float(exact))


def _settings(lines: Sequence[str]) -> tuple[dict[str, str], int]:
    """Values for all rows from the lines at the top that begin with #, and how many lines those are."""
    settings: dict[str, str] = {}
    for count, line in enumerate(lines):
        if not line.startswith("#") and line.strip():
            return settings, count
        if found := SETTING.fullmatch(line.strip()):
            if found.group(1) not in COLUMNS:
                raise InvalidInput(f"row {count + 1}: {unknown_choice('column', found.group(1), COLUMNS)}")
            settings[found.group(1)] = found.group(2).strip()
    return settings, len(lines)


def _fields(lines: Sequence[str], first: int, settings: Mapping[str, str]) -> Iterator[tuple[int, dict[str, str]]]:
    """Number of the line and values by column of each row that is not empty."""
    # Where decimals have the comma, fields are apart by semicolons or tabs.
    heading = lines[first] if first < len(lines) else ""
    reader = csv.DictReader(lines[first:], delimiter=max(",;\t", key=heading.count))
    names = reader.fieldnames or ()
    for column in names:
        # A remark of one's own may have a column; a slip of the pen in a name would be passed over in silence.
        if column not in COLUMNS and get_close_matches(column.casefold(), COLUMNS):
            raise unknown_choice("column", column, COLUMNS)
        if list(names).count(column) > 1:
            raise InvalidInput(f"column {column!r} stands there twice")
    for column in NEEDED:
        if column not in names and column not in settings:
            raise InvalidInput(
                f"no column {column!r}; give {', '.join(NEEDED)} (and {', '.join(OPTIONAL)}), as a column or in a line "
                f"'# {column}: value' above the heading"
            )
    for fields in reader:
        number = first + reader.line_num
        if None in fields:
            raise InvalidInput(f"row {number}: more fields than the heading; put one with a comma in quotes")
        own = {column: (value or "").strip() for column, value in fields.items()}
        yield number, own | {column: value for column, value in settings.items() if not own.get(column)}


def _row(name: str, number: int, fields: Mapping[str, str], scene_of: Callable[[str], Scene]) -> Row:
    for column in NEEDED:
        if not fields[column]:
            raise InvalidInput(f"{column}: nothing is given")
    scene = _with(scene_of(fields["scene"]), fields.get("parameters", ""))
    point, derivative, axis = _quantity(scene, fields["quantity"])
    angle, unit = fields["angle_deg"], fields["unit"]
    degrees = parse_quantity("angle_deg", angle.replace(",", ".") if DIGITS.fullmatch(angle) else angle, "")
    check_number("angle_deg", degrees, -LARGEST_ANGLE, LARGEST_ANGLE, "deg")
    line = fields.get("line", "") or str(number)
    if not (line.isascii() and line.isdecimal() and len(line) < 10):
        raise InvalidInput(f"line = {line!r} is not a line number")
    named = [f"{column} {fields[column]}" for column in ("table", "row", "equation") if fields.get(column)]
    place = ", ".join(filter(None, [fields.get("place", ""), *named]))
    document, printed = fields.get("document", "") or name, Number(fields["printed"].replace(MINUS, "-"))
    item = Item(document, "", place, int(line), fields["quantity"], f"{degrees:g} deg", printed, unit, fields["scene"])
    return Row(number, item, scene, point, derivative, axis, degrees, _factor(unit, derivative))


@cache
def _factor(unit: str, derivative: str) -> float:
    """Factor from SI to a printed unit."""
    return 1.0 / parse_quantity("unit", f"1 {unit}", UNITS[derivative])


def _with(scene: Scene, text: str) -> Scene:
    """The scene with the parameters of a row, "crank=32.5mm; rod=390mm"."""
    facts = scene.parameter_facts()
    parts = list(filter(None, (part.strip() for part in text.split(";"))))
    texts = named_values(parts, "parameters =", "name=value, several apart by ;", "parameter", facts)
    changed = {name: parse_quantity(name, value, facts[name].unit) for name, value in texts.items()}
    return scene.with_parameters(**changed) if changed else scene


def _quantity(scene: Scene, text: str) -> tuple[str, str, str]:
    """Point, derivative and axis in the words of a row."""
    words = text.split()
    if len(words) != 3:
        raise InvalidInput(
            f"quantity = {text!r}: give a point, {'/'.join(UNITS)} and {'/'.join(AXES)}, like 'G velocity y'"
        )
    known: dict[str, Collection[str]] = {"point": scene.lengths, "quantity": UNITS, "axis": AXES}
    for given, (kind, choices) in zip(words, known.items(), strict=True):
        if given not in choices:
            raise unknown_choice(kind, given, choices)
    point, derivative, axis = words
    return point, derivative, axis
