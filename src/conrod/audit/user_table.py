"""Printed values of a textbook of one's own: a table in CSV, each row tied to a scene, judged as the documents are.

Columns, in any order:

    scene        the name of a scene, such as shear-press
    quantity     a point, what of it and along what: "G velocity y", "C position x", "G acceleration size"
    angle_deg    crank angle [deg]
    printed      the digits as they are printed, 14.66 or 14,66
    unit         of the printed value: mm, mm/s, m/s^2, ...
    parameters   optional: dimensions and speed other than the scene's, "crank=32.5mm; rod=390mm"
    place, line  optional: where it stands
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from conrod.audit.judging import Case, Explanation, judge
from conrod.audit.printed import Item, Number
from conrod.audit.verdict import Verdict
from conrod.catalogue import scene_named
from conrod.errors import InvalidInput, unknown_choice
from conrod.scenes import Scene
from conrod.units import parse_quantity

NEEDED = ("scene", "quantity", "angle_deg", "printed", "unit")
OPTIONAL = ("parameters", "place", "line")
UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s^2", "jerk": "m/s^3"}
AXES = ("x", "y", "size")
# Values of pi that a document may have turned degrees into radians with.
SHORT_PI = {"3.14": 3.14, "3.142": 3.142, "3.1416": 3.1416, "3.14159": 3.14159, "22/7": 22.0 / 7.0}
# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC, FEWEST = 0.9, 3
LARGEST_TABLE = 10_000  # rows


@dataclass(frozen=True)
class Row:
    """One printed value with what it is of; `factor` turns SI into the printed unit."""

    item: Item
    scene: Scene
    point: str
    derivative: str
    axis: str
    degrees: float
    factor: float

    @property
    def group(self) -> tuple[object, ...]:
        """What rows must share for one cause to be behind them."""
        return (self.item.mechanism, self.scene.parameters_text, self.item.quantity, self.item.unit)

    def value(self, angle: float) -> float:
        """The exact value at a crank angle [rad], in the printed unit."""
        vector = getattr(self.scene.motion([angle], self.scene.speed).point(self.point), self.derivative)[0]
        return float(math.hypot(*vector) if self.axis == "size" else vector[AXES.index(self.axis)]) * self.factor

    @cached_property
    def exact(self) -> float:
        """The exact value at the row's own angle."""
        return self.value(math.radians(self.degrees))


def audit_table(document: str, text: str, scene_of: Callable[[str], Scene] = scene_named) -> tuple[Verdict, ...]:
    """A verdict on every row.

    Args:
        document: what the table is called in the verdicts.
        text: of the table.
        scene_of: finds the scene of a name.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row and what is wanted.
    """
    rows = _rows(document, text, cache(scene_of))
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(row.group, []).append(row)
    causes = {group: _systematic(some, CAUSES) for group, some in groups.items()}
    slips = {group: _systematic(some, SLIPS) for group, some in groups.items()}
    return tuple(judge(_case(row, causes[row.group], slips[row.group])) for row in rows)


def _case(row: Row, causes: Mapping[str, Way], slips: Mapping[str, Way]) -> Case:
    return Case(
        row.item,
        row.exact,
        f"exact motion of {row.item.mechanism}",
        causes=tuple(Explanation(text, way(row)) for text, way in causes.items()),
        wrong_steps=tuple(Explanation(text, way(row)) for text, way in slips.items()),
    )


Way = Callable[[Row], float]


def _short_pi(pi: float) -> Way:
    return lambda row: row.value(row.degrees * pi / 180.0)


def _scaled(factor: float) -> Way:
    return lambda row: row.exact * factor


CAUSES: dict[str, Way] = {f"pi taken as {text} for the angle": _short_pi(pi) for text, pi in SHORT_PI.items()}
SLIPS: dict[str, Way] = {
    "the opposite sign": _scaled(-1.0),
    "the crank angle counted in the other sense": lambda row: row.value(-math.radians(row.degrees)),
    "the crank angle counted from the opposite dead centre": lambda row: row.value(math.radians(row.degrees) + math.pi),
    "degrees taken for radians": lambda row: row.value(row.degrees),
    "degrees taken for radians in the speed": _scaled(180.0 / math.pi),
    **{f"a unit {10**k} times as large": _scaled(10.0**-k) for k in (1, 2, 3)},
    **{f"a unit {10**k} times as small": _scaled(10.0**k) for k in (1, 2, 3)},
}


def _systematic(rows: list[Row], ways: Mapping[str, Way]) -> dict[str, Way]:
    """Those ways that reproduce a quantity's values as a whole."""
    met = sum(row.item.number.is_rounding_of(row.exact) for row in rows)
    found: dict[str, Way] = {}
    if met == len(rows):
        return found
    for text, way in ways.items():
        so_many = sum(row.item.number.is_rounding_of(way(row)) for row in rows)
        if so_many >= max(FEWEST, SYSTEMATIC * len(rows)) and so_many > met:
            found[text] = way
    return found


# -- reading ---------------------------------------------------------------------------------------------------------


def _rows(document: str, text: str, scene_of: Callable[[str], Scene]) -> list[Row]:
    reader = csv.DictReader(text.lstrip("\ufeff").splitlines())
    names = reader.fieldnames or ()
    for name in NEEDED:
        if name not in names:
            raise InvalidInput(f"{document}: no column {name!r}; give {', '.join(NEEDED)} (and {', '.join(OPTIONAL)})")
    rows = []
    try:
        for count, fields in enumerate(reader, start=2):
            if count > LARGEST_TABLE + 1:
                raise InvalidInput(f"{document}: more than {LARGEST_TABLE} rows")
            try:
                rows.append(_row(document, {k: v or "" for k, v in fields.items() if k is not None}, scene_of))
            except InvalidInput as error:
                raise InvalidInput(f"{document}, row {count}: {error}") from None
    except csv.Error as error:
        raise InvalidInput(f"{document}: not a table in CSV ({error})") from None
    if not rows:
        raise InvalidInput(f"{document}: no rows below the heading")
    return rows


def _row(document: str, fields: Mapping[str, str], scene_of: Callable[[str], Scene]) -> Row:
    name = fields["scene"].strip()
    scene = _with(scene_of(name), fields.get("parameters", ""))
    point, derivative, axis = _quantity(scene, fields["quantity"])
    degrees = parse_quantity("angle_deg", fields["angle_deg"], "")
    line = fields.get("line", "").strip() or "0"
    if not (line.isascii() and line.isdecimal() and len(line) < 10):
        raise InvalidInput(f"line = {line!r} is not a line number")
    item = Item(
        document,
        "",
        fields.get("place", ""),
        int(line),
        fields["quantity"].strip(),
        f"{fields['angle_deg'].strip()} deg",
        Number(fields["printed"].strip()),
        fields["unit"].strip(),
        name,
    )
    unit = parse_quantity("unit", f"1 {item.unit}", UNITS[derivative])
    return Row(item, scene, point, derivative, axis, degrees, 1.0 / unit)


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
    points = sorted(scene.motion(np.zeros(1), scene.speed).points)
    if len(words) != 3:
        raise InvalidInput(
            f"quantity = {text!r}: give a point, {'/'.join(UNITS)} and {'/'.join(AXES)}, like 'G velocity y'"
        )
    point, derivative, axis = words
    for kind, given, choices in (("point", point, points), ("quantity", derivative, UNITS), ("axis", axis, AXES)):
        if given not in choices:
            raise unknown_choice(kind, given, choices)
    return point, derivative, axis
