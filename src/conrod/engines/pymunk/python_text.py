"""Python source text of numbers, names and calls, with lines that fit."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable

LINE_LENGTH = 120
INDENT = 4


def number(value: float) -> str:
    """A float as Python that gives its very bits."""
    # Without the sign of a zero.
    return repr(float(value) + 0.0) if math.isfinite(value) else "math.inf" if value > 0.0 else "-math.inf"


def numbers(values: Iterable[float]) -> str:
    """A tuple of floats as Python."""
    return f"({', '.join(map(number, values))})"


def quoted(name: str) -> str:
    """A name as a Python string; a user's file may hold any characters."""
    return json.dumps(name, ensure_ascii=False)


def one_line(name: str) -> str:
    """A name as the text of a comment, which no character in it can end."""
    return "".join(c if c.isprintable() else " " for c in name)


def docstring(paragraphs: str) -> str:
    """Text for between three quotation marks, which nothing in it can end."""
    shown = "".join(c if c.isprintable() or c == "\n" else " " for c in paragraphs)
    return shown.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')


def call(function: str, arguments: list[str], indent: int, before: int) -> str:
    """A call as Python, over several lines if it would not fit into one; without a function it is a tuple.

    Args:
        indent: of the line that the call begins on [characters].
        before: characters on that line before the call; a comma follows it.
    """
    whole = f"{function}({', '.join(arguments)})"
    if indent + before + len(whole) < LINE_LENGTH:
        return whole
    margin, end = " " * (indent + INDENT), " " * indent
    joined = ", ".join(arguments)
    if function and len(margin) + len(joined) <= LINE_LENGTH:
        return f"{function}(\n{margin}{joined}\n{end})"
    lines = "".join(f"{margin}{argument},\n" for argument in arguments)
    return f"{function}(\n{lines}{end})"


def choice(driven: str, undriven: str, condition: str = "drive") -> str:
    """An expression whose value depends on whether the crank is driven, where it does."""
    return driven if driven == undriven else f"{driven} if {condition} else {undriven}"


def lined_choice(driven: str, undriven: str, indent: int, before: int) -> str:
    """The same, over several lines if it would not fit into one."""
    whole = choice(driven, undriven)
    if driven == undriven or indent + before + len(whole) < LINE_LENGTH:
        return whole
    margin = " " * (indent + INDENT)
    return f"(\n{margin}{driven}\n{margin}if drive\n{margin}else {undriven}\n{' ' * indent})"
