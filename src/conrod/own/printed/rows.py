"""Rows of a user's table of printed values: read from CSV, each tied to a machine.

The format is described in docs/audit.md. Nothing in a table is executed; a path in one cannot lead out of its folder.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache

import numpy as np

from conrod.errors import InvalidInput, named_values, unknown_choice
from conrod.exact.motion import BREAK_WIDTH, Array
from conrod.mechanism.units import check_number, parse_quantity
from conrod.own.printed.judging import DIGITS, Item, Number
from conrod.scenes import Scene

NEEDED = ("scene", "quantity", "angle_deg", "printed", "unit")
OPTIONAL = ("parameters", "place")
COLUMNS = (*NEEDED, *OPTIONAL)
UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s^2", "jerk": "m/s^3"}
AXES = ("x", "y", "size")
MINUS = "\u2212"  # as typeset text has it
LARGEST_ANGLE = 36_000.0  # [deg], a hundred turns


@dataclass(frozen=True)
class Row:
    """One printed value with what it is of.

    Attributes:
        number: of its line in the file.
        factor: turns SI into the printed unit.
    """

    number: int
    item: Item
    scene: Scene
    point: str
    derivative: str
    axis: str
    degrees: float
    factor: float

    @property
    def group(self) -> tuple[object, ...]:
        """Properties that rows share of which one cause can be behind all."""
        machine = self.item.mechanism, self.scene.parameters_text
        return (machine, self.point, self.derivative, self.axis, self.item.unit)


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


def grouped(rows: Sequence[Row]) -> list[list[Row]]:
    """Rows of one quantity together, in the order of their first ones."""
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(row.group, []).append(row)
    return list(groups.values())


def read_rows(text: str, scene_of: Callable[[str], Scene], name: str) -> list[Row]:
    """All rows of a table.

    Args:
        text: of the table.
        scene_of: finds the machine that a row names.
        name: of the table.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row, the field and what is wanted.
    """
    try:
        rows = list(_rows(name, text.lstrip("\ufeff").splitlines(), cache(scene_of)))
    except csv.Error as error:
        raise InvalidInput(f"not a table in CSV ({error})") from None
    if not rows:
        raise InvalidInput("no rows below the heading")
    return rows


def _rows(name: str, lines: Sequence[str], scene_of: Callable[[str], Scene]) -> Iterator[Row]:
    for number, fields in _fields(lines):
        try:
            yield _row(name, number, fields, scene_of)
        except InvalidInput as error:
            raise InvalidInput(f"row {number}: {error}") from None


def _fields(lines: Sequence[str]) -> Iterator[tuple[int, dict[str, str]]]:
    """Number of the line and values by column of each row that is not empty."""
    # Where decimals have the comma, fields are apart by semicolons or tabs.
    heading = lines[0] if lines else ""
    reader = csv.DictReader(lines, delimiter=max(",;\t", key=heading.count))
    names = reader.fieldnames or ()
    for column in names:
        # A remark of one's own may have a column; a slip of the pen in a name would be passed over in silence.
        if column not in COLUMNS and get_close_matches(column.casefold(), COLUMNS):
            raise unknown_choice("column", column, COLUMNS)
    for column in NEEDED:
        if column not in names:
            raise InvalidInput(f"no column {column!r}; give {', '.join(NEEDED)} (and {', '.join(OPTIONAL)})")
    for fields in reader:
        if None in fields:
            raise InvalidInput(f"row {reader.line_num}: more fields than the heading; put one with a comma in quotes")
        yield reader.line_num, {column: (value or "").strip() for column, value in fields.items()}


def _row(name: str, number: int, fields: Mapping[str, str], scene_of: Callable[[str], Scene]) -> Row:
    for column in NEEDED:
        if not fields[column]:
            raise InvalidInput(f"{column}: nothing is given")
    scene = _with(scene_of(fields["scene"]), fields.get("parameters", ""))
    point, derivative, axis = _quantity(scene, fields["quantity"])
    angle, unit = fields["angle_deg"], fields["unit"]
    degrees = parse_quantity("angle_deg", angle.replace(",", ".") if DIGITS.fullmatch(angle) else angle, "")
    check_number("angle_deg", degrees, -LARGEST_ANGLE, LARGEST_ANGLE, "deg")
    printed = Number(fields["printed"].replace(MINUS, "-"))
    item = Item(
        document=name, key="", place=fields.get("place", ""), line=number, quantity=fields["quantity"],
        condition=f"{degrees:g} deg", number=printed, unit=unit, mechanism=fields["scene"],
    )  # fmt: skip
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
