"""Rows of a user's table of printed values: read from CSV, each tied to a machine.

The format is described in docs/audit.md. Nothing in a table is executed; a path in one cannot lead out of its folder.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache

import numpy as np

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import BREAK_WIDTH, Array
from conrod.mechanism.units import check_number, parse_quantity
from conrod.own.printed.printed import DIGITS, Item, Number
from conrod.scenes import Scene

NEEDED = ("scene", "quantity", "angle_deg", "printed", "unit")
OPTIONAL = ("parameters", "document", "table", "row", "equation", "place", "line")
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
    scene = rows[0].scene
    found = np.full(len(rows), np.nan)
    there = np.ones(len(rows), dtype=bool)
    span = scene.mechanism().driver.span
    if span is not None:
        there = (angles >= span[0] - BREAK_WIDTH) & (angles <= span[1] + BREAK_WIDTH)
    if there.any():
        vectors = getattr(scene.motion(angles[there], scene.speed).point(rows[0].point), rows[0].derivative)
        axis = rows[0].axis
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
    lines = text.lstrip("\ufeff").splitlines()
    settings, first = _settings(name, lines)
    known = cache(scene_of)
    rows = []
    try:
        for number, fields in _fields(name, lines, first, settings):
            try:
                rows.append(_row(name, number, fields, known))
            except InvalidInput as error:
                raise InvalidInput(f"{name}, row {number}: {error}") from None
            if len(rows) > LARGEST_TABLE:
                raise InvalidInput(f"{name}: more than {LARGEST_TABLE} rows")
    except csv.Error as error:
        raise InvalidInput(f"{name}: not a table in CSV ({error})") from None
    if not rows:
        raise InvalidInput(f"{name}: no rows below the heading")
    solved = [row for group in grouped(rows, lambda row: row.group) for row in _solved(name, group)]
    return sorted(solved, key=lambda row: row.number)


def _solved(name: str, group: Sequence[Row]) -> Iterator[Row]:
    """Rows of one group with their exact values, all worked out together."""
    for row, exact in zip(group, values(group, np.radians([row.degrees for row in group])), strict=True):
        if math.isnan(exact):
            first, last = np.degrees(row.scene.mechanism().driver.span or (0.0, 0.0))
            raise InvalidInput(
                f"{name}, row {row.number}: angle_deg = {row.degrees:g}: {row.item.mechanism} is driven from {first:g} "
                f"to {last:g} deg"
            )
        yield replace(row, exact=float(exact))


def _settings(name: str, lines: Sequence[str]) -> tuple[dict[str, str], int]:
    """Values for all rows from the lines at the top that begin with #, and how many lines those are."""
    settings: dict[str, str] = {}
    for count, line in enumerate(lines):
        if not line.startswith("#") and line.strip():
            return settings, count
        found = SETTING.fullmatch(line.strip())
        if found:
            column = found.group(1)
            if column not in (*NEEDED, *OPTIONAL):
                given = unknown_choice("column", column, (*NEEDED, *OPTIONAL))
                raise InvalidInput(f"{name}, row {count + 1}: {given}")
            settings[column] = found.group(2).strip()
    return settings, len(lines)


def _fields(
    name: str, lines: Sequence[str], first: int, settings: Mapping[str, str]
) -> Iterator[tuple[int, dict[str, str]]]:
    """Number of the line and values by column of each row that is not empty."""
    reader = csv.DictReader(lines[first:], delimiter=_delimiter(lines[first] if first < len(lines) else ""))
    names = reader.fieldnames or ()
    for column in names:
        # A remark of one's own may have a column; a slip of the pen in a name would be passed over in silence.
        if column not in (*NEEDED, *OPTIONAL) and get_close_matches(column.casefold(), (*NEEDED, *OPTIONAL)):
            raise InvalidInput(f"{name}: {unknown_choice('column', column, (*NEEDED, *OPTIONAL))}")
    for column in NEEDED:
        if column not in names and column not in settings:
            raise InvalidInput(
                f"{name}: no column {column!r}; give {', '.join(NEEDED)} (and {', '.join(OPTIONAL)}), as a column or "
                f"in a line '# {column}: value' above the heading"
            )
    if len(set(names)) < len(names):
        twice = next(column for column in names if list(names).count(column) > 1)
        raise InvalidInput(f"{name}: column {twice!r} stands there twice")
    for values in reader:
        number = first + reader.line_num
        if None in values:
            raise InvalidInput(f"{name}, row {number}: more fields than the heading; put one with a comma in quotes")
        own = {column: (value or "").strip() for column, value in values.items()}
        given = {column: value for column, value in own.items() if value or column not in settings}
        yield number, {**settings, **given}


def _delimiter(heading: str) -> str:
    """The separator of fields: a semicolon or a tab where decimals have the comma."""
    return max(",;\t", key=heading.count)


def _degrees(text: str) -> float:
    """An angle, of either decimal mark."""
    return parse_quantity("angle_deg", text.replace(",", ".") if DIGITS.fullmatch(text) else text, "")


def _row(name: str, number: int, fields: Mapping[str, str], scene_of: Callable[[str], Scene]) -> Row:
    for column in NEEDED:
        if not fields[column]:
            raise InvalidInput(f"{column}: nothing is given")
    scene = _with(scene_of(fields["scene"]), fields.get("parameters", ""))
    point, derivative, axis = _quantity(scene, fields["quantity"])
    degrees = _degrees(fields["angle_deg"])
    check_number("angle_deg", degrees, -LARGEST_ANGLE, LARGEST_ANGLE, "deg")
    line = fields.get("line", "") or str(number)
    if not (line.isascii() and line.isdecimal() and len(line) < 10):
        raise InvalidInput(f"line = {line!r} is not a line number")
    document = fields.get("document", "") or name
    item = Item(document, "", _place(fields), int(line), fields["quantity"], f"{degrees:g} deg",
                Number(fields["printed"].replace(MINUS, "-")), fields["unit"], fields["scene"])  # fmt: skip
    return Row(number, item, scene, point, derivative, axis, degrees, _factor(item.unit, derivative))


@cache
def _factor(unit: str, derivative: str) -> float:
    """Factor from SI to a printed unit."""
    return 1.0 / parse_quantity("unit", f"1 {unit}", UNITS[derivative])


def _place(fields: Mapping[str, str]) -> str:
    """Place of the value, from whichever columns name it."""
    parts = [f"{column} {fields[column]}" for column in ("table", "row", "equation") if fields.get(column)]
    return ", ".join(filter(None, [fields.get("place", ""), *parts]))


def _with(scene: Scene, text: str) -> Scene:
    """The scene with the parameters of a row, "crank=32.5mm; rod=390mm"."""
    values = {}
    facts = scene.parameter_facts()
    for part in filter(None, (part.strip() for part in text.split(";"))):
        name, equals, value = part.partition("=")
        if not equals:
            raise InvalidInput(f"parameters = {part!r}: give name=value, several apart by ;")
        if name.strip() not in facts:
            raise unknown_choice("parameter", name.strip(), facts)
        values[name.strip()] = parse_quantity(name.strip(), value, facts[name.strip()].unit)
    return scene.with_parameters(**values) if values else scene


def _quantity(scene: Scene, text: str) -> tuple[str, str, str]:
    words = text.split()
    if len(words) != 3:
        raise InvalidInput(
            f"quantity = {text!r}: give a point, {'/'.join(UNITS)} and {'/'.join(AXES)}, like 'G velocity y'"
        )
    point, derivative, axis = words
    for kind, given, choices in (
        ("point", point, scene.lengths),
        ("quantity", derivative, UNITS),
        ("axis", axis, AXES),
    ):
        if given not in choices:
            raise unknown_choice(kind, given, choices)
    return point, derivative, axis
