"""Document 000: the table of the shear press, all 584 cells, and its formulas.

The exact values are those of `ShearPress`. One set of constants, cut short, reproduces the whole table: see `Worked`.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from importlib.resources import files

import numpy as np

from audits.formulas import press_steps
from audits.formulas.press import FORMULAS
from audits.formulas.published import verdict_on
from audits.judging import Case, Explanation, Item, judge
from conrod.exact.motion import Array
from conrod.models.printed.verdicts import PrintedNumber, PrintedVerdict
from conrod.scenes import ShearPress

DOCUMENT = "000"
# The table's three pages: the first angle [deg] of each and its line in the document's text.
PAGES = ((0.0, 162), (125.0, 191), (245.0, 219))
ROW = 5.0  # [deg]
MM = 1e-3
UNITS = {"y": "mm", "x": "mm", "v": "mm/s", "a": "mm/s^2"}
MEANINGS = {
    "yG": "y of G",
    "xG": "x of G",
    "vyG": "velocity of G, y",
    "vxG": "velocity of G, x",
    "ayG": "acceleration of G, y",
    "axG": "acceleration of G, x",
    "vG": "speed of G",
    "aG": "acceleration of G",
}


def verdicts() -> tuple[PrintedVerdict, ...]:
    """Every cell of the table, then every formula."""
    cells = tuple(judge(case) for case in cases(table()))
    formulas = [verdict_on(formula, press_steps.arguments()) for formula in (*FORMULAS, *press_steps.FORMULAS)]
    return cells + tuple(sorted(formulas, key=lambda verdict: verdict.line))


def table() -> list[dict[str, str]]:
    """The printed table, row by row, as text."""
    text = files("audits").joinpath("data", "shear_press_table.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def exact(degrees: Array) -> dict[str, Array]:
    """All columns from the exact motion at crank angles (T,) [deg]; mm, mm/s, mm/s^2."""
    press = ShearPress()
    point = press.motion(np.radians(degrees), press.speed).point("G")
    (x, y), (vx, vy), (ax, ay) = (array.T / MM for array in (point.position, point.velocity, point.acceleration))
    return _columns(x, y, vx, vy, ax, ay)


def worked(
    degrees: Array, pi: float = 3.14159, third: float = 0.3333, two_thirds: float = 0.6667, ninth: float = 0.1111
) -> dict[str, Array]:
    """All columns from the document's formulas with its constants cut short; arguments and units as `exact`.

    The factors 1/18 and 1/324 are whole: whether they were cut cannot be seen in the table.
    """
    press = ShearPress()
    r, a, w = press.crank / MM, press.rod / MM, press.speed
    t = degrees * pi / 180.0
    s, c = np.sin(t), np.cos(t)
    u = ninth * (a**2 - r**2 * s**2)
    vy = w * (-r * s - r**2 / 18.0 * u**-0.5 * np.sin(2.0 * t))
    ay = w**2 * (-r * c - r**4 / 324.0 * np.sin(2.0 * t) ** 2 * u**-1.5 - ninth * r**2 * np.cos(2.0 * t) * u**-0.5)
    return _columns(
        two_thirds * r * s,
        r * c + third * np.sqrt(a**2 - r**2 * s**2),
        two_thirds * w * r * c,
        vy,
        -two_thirds * w**2 * r * s,
        ay,
    )


def _columns(x: Array, y: Array, vx: Array, vy: Array, ax: Array, ay: Array) -> dict[str, Array]:
    return {
        "yG": y,
        "xG": x,
        "vyG": vy,
        "vxG": vx,
        "ayG": ay,
        "axG": ax,
        "vG": np.hypot(vx, vy),
        "aG": np.hypot(ax, ay),
    }


# What each column hangs on, for the words of a verdict.
CONSTANTS = {
    "yG": "1/3 cut to 0.3333 and pi to 3.14159",
    "xG": "2/3 taken as 0.6667",
    "vyG": "1/9 cut to 0.1111 and pi to 3.14159",
    "vxG": "2/3 taken as 0.6667",
    "ayG": "1/9 cut to 0.1111 and pi to 3.14159",
    "axG": "2/3 taken as 0.6667",
    "vG": "2/3 taken as 0.6667, 1/9 cut to 0.1111 and pi to 3.14159",
    "aG": "2/3 taken as 0.6667, 1/9 cut to 0.1111 and pi to 3.14159",
}
# A magnitude and its two components, each of which the others fix.
TRIPLES = (("vG", "vyG", "vxG"), ("aG", "ayG", "axG"))


def cases(rows: list[dict[str, str]]) -> Iterator[Case]:
    """A case for each cell of a table with the printed one's columns."""
    degrees = np.array([float(row["theta_deg"]) for row in rows])
    true, short = exact(degrees), worked(degrees)
    for k, row in enumerate(rows):
        for name, meaning in MEANINGS.items():
            item = Item(
                DOCUMENT,
                f"{name}@{row['theta_deg']}",
                "table of IV.2",
                _line(degrees[k]),
                meaning,
                f"theta = {row['theta_deg']} deg",
                PrintedNumber(row[name]),
                UNITS[name[0]],
                "shear-press",
            )
            yield Case(
                item,
                float(true[name][k]),
                "exact motion of the slider-crank",
                causes=(Explanation(CONSTANTS[name], float(short[name][k])),),
                neighbours=tuple(_neighbours(name, row)),
            )


def _line(degrees: float) -> int:
    start, line = next(page for page in reversed(PAGES) if degrees >= page[0])
    return line + round((degrees - start) / ROW)


def _neighbours(name: str, row: dict[str, str]) -> Iterator[Explanation]:
    """The value that the other two of a magnitude and its components, in the same row, make of this one."""
    for whole, *parts in TRIPLES:
        if name in parts:
            other = next(part for part in parts if part != name)
            whole_value, other_value = float(row[whole]), float(row[other])
            if whole_value > abs(other_value):
                side = float(np.copysign(np.sqrt(whole_value**2 - other_value**2), float(row[name])))
                half = 0.5 * PrintedNumber(row[whole]).last
                within = half * (whole_value + abs(other_value)) / abs(side)
                yield Explanation(f"{whole} = {row[whole]} beside {other} = {row[other]}", side, within)
        elif name == whole:
            value = math.hypot(*(float(row[part]) for part in parts))
            yield Explanation(f"{parts[0]} = {row[parts[0]]} with {parts[1]} = {row[parts[1]]}", value, 0.1)
