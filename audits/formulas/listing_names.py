"""Names that document 002's MATLAB listing uses and never assigns: MATLAB stops there.

MATLAB tells capitals from small letters. A word alone on a line with an assignment to C on the next one is one name
that the column of the print has broken.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from importlib.resources import files

from conrod.models.printed.verdicts import PrintedVerdict, VerdictKind

FIRST_LINE = 136  # of the listing in the document's text
KNOWN = {
    "asin",
    "sin",
    "cos",
    "pi",
    "input",
    "figure",
    "plot",
    "real",
    "imag",
    "xlabel",
    "ylabel",
    "title",
    "grid",
    "on",
}
NAME = re.compile(r"[A-Za-z]\w*")
ASSIGNMENT = re.compile(r"\s*([A-Za-z]\w*)\s*=(.*)", re.DOTALL)
BROKEN = re.compile(r"^([A-Za-z]+)[ \t]*\n(C=)", re.MULTILINE)


def listing() -> str:
    """The listing as it stands in the document."""
    return files("audits").joinpath("data", "saw_listing.m").read_text(encoding="utf-8")


def verdicts(text: str) -> Iterator[PrintedVerdict]:
    """One on each name at its first use before any assignment.

    Args:
        text: of the listing.
    """
    # The broken name stands on its first line, so that lines keep their numbers.
    lines = BROKEN.sub(r"\1\2\n", text).splitlines()
    assigned: dict[str, int] = {}
    reported: set[str] = set()
    for number, line in enumerate(lines, start=FIRST_LINE):
        code = re.sub(r"'[^']*'", "", line.split("%")[0])
        found = ASSIGNMENT.match(code)
        used = NAME.findall(found.group(2) if found else code)
        for name in used:
            if name not in assigned and name not in KNOWN and name not in reported:
                reported.add(name)
                yield _unassigned(name, number, line.strip(), assigned)
        if found:
            assigned[found.group(1)] = number


def _unassigned(name: str, line: int, code: str, assigned: dict[str, int]) -> PrintedVerdict:
    alike = [other for other in assigned if other.casefold() == name.casefold()]
    near = alike or [other for other in assigned if other.startswith(name)]
    near = near or difflib.get_close_matches(name, assigned, n=1)
    nearest = " and ".join(f"{other} (line {assigned[other]})" for other in near) or "nothing like it"
    reason = f"no line above assigns {name}; assigned are {nearest}: MATLAB stops here"
    # Of theta3a and theta3b the listing's own lines below go on with the last one.
    right = f"{near[-1]} in place of {name}" if near else None
    kind = VerdictKind.MISPRINT if near else VerdictKind.NOT_REPRODUCIBLE
    return PrintedVerdict("002", "MATLAB listing", line, name, "formula", "", code, None, None, kind, reason, right)
