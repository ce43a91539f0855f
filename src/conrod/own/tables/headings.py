"""Headings as tools and people write them: "C.x [mm]", "time (s)", "crank_angle/deg", "x_C in mm", "t_ms"."""

from __future__ import annotations

import re
from functools import cache

from conrod.errors import InvalidInput
from conrod.mechanism.units import parse_quantity

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
    """Readings of a heading: pairs of a name and the unit in it, the whole as a name (with no unit) first."""
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
    """The unit in brackets at the end of a heading; empty without, or where it is an index: "r_0[1]"."""
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
    """True if this is a unit of anything that may stand in a table."""
    return any(factor(text, dimension) is not None for dimension in DIMENSIONS)


@cache
def factor(unit: str, dimension: str) -> float | None:
    """Factor from a unit to SI; None where it is no unit of the dimension.

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
