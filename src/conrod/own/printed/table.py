"""A user's table of printed values in CSV, each row tied to a machine, judged as the documents are.

A row's verdict rests on the other rows too: a cause is systematic where it reproduces a quantity's values as a whole.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.files import check_readable
from conrod.own.printed.judging import Audited, Case, Explanation, Verdict, judge
from conrod.own.printed.rows import Row, grouped, read_rows, values
from conrod.scenes import Scene, scene_named
from conrod.scenes.described_scene import read_scene
from conrod.studies.frame.writing import real_path

MECHANISM_FILE = ".toml"
MOST_BYTES = 1024 * 1024  # 20 000 rows of 50 characters
# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC, FEWEST = 0.9, 3


def audit_file(path: Path) -> Audited:
    """The verdicts on a file; machines are named, or mechanism files beside it.

    Raises:
        InvalidInput: it cannot be read or used; names the file, the row and the field.
    """
    check_readable(path)
    with path.open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise InvalidInput(f"{path}: it is too large: at most {MOST_BYTES // 1024**2} MiB are read")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{path}: it is no text in UTF-8: byte {error.start} cannot be read") from None
    verdicts = audit_table(str(path), text, lambda machine: _scene(machine, path.parent))
    return Audited(path.name, f"Printed values of {path.name}", verdicts)


def _scene(machine: str, folder: Path) -> Scene:
    """The machine that a row names."""
    if not machine.lower().endswith(MECHANISM_FILE):
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
    try:
        rows = read_rows(text, scene_of, document)
        verdicts = {
            row.number: judge(case) for group in grouped(rows) for row, case in zip(group, _cases(group), strict=True)
        }
    except InvalidInput as error:
        raise InvalidInput(f"{document}: {error}") from None
    return tuple(verdicts[row.number] for row in rows)


def _cases(group: Sequence[Row]) -> Iterator[Case]:
    """A case for each row of a group."""
    exact = values(group, np.radians([row.degrees for row in group]))
    for row in (row for row, value in zip(group, exact, strict=True) if np.isnan(value)):
        first, last = np.degrees(row.scene.mechanism().driver.span or (0.0, 0.0))
        driven = f"{row.item.mechanism} is driven from {first:g} to {last:g} deg"
        raise InvalidInput(f"row {row.number}: angle_deg = {row.degrees:g}: {driven}")
    causes, slips = (_systematic(group, exact, ways) for ways in (CAUSES, SLIPS))
    for place, row in enumerate(group):
        why = f"exact motion of {row.item.mechanism}"
        found = [_explanations(ways, place) for ways in (causes, slips)]
        yield Case(row.item, float(exact[place]), why, causes=found[0], wrong_steps=found[1])


# -- causes ------------------------------------------------------------------------------------------------------------

# Crank angles [rad] that printed ones [deg] were taken for, and the factor of the values there.
Way: TypeAlias = tuple[Callable[[Array], Array], float]


def _further(turn: float, degrees: Array) -> Array:
    return np.radians(degrees) + turn


# Values of pi that a document may have turned degrees into radians with.
SHORT_PI = {"3.14": 3.14, "3.142": 3.142, "3.1416": 3.1416, "3.14159": 3.14159, "22/7": 22.0 / 7.0}
CAUSES: dict[str, Way] = {
    f"pi taken as {text} for the angle": (partial(np.multiply, pi / 180.0), 1.0) for text, pi in SHORT_PI.items()
}
SLIPS: dict[str, Way] = {
    "the opposite sign": (np.radians, -1.0),
    "the crank angle counted in the other sense": (lambda degrees: -np.radians(degrees), 1.0),
    "the crank angle counted from the opposite dead centre": (partial(_further, np.pi), 1.0),
    "the crank angle counted from a line 90 deg further on": (partial(_further, 0.5 * np.pi), 1.0),
    "the crank angle counted from a line 90 deg back": (partial(_further, -0.5 * np.pi), 1.0),
    "degrees taken for radians": (lambda degrees: degrees, 1.0),
    "degrees taken for radians in the speed": (np.radians, 180.0 / np.pi),
    **{f"a unit {10**k} times as large": (np.radians, 10.0**-k) for k in (1, 2, 3)},
    **{f"a unit {10**k} times as small": (np.radians, 10.0**k) for k in (1, 2, 3)},
}


def _systematic(rows: Sequence[Row], exact: Array, ways: Mapping[str, Way]) -> dict[str, Array]:
    """Those ways that reproduce a quantity's values as a whole, with what they make of each; NaN for none."""
    degrees, met = np.array([row.degrees for row in rows]), _met(rows, exact)
    if met == len(rows):
        return {}
    made = {text: factor * values(rows, turned(degrees)) for text, (turned, factor) in ways.items()}
    return {
        text: found for text, found in made.items() if _met(rows, found) >= max(FEWEST, SYSTEMATIC * len(rows), met + 1)
    }


def _met(rows: Sequence[Row], found: Array) -> int:
    """Number of printed values that are these, rounded."""
    return sum(row.item.number.is_rounding_of(float(value)) for row, value in zip(rows, found, strict=True))


def _explanations(ways: Mapping[str, Array], place: int) -> tuple[Explanation, ...]:
    """Explanations of one row; one that leads out of the machine's reach is none."""
    return tuple(Explanation(text, float(found[place])) for text, found in ways.items() if np.isfinite(found[place]))
