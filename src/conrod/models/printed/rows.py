"""Rows of a table of printed values: machine, quantity, crank angle, digits, and how far the angle may be rounded."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from conrod.errors import InvalidInput, named_values, unknown_choice
from conrod.exact.link_rotations import ROTATION_UNITS
from conrod.mechanism.units import check_number, parse_quantity
from conrod.models.printed.verdicts import MAX_DIGITS, NUMBER_PATTERN, PrintedNumber
from conrod.scenes import Scene

NEEDED_COLUMNS = ("scene", "quantity", "angle_deg", "printed", "unit")
TIME_COLUMN = "time_s"  # may stand for the crank angle
COLUMNS = (*NEEDED_COLUMNS, TIME_COLUMN, "parameters", "place")
PRINTED_UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s^2", "jerk": "m/s^3"}
AXES = ("x", "y", "size")
# What a link's rotation is called, in a word or two.
ROTATION_NAMES = {
    "angle": "rotation", "omega": "angular_velocity", "alpha": "angular_acceleration",
    "rotation": "rotation", "angular velocity": "angular_velocity", "angular acceleration": "angular_acceleration",
}  # fmt: skip
MINUS = "\u2212"  # as typeset text has it
MAX_ANGLE = 36_000.0  # [deg], a hundred turns


@dataclass(frozen=True)
class PrintedRow:
    """One printed value with its machine, quantity and crank angle.

    Attributes:
        fields: texts of the row, by column.
        quantity: point, derivative and axis; or link, quantity of its rotation, and nothing.
        rounding: largest difference of the angle from the printed one, by its digits; 0 for a round angle [deg].
        factor: turns SI into the printed unit.
    """

    line: int
    fields: Mapping[str, str]
    number: PrintedNumber
    scene: Scene
    quantity: tuple[str, str, str]
    degrees: float
    rounding: float
    factor: float

    @property
    def condition(self) -> str:
        """The angle or the time, as it is shown."""
        time = self.fields.get(TIME_COLUMN, "")
        return f"{self.degrees:g} deg" if self.fields.get("angle_deg") else f"{time} s"

    @property
    def group(self) -> tuple[object, ...]:
        """Key of the rows that one systematic cause can affect: machine, parameters, quantity and unit."""
        return (self.fields["scene"], self.scene.parameters_text, self.quantity, self.fields["unit"])


def read_rows(lines: Sequence[str], scene_of: Callable[[str], Scene]) -> Iterator[PrintedRow]:
    """Read the rows of a table; raises InvalidInput, which names the row and the column.

    Args:
        scene_of: finds the machine that a row names.
    """
    # Where decimals have the comma, fields are apart by semicolons or tabs.
    reader = csv.DictReader(lines, delimiter=max(",;\t", key="".join(lines[:1]).count))
    names = reader.fieldnames or ()
    for column in names:
        # A remark of one's own may have a column; a slip of the pen in a name would be passed over in silence.
        if column not in COLUMNS and get_close_matches(column.casefold(), COLUMNS):
            raise unknown_choice("column", column, COLUMNS)
    needed = [column for column in NEEDED_COLUMNS if column != "angle_deg" or TIME_COLUMN not in names]
    if not any(line.strip() for line in lines):
        raise InvalidInput(f"it is empty; its first line has to name the columns: {', '.join(NEEDED_COLUMNS)}")
    if missing := [column for column in needed if column not in names]:
        raise InvalidInput(f"no column {missing[0]!r}; needed are {', '.join(NEEDED_COLUMNS)}")
    for fields in reader:
        try:
            if None in fields:
                raise InvalidInput("more fields than the heading; put one with a comma in quotes")
            yield _row(reader.line_num, {column: (value or "").strip() for column, value in fields.items()}, scene_of)
        except InvalidInput as error:
            raise InvalidInput(f"row {reader.line_num}: {error}") from None


def _row(line: int, fields: Mapping[str, str], scene_of: Callable[[str], Scene]) -> PrintedRow:
    """Build one row from its fields; raises InvalidInput, which names the field."""
    by_time = bool(fields.get(TIME_COLUMN)) and not fields.get("angle_deg")
    for column in NEEDED_COLUMNS:
        if not fields.get(column) and not (by_time and column == "angle_deg"):
            raise InvalidInput(f"{column}: nothing is given")
    if fields.get(TIME_COLUMN) and not by_time:
        raise InvalidInput(f"angle_deg and {TIME_COLUMN} are both given: leave out one of them")
    scene = _with_parameters(scene_of(fields["scene"]), fields.get("parameters", ""))
    quantity, column = _quantity(scene, fields["quantity"]), TIME_COLUMN if by_time else "angle_deg"
    text = fields[column].replace(MINUS, "-")
    each = math.degrees(scene.speed) if by_time else 1.0  # [deg] of the unit of the column
    degrees = each * parse_quantity(column, text.replace(",", ".") if NUMBER_PATTERN.fullmatch(text) else text, "")
    check_number(column, degrees, -MAX_ANGLE, MAX_ANGLE, "deg")
    printed = PrintedNumber(fields["printed"].replace(MINUS, "-"))
    units = PRINTED_UNITS | ROTATION_UNITS
    factor = 1.0 / parse_quantity("unit", f"1 {fields['unit']}", units[quantity[1]])
    return PrintedRow(line, fields, printed, scene, quantity, degrees, abs(each) * _angle_rounding(text), factor)


def _angle_rounding(text: str) -> float:
    """Half of the last printed digit of an angle or a time; 0 for a round number, which is chosen, not rounded.

    Round are multiples of ten of the last digit, and of five where they are whole.
    """
    if len(text) > MAX_DIGITS or not NUMBER_PATTERN.fullmatch(text):
        return 0.0
    number = PrintedNumber(text)
    last_digits = round(abs(number.value) / number.last)
    return 0.0 if last_digits % (10 if number.decimals else 5) == 0 else 0.5 * number.last


def _with_parameters(scene: Scene, text: str) -> Scene:
    """A scene with the parameters of a row, "crank=32.5mm; rod=390mm"."""
    facts = scene.parameter_facts()
    parts = list(filter(None, (part.strip() for part in text.split(";"))))
    texts = named_values(parts, "parameters =", "name=value, several apart by ;", "parameter", facts)
    changed = {name: parse_quantity(name, value, facts[name].unit) for name, value in texts.items()}
    return scene.with_parameters(**changed) if changed else scene


def _quantity(scene: Scene, text: str) -> tuple[str, str, str]:
    """Split a quantity: 'G velocity y' into point, derivative and axis, 'rod omega' into link and quantity."""
    words = text.split()
    links = scene.mechanism().body_index
    if len(words) == 2 or (words and words[0] in links and words[0] not in scene.lengths):
        return _rotation(links, words[0], " ".join(words[1:]))
    if len(words) != 3:
        raise InvalidInput(
            f"quantity = {text!r}: give a point, {'/'.join(PRINTED_UNITS)} and {'/'.join(AXES)}, like 'G velocity y'; "
            f"or a link and angle/omega/alpha, like '{next(iter(links))} omega'"
        )
    if words[0] in links and " ".join(words[1:]) in ROTATION_NAMES:
        return _rotation(links, words[0], " ".join(words[1:]))
    known: dict[str, Collection[str]] = {"point": scene.lengths, "quantity": PRINTED_UNITS, "axis": AXES}
    for given, (kind, choices) in zip(words, known.items(), strict=True):
        if given not in choices:
            raise unknown_choice(kind, given, choices)
    return words[0], words[1], words[2]


def _rotation(links: Collection[str], link: str, name: str) -> tuple[str, str, str]:
    """Check a link and the quantity of its rotation, and return them as `PrintedRow` has them."""
    for kind, given, choices in (("link", link, links), ("quantity of a link", name, ROTATION_NAMES)):
        if given not in choices:
            raise unknown_choice(kind, given, choices)
    return link, ROTATION_NAMES[name], ""
