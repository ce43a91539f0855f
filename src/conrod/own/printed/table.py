"""A user's table of printed values in CSV, each row tied to a machine, judged as the documents are.

A row's verdict rests on the other rows too: a cause is systematic where it reproduces a quantity's values as a whole,
and a misprint is a print that the values beside it contradict: its components or its size, the rows before and after.
"""

from __future__ import annotations

import math
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
from conrod.scenes import Scene
from conrod.scenes.catalogue import scene_named
from conrod.scenes.described_scene import read_scene
from conrod.studies.frame.writing import real_path

MECHANISM_FILE = ".toml"
MOST_BYTES = 4 * 1024 * 1024  # 10 000 rows of 400 characters
# Rows that a value is interpolated from: more reach farther from it and spoil it if one of them is wrong.
NEAREST = (4, 2)
DECISIVE = 2.0
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
    documents = dict.fromkeys(verdict.document for verdict in verdicts)
    title = ", ".join(documents) if str(path) not in documents else f"Printed values of {path.name}"
    return Audited(path.name, title, verdicts)


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
        document: what the table is called in errors, and in the verdicts on rows that name no document.
        text: of the table.
        scene_of: finds the machine that a row names.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row and what is wanted.
    """
    rows = read_rows(document, text, scene_of)
    beside = {id(row): some for some in grouped(rows, lambda row: (row.machine, row.point)) for row in some}
    judged = {
        row.number: judge(case)
        for group in grouped(rows, lambda row: row.group)
        for row, case in zip(group, _cases(group, beside), strict=True)
    }
    return tuple(judged[row.number] for row in rows)


def _cases(group: Sequence[Row], beside: Mapping[int, Sequence[Row]]) -> Iterator[Case]:
    """A case for each row of a group; `beside` has all rows of its point."""
    causes, slips = _systematic(group, CAUSES), _systematic(group, SLIPS)
    for place, row in enumerate(group):
        slipped = _explanations(slips, place)
        # Neighbours are asked only where the print is off: they cost more than all the rest. And where a slip runs
        # through the whole quantity they have slipped too.
        off = not any(row.item.number.is_rounding_of(value) for value in (row.exact, *(s.value for s in slipped)))
        yield Case(
            row.item,
            row.exact,
            f"exact motion of {row.item.mechanism}",
            causes=_explanations(causes, place),
            neighbours=(*_of_components(row, beside[id(row)]), *_of_rows(row, beside[id(row)])) if off else (),
            wrong_steps=slipped,
        )


# -- neighbours --------------------------------------------------------------------------------------------------------


def _of_components(row: Row, rows: Sequence[Row]) -> Iterator[Explanation]:
    """The size from both components, or a component from the size and the other."""
    beside = {
        other.axis: other
        for other in rows
        if other is not row and (other.derivative, other.degrees) == (row.derivative, row.degrees)
    }
    others = [beside[axis] for axis in ("x", "y", "size") if axis != row.axis and axis in beside]
    if len(others) < 2:
        return
    # In the unit of this row.
    first, second = (other.item.number.value * row.factor / other.factor for other in others)
    halves = [0.5 * other.item.number.last * row.factor / other.factor for other in others]
    text = " beside ".join(f"{other.item.quantity} = {other.item.number.text}" for other in others)
    if row.axis == "size":
        yield Explanation(text, math.hypot(first, second), sum(halves))
    elif second > abs(first):
        # The size comes last; the sign is the print's own.
        value = math.copysign(math.sqrt(second**2 - first**2), row.item.number.value)
        yield Explanation(text, value, (second * halves[1] + abs(first) * halves[0]) / abs(value))


def _of_rows(row: Row, rows: Sequence[Row]) -> Iterator[Explanation]:
    """The value interpolated from the nearest rows of the same quantity, one print at each angle.

    Lagrange's polynomial through the printed values; how far it may be off is what rounding of the prints does to it,
    and what the same polynomial through the exact values leaves.
    """
    series = {o.degrees: o for o in rows if o.group == row.group and o.degrees != row.degrees}
    for count in NEAREST:
        near = sorted(sorted(series, key=lambda degrees: abs(degrees - row.degrees))[:count])
        # Only between rows on both sides: beyond the last one a polynomial knows nothing.
        if len(near) < count or not near[0] < row.degrees < near[-1]:
            continue
        some, weights = [series[degrees] for degrees in near], _lagrange(np.array(near), row.degrees)
        value = float(weights @ [other.item.number.value for other in some])
        rounding = float(np.abs(weights) @ [0.5 * other.item.number.last for other in some])
        curve = abs(float(weights @ [other.exact for other in some]) - row.exact)
        # A contradiction as large as what the polynomial itself may be off proves nothing.
        if abs(value - row.item.number.value) > DECISIVE * (rounding + curve):
            angles = ", ".join(f"{degrees:g}" for degrees in near)
            yield Explanation(f"interpolation between the rows at {angles} deg", value, rounding + curve)


def _lagrange(places: Array, at: float) -> Array:
    """Weights (N,) of the values at N places in the value of their polynomial at another place."""
    apart = places[:, None] - places[None, :]
    np.fill_diagonal(apart, 1.0)
    reach = np.where(np.eye(len(places), dtype=bool), 1.0, at - places[None, :])
    return np.asarray(np.prod(reach / apart, axis=1))


# -- causes ------------------------------------------------------------------------------------------------------------

# Crank angles [rad] that printed ones [deg] were taken for, and the factor of the values there.
Way: TypeAlias = tuple[Callable[[Array], Array], float]


def _next(rows: int, degrees: Array) -> Array:
    """Angles some rows further on, in a table of even steps."""
    places = np.unique(degrees)
    step = np.median(np.diff(places)) if len(places) > 1 else np.nan
    return np.radians(degrees + rows * step)


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
    "the value of the angle one step before": (partial(_next, -1), 1.0),
    "the value of the angle one step after": (partial(_next, 1), 1.0),
    "the crank angle counted from a line 90 deg further on": (partial(_further, 0.5 * np.pi), 1.0),
    "the crank angle counted from a line 90 deg back": (partial(_further, -0.5 * np.pi), 1.0),
    "degrees taken for radians": (lambda degrees: degrees, 1.0),
    "degrees taken for radians in the speed": (np.radians, 180.0 / np.pi),
    **{f"a unit {10**k} times as large": (np.radians, 10.0**-k) for k in (1, 2, 3)},
    **{f"a unit {10**k} times as small": (np.radians, 10.0**k) for k in (1, 2, 3)},
}


def _systematic(rows: Sequence[Row], ways: Mapping[str, Way]) -> dict[str, Array]:
    """Those ways that reproduce a quantity's values as a whole, with what they make of each; NaN for none."""
    degrees, met = np.array([row.degrees for row in rows]), _met(rows, np.array([row.exact for row in rows]))
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
