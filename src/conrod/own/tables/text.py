"""Lines of a text file, whatever its encoding: numbered, of bounded length.

Headings as tools and people write them: "C.x [mm]", "time (s)", "crank_angle/deg", "x_C in mm", "t_ms".
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.mechanism.units import parse_quantity

LONGEST_LINE = 1_000_000  # characters
BLOCK = 1 << 21  # characters read at a time
HEAD = 1 << 16  # bytes that an encoding is told from
BOMS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
# What other programs save by, and people then rename.
SIGNATURES = {
    b"PK\x03\x04": "a zip archive or an Excel workbook; save the sheet as CSV",
    b"PAR1": "a Parquet file; let its name end in .parquet",
    b"\x1f\x8b": "compressed; unpack it first",
    b"\x89HDF": "an HDF5 file; save the columns as CSV",
    b"MATLAB 5.0": "a MATLAB file; save the columns as CSV",
    b"%PDF": "a PDF file",
}


def encoding_of(path: Path) -> str:
    """The encoding of a text file, from its beginning.

    Raises:
        InvalidInput: the file is empty, or no text.
    """
    with path.open("rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        raise InvalidInput(f"{path}: it is empty")
    for signature, what in SIGNATURES.items():
        if head.startswith(signature):
            raise InvalidInput(f"{path}: it is no table of text but {what}")
    for mark, encoding in BOMS.items():
        if head.startswith(mark):
            return encoding
    if b"\0" in head:
        raise InvalidInput(f"{path}: it is no table of text: it holds zero bytes")
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252"  # what spreadsheets on Windows write
    return "utf-8"


def lines(path: Path, encoding: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers from 1, without those that are blank; raises as `blocks`."""
    for first, block in blocks(path, encoding):
        yield from ((number, line) for number, line in enumerate(block, first) if line.strip())


def blocks(path: Path, encoding: str) -> Iterator[tuple[int, list[str]]]:
    """All lines in blocks of bounded size, each block with the number of its first line.

    Raises:
        InvalidInput: a line that is too long, or no text.
    """
    number, rest = 1, ""
    with path.open(encoding=encoding) as file:
        while True:
            try:
                text = file.read(BLOCK)
            except UnicodeError:
                raise InvalidInput(f"{path}: behind row {number}: it is no text in {encoding}") from None
            # Only by the ends of lines, not by all that str.splitlines() takes for one.
            block = (rest + text).split("\n")
            rest = block.pop() if text else ""
            _check(path, number, block, rest)
            if "\0" in text:
                zero = next((k for k, line in enumerate(block) if "\0" in line), len(block))
                raise InvalidInput(f"{path}: row {number + zero} holds zero bytes: it is no table of text")
            if block:
                yield number, block
            number += len(block)
            if not text:
                return


def _check(path: Path, first: int, block: list[str], rest: str) -> None:
    longest = max(map(len, (*block, rest)))
    if longest > LONGEST_LINE:
        number = first + [len(line) for line in (*block, rest)].index(longest)
        raise InvalidInput(f"{path}: row {number} is longer than {LONGEST_LINE} characters: it is no table")


# What may stand in a table, and what a user calls it. Lengths and angles each with their rates.
DIMENSIONS = {
    "s": "time",
    "m": "length",
    "m/s": "velocity",
    "m/s^2": "acceleration",
    "rad": "angle",
    "rad/s": "angular speed",
    "rad/s^2": "angular acceleration",
}
BRACKETED = re.compile(r"(?P<name>.*\S)\s*(\[(?P<square>[^\]]*)\]|\((?P<round>[^)]*)\)|\{(?P<curly>[^}]*)\})\s*")
BEHIND = re.compile(r"(?P<name>.*\S)(\s*/\s*|\s+in\s+|\s*,\s*)(?P<unit>\(?[^\s_,]+\)?)\s*")
# Behind an underscore stands many a name that some unit has as well.
SUFFIX = re.compile(r"(?P<name>.*[^\W_])_(?P<unit>s|ms|us|m|mm|cm|um|in|inch|deg|rad|rev|rpm|sec)", re.IGNORECASE)
POWER = re.compile(r"(?<=[A-Za-zµμ])(-?[1-9])\b")
INDEX = re.compile(r"[\d\s,:]*")
NONE = ("", "-", "1", "none")


def readings(heading: str) -> tuple[tuple[str, str], ...]:
    """What a heading may mean: pairs of a name and the unit in it, the whole as a name (with no unit) first."""
    whole = " ".join(heading.split())
    found = [(whole, "")]
    if bracketed := BRACKETED.fullmatch(whole):
        found.append((bracketed["name"], bracketed_unit(whole)))
    # Without brackets it is a unit only where it is one: "x/l" has none.
    behind = SUFFIX.fullmatch(whole) or BEHIND.fullmatch(whole)
    if behind and is_unit(unit := behind["unit"].strip("()")):
        found.append((behind["name"], unit))
    return tuple(found)


def bracketed_unit(heading: str) -> str:
    """What stands in brackets at the end of a heading; empty without, or where it is an index: "r_0[1]"."""
    match = BRACKETED.fullmatch(heading)
    if not match:
        return ""
    inside = next(text for text in (match["square"], match["round"], match["curly"]) if text is not None).strip()
    return "" if INDEX.fullmatch(inside) else inside


def bare_unit(cell: str) -> str | None:
    """The unit in a cell of a row of units, with or without brackets; empty for none, None where it is no unit."""
    text = cell.strip().strip("[](){}").strip()
    if text.lower() in NONE:
        return ""
    return text if is_unit(text) else None


def is_unit(text: str) -> bool:
    """Whether this is a unit of anything that may stand in a table."""
    return any(factor(text, dimension) is not None for dimension in DIMENSIONS)


@cache
def factor(unit: str, dimension: str) -> float | None:
    """What a number in a unit is multiplied by to be SI; None where it is no unit of the dimension.

    Args:
        dimension: an SI unit, a key of `DIMENSIONS`.
    """
    written = _tidy(unit)
    # Accelerometers read in g; elsewhere that is a gram.
    written = "gravity" if dimension == "m/s^2" and written == "g" else written
    # MM and Sec are slips of the pen; single letters mean other things in capitals.
    for way in dict.fromkeys((written, written.lower() if len(written) > 1 else written)):
        try:
            return parse_quantity("unit", f"1 {way}", dimension) if way else None
        except InvalidInput:
            continue
    return None


def _tidy(unit: str) -> str:
    """A unit as `parse_quantity` takes it, from what tools write: m/s², m/s2, m.s-2, m*s**-2, °."""
    text = unit.strip().replace("²", "^2").replace("**", "^").replace("°", "deg").replace("(", "").replace(")", "")
    text = re.sub(r"(?<=[A-Za-z0-9])\.(?=[A-Za-z])", "*", text).replace("·", "*")
    return POWER.sub(r"^\1", text)
