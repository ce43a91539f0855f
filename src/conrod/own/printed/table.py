"""A user's table of printed values in CSV, each row tied to a machine, judged by its exact motion.

A row's verdict rests on the other rows too: a cause is systematic where it reproduces a quantity's values as a whole.
The format is described in docs/audit.md. Nothing in a table is executed; a path in one cannot lead out of its folder.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from conrod.errors import InvalidInput, named_values, unknown_choice
from conrod.exact.motion import BREAK_WIDTH, Array
from conrod.mechanism.units import check_number, parse_quantity
from conrod.own.encodings import decoded
from conrod.own.files import check_readable, of_file
from conrod.own.printed.verdicts import DIGITS, GOOD, Audited, Kind, Number, Verdict
from conrod.scenes import Scene, scene_named
from conrod.scenes.described_scene import read_scene
from conrod.studies.frame.writing import real_path

MOST_BYTES = 1024 * 1024  # 20 000 rows of 50 characters
NEEDED = ("scene", "quantity", "angle_deg", "printed", "unit")
COLUMNS = (*NEEDED, "parameters", "place")
UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s^2", "jerk": "m/s^3"}
AXES = ("x", "y", "size")
MINUS = "\u2212"  # as typeset text has it
LARGEST_ANGLE = 36_000.0  # [deg], a hundred turns


@dataclass(frozen=True)
class Row:
    """One printed value with what it is of.

    Attributes:
        fields: as they stand in the table, by column.
        quantity: point, derivative and axis.
        factor: turns SI into the printed unit.
    """

    line: int
    fields: Mapping[str, str]
    number: Number
    scene: Scene
    quantity: tuple[str, str, str]
    degrees: float
    factor: float

    @property
    def group(self) -> tuple[object, ...]:
        """Properties that rows share of which one cause can be behind all."""
        return (self.fields["scene"], self.scene.parameters_text, self.quantity, self.fields["unit"])


def audit_file(path: Path) -> Audited:
    """The verdicts on a file; machines are named, or mechanism files beside it.

    Raises:
        InvalidInput: it cannot be read or used; names the file, the row and the field.
    """
    check_readable(path)
    if path.stat().st_size > MOST_BYTES:
        raise InvalidInput(f"{path}: it is too large: at most {MOST_BYTES // 1024**2} MiB are read")
    with of_file(path):
        text, _ = decoded(path.read_bytes())
    verdicts = audit_table(str(path), text, lambda machine: _scene(machine, path.parent))
    return Audited(path.name, f"Printed values of {path.name}", verdicts)


def _scene(machine: str, folder: Path) -> Scene:
    """The machine that a row names."""
    if not machine.lower().endswith(".toml"):
        return scene_named(machine)
    home, place = real_path(folder), real_path(folder / machine)
    if Path(machine).is_absolute() or not place.is_relative_to(home):
        raise InvalidInput(f"scene = {machine!r} leads out of the folder of the table: put the mechanism file into it")
    return read_scene(place)


def audit_table(document: str, text: str, scene_of: Callable[[str], Scene] = scene_named) -> tuple[Verdict, ...]:
    """A verdict on every row.

    Args:
        document: what the table is called in errors and in the verdicts.
        text: of the table.
        scene_of: finds the machine that a row names.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row and what is wanted.
    """
    groups: dict[tuple[object, ...], list[Row]] = {}
    try:
        for row in _rows(text.splitlines(), cache(scene_of)):
            groups.setdefault(row.group, []).append(row)
        if not groups:
            raise InvalidInput("no rows below the heading")
        verdicts = [verdict for rows in groups.values() for verdict in _verdicts(document, rows)]
    except (InvalidInput, csv.Error) as error:
        raise InvalidInput(f"{document}: {error}") from None
    return tuple(sorted(verdicts, key=lambda verdict: verdict.line))


# -- rows --------------------------------------------------------------------------------------------------------------


def _rows(lines: Sequence[str], scene_of: Callable[[str], Scene]) -> Iterator[Row]:
    # Where decimals have the comma, fields are apart by semicolons or tabs.
    reader = csv.DictReader(lines, delimiter=max(",;\t", key="".join(lines[:1]).count))
    names = reader.fieldnames or ()
    for column in names:
        # A remark of one's own may have a column; a slip of the pen in a name would be passed over in silence.
        if column not in COLUMNS and get_close_matches(column.casefold(), COLUMNS):
            raise unknown_choice("column", column, COLUMNS)
    if missing := [column for column in NEEDED if column not in names]:
        raise InvalidInput(f"no column {missing[0]!r}; needed are {', '.join(NEEDED)}")
    for fields in reader:
        try:
            if None in fields:
                raise InvalidInput("more fields than the heading; put one with a comma in quotes")
            yield _row(reader.line_num, {column: (value or "").strip() for column, value in fields.items()}, scene_of)
        except InvalidInput as error:
            raise InvalidInput(f"row {reader.line_num}: {error}") from None


def _row(line: int, fields: Mapping[str, str], scene_of: Callable[[str], Scene]) -> Row:
    for column in NEEDED:
        if not fields[column]:
            raise InvalidInput(f"{column}: nothing is given")
    scene = _with(scene_of(fields["scene"]), fields.get("parameters", ""))
    quantity, angle = _quantity(scene, fields["quantity"]), fields["angle_deg"]
    degrees = parse_quantity("angle_deg", angle.replace(",", ".") if DIGITS.fullmatch(angle) else angle, "")
    check_number("angle_deg", degrees, -LARGEST_ANGLE, LARGEST_ANGLE, "deg")
    printed = Number(fields["printed"].replace(MINUS, "-"))
    factor = 1.0 / parse_quantity("unit", f"1 {fields['unit']}", UNITS[quantity[1]])
    return Row(line, fields, printed, scene, quantity, degrees, factor)


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
    return words[0], words[1], words[2]


# -- verdicts ----------------------------------------------------------------------------------------------------------

# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC, FEWEST = 0.9, 3
# Crank angles [rad] that printed ones [deg] were taken for, and the factor of the values there.
Way: TypeAlias = tuple[Callable[[Array], Array], float]
# Values of pi that a document may have turned degrees into radians with.
SHORT_PI = {"3.14": 3.14, "3.142": 3.142, "3.1416": 3.1416, "3.14159": 3.14159, "22/7": 22.0 / 7.0}
CAUSES: dict[str, Way] = {
    f"pi taken as {text} for the angle": (partial(np.multiply, pi / 180.0), 1.0) for text, pi in SHORT_PI.items()
}
SLIPS: dict[str, Way] = {
    "the opposite sign": (np.radians, -1.0),
    "the crank angle counted in the other sense": (lambda degrees: -np.radians(degrees), 1.0),
    "the crank angle counted from the opposite dead centre": (lambda degrees: np.radians(degrees) + np.pi, 1.0),
    "the crank angle counted from a line 90 deg further on": (lambda degrees: np.radians(degrees) + 0.5 * np.pi, 1.0),
    "the crank angle counted from a line 90 deg back": (lambda degrees: np.radians(degrees) - 0.5 * np.pi, 1.0),
    "degrees taken for radians": (lambda degrees: degrees, 1.0),
    "degrees taken for radians in the speed": (np.radians, 180.0 / np.pi),
    **{f"a unit {10**k} times as large": (np.radians, 10.0**-k) for k in (1, 2, 3)},
    **{f"a unit {10**k} times as small": (np.radians, 10.0**k) for k in (1, 2, 3)},
}


def values(rows: Sequence[Row], angles: Array) -> Array:
    """Exact values (N,) of a quantity at crank angles (N,) [rad], in the printed unit; NaN where it is not reached.

    Args:
        rows: N of one group.
    """
    scene, (point, derivative, axis), found = rows[0].scene, rows[0].quantity, np.full(len(rows), np.nan)
    low, high = scene.mechanism().driver.span or (-np.inf, np.inf)
    there = (angles >= low - BREAK_WIDTH) & (angles <= high + BREAK_WIDTH)
    if there.any():
        vectors = getattr(scene.motion(angles[there], scene.speed).point(point), derivative)
        found[there] = np.hypot(*vectors.T) if axis == "size" else vectors[:, AXES.index(axis)]
    return np.asarray(found * rows[0].factor)


def _verdicts(document: str, rows: Sequence[Row]) -> Iterator[Verdict]:
    """Verdicts on the rows of a group."""
    degrees = np.array([row.degrees for row in rows])
    exact = values(rows, np.radians(degrees))
    for k in np.flatnonzero(np.isnan(exact))[:1]:
        first, last = np.degrees(rows[k].scene.mechanism().driver.span or (0.0, 0.0))
        driven = f"{rows[k].fields['scene']} is driven from {first:g} to {last:g} deg"
        raise InvalidInput(f"row {rows[k].line}: angle_deg = {degrees[k]:g}: {driven}")
    met = _met(rows, exact)
    ways = CAUSES | SLIPS if met < len(rows) else {}
    every = {text: factor * values(rows, turned(degrees)) for text, (turned, factor) in ways.items()}
    needed = max(FEWEST, SYSTEMATIC * len(rows), met + 1)
    made = {text: found for text, found in every.items() if _met(rows, found) >= needed}
    for k, row in enumerate(rows):
        yield _verdict(document, row, float(exact[k]), {text: float(found[k]) for text, found in made.items()})


def _met(rows: Sequence[Row], found: Array) -> int:
    """Number of printed values that are these, rounded."""
    return sum(row.number.is_rounding_of(float(value)) for row, value in zip(rows, found, strict=True))


def _verdict(document: str, row: Row, exact: float, made: Mapping[str, float]) -> Verdict:
    """The kindest verdict that the exact value, or what ways of the whole column make of it, supports."""
    fields, number, kind, why = row.fields, row.number, Kind.NOT_REPRODUCIBLE, f"exact motion of {row.fields['scene']}"
    cause = next((text for text, value in made.items() if number.is_rounding_of(value)), None)
    if number.is_rounding_of(exact):
        kind, cause = Kind.AGREES, None
    elif cause in CAUSES:
        kind = Kind.EXPLAINED
    elif number.is_cut_of(exact):
        kind, cause = Kind.AFTER_ROUNDING, None
    elif cause:
        kind = Kind.WRONG_STEP
    reason = f"{cause} gives {made[cause]:.7g}; {why}" if cause else why
    if kind is Kind.AFTER_ROUNDING:
        reason += "; further digits are cut off instead of rounded"
    return Verdict(
        document, fields.get("place", ""), row.line, fields["quantity"], f"{row.degrees:g} deg", fields["unit"],
        number.text, exact, (number.value - exact) / number.last, kind, reason,
        should_be=None if kind in GOOD else number.like(exact), cause=cause,
    )  # fmt: skip
