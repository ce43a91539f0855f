"""The torque on the crank of a user's run: constant, a column of the run's own table, or a table of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.mechanism.loads import Load, LoadLaw, Sampled, Steady, Turn
from conrod.mechanism.mechanism import GROUND, Mechanism
from conrod.mechanism.units import NUMBER, check_number, parse_quantity
from conrod.models.tables.columns import OTHER_NAMES, TIME, Column, ColumnRequest, column_with_unit, split_heading
from conrod.models.tables.reading import check_values, open_table
from conrod.user_files import TABLES
from conrod.user_files.files import check_readable, name_file_in_errors

UNIT, MAX_TORQUE = "N*m", 1e12  # [N m]
TORQUE_NAME = "torque"
WAYS = ("linear", "previous", "next")  # of a torque between two rows, as of `Sampled`
MAX_KINKS = 50_000  # at each the exact motion is begun anew: some 0.5 ms


@dataclass(frozen=True)
class Torque:
    """Torque on the crank, positive in the direction of a growing crank angle.

    Attributes:
        law: its law in time.
        words: what it is, for a sentence.
    """

    law: LoadLaw
    words: str

    def acts_on(self, mechanism: Mechanism, name: str = "--torque") -> Load:
        """The torque as a load of a machine, counter-clockwise as all loads are."""
        ends = (GROUND, mechanism.crank) if mechanism.driver.sense > 0 else (mechanism.crank, GROUND)
        return Load(name, Turn(*ends), self.law)


def constant_torque(given: float | str) -> Torque | None:
    """A constant torque given as a number [N m] or as text with a unit; None for the name of a column or a file.

    Raises:
        InvalidInput: it is not finite, or has another unit.
    """
    if isinstance(given, str):
        if not NUMBER.match(given.strip()) or given.lower().endswith(TABLES):
            return None
        given = parse_quantity("--torque", given, UNIT)
    check_number("--torque", given, -MAX_TORQUE, MAX_TORQUE, UNIT)
    return Torque(Steady(float(given)), f"a constant torque of {given:.6g} N m")


def split_way(given: str) -> tuple[str, str | None]:
    """Split `motor:next` into the column or file and how the torque goes from row to row; None if that is not said."""
    name, colon, way = given.rpartition(":")
    return (name, way) if colon and name and way in WAYS else (given, None)


def read_torque(path: Path, given: str, own: str | None = None) -> Torque:
    """Read a torque over time; for `call_on_file`, since the file is a user's.

    Args:
        path: a table with a time and the torque.
        given: what the user typed, with the way from row to row, for messages.
        own: column of the torque, where the table is the run's own; None where it is a table of the torque.

    Raises:
        InvalidInput: the table cannot be used; says what is missing.
    """
    check_readable(path)
    way = split_way(given)[1]
    with name_file_in_errors(path):
        _, headings, read = open_table(path, ColumnRequest({}, ()))
        columns = _torque_columns(headings, own)
        reading = check_values(columns, *read(columns), (), "")
    times, sizes = reading.values[TIME], reading.values[TORQUE_NAME]
    if own is not None:
        way, words = way or "previous", f"the torque of column {own!r}"
    else:
        way, words = way or "linear", f"the torque of {path}"
    return Torque(sampled_torque(times, sizes, way), f"{words}, {WAY_WORDS[way]}")


WAY_WORDS = {
    "linear": "linear between its rows",
    "previous": "held from each row to the next",
    "next": "held up to each row from the one before",
}


def sampled_torque(times: Array, sizes: Array, way: str) -> Sampled:
    """A torque at instants (T,) [s], with its sizes (T,) [N m].

    Raises:
        InvalidInput: it changes in too many rows.
    """
    law = Sampled(tuple(times.tolist()), tuple(sizes.tolist()), way)
    if len(law.kinks) > MAX_KINKS:
        raise InvalidInput(
            f"--torque: it changes in {len(law.kinks)} rows; at most {MAX_KINKS} may: check a shorter run"
        )
    return law


def _torque_columns(headings: Sequence[str], own: str | None) -> list[Column]:
    """Find the columns of time and torque among a table's headings; `own` names the torque's."""
    names = [split_heading(heading)[0] for heading in headings]
    time = next((k for k, name in enumerate(names) if name.casefold() in (TIME, OTHER_NAMES[TIME])), None)
    if time is None:
        raise InvalidInput(
            f"no column for the time among {', '.join(map(repr, headings))}: --torque takes t and torque"
        )
    if own is not None:
        place = next((k for k, pair in enumerate(zip(headings, names, strict=True)) if own in pair), None)
        if place is None:
            raise unknown_choice("column in --torque", own, dict.fromkeys(name for name in names if name))
    else:
        others = [k for k in range(len(names)) if k != time]
        named = [k for k in others if TORQUE_NAME in names[k].casefold()]
        if len(named or others) != 1:
            raise InvalidInput(
                f"which column is the torque? Name one of {', '.join(names[k] for k in others)} 'torque'"
            )
        (place,) = named or others
    asked = ColumnRequest({}, ())
    return [
        column_with_unit(name, unit, k, headings[k], split_heading(headings[k])[1], asked)
        for name, unit, k in ((TIME, "s", time), (TORQUE_NAME, UNIT, place))
    ]


def shift_torque(law: LoadLaw, by: float) -> LoadLaw:
    """Let a sampled torque act later [s]; a constant one stays."""
    if not isinstance(law, Sampled):
        return law
    return Sampled(tuple((np.array(law.times) + by).tolist()), law.sizes, law.between)


def scale_torque(law: LoadLaw, by: float) -> LoadLaw:
    """Multiply a torque by a factor."""
    if isinstance(law, Sampled):
        return Sampled(law.times, tuple((by * np.array(law.sizes)).tolist()), law.between)
    assert isinstance(law, Steady)
    return Steady(by * law.size)
