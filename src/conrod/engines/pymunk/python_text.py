"""Python source text of numbers, names and calls, with lines that fit."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable

LINE_LENGTH = 120
INDENT = 4


def number(value: float) -> str:
    """A float as Python source that reads back to the same bits."""
    # Without the sign of a zero.
    return repr(float(value) + 0.0) if math.isfinite(value) else "math.inf" if value > 0.0 else "-math.inf"


def numbers(values: Iterable[float]) -> str:
    """A tuple of floats as Python source."""
    return f"({', '.join(map(number, values))})"


def string_literal(name: str) -> str:
    """A name, with any characters, as a Python string literal."""
    return json.dumps(name, ensure_ascii=False)


def one_line(name: str) -> str:
    """A name as text of a comment, with characters that would end the comment replaced."""
    return "".join(c if c.isprintable() else " " for c in name)


def docstring(paragraphs: str) -> str:
    """Escape paragraphs for a docstring, so that nothing in them can end it."""
    shown = "".join(c if c.isprintable() or c == "\n" else " " for c in paragraphs)
    return shown.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')


def call(function: str, arguments: list[str], indent: int, before: int) -> str:
    """A call as Python source, on one line or several; without a function it is a tuple.

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


def conditional_expression(driven: str, undriven: str, condition: str = "drive") -> str:
    """Python expression with one value if the crank is driven and another if not.

    Args:
        driven, undriven: the two values as Python source; if they are equal, the expression is that source alone.
        condition: name in the module that is true if the crank is driven.
    """
    return driven if driven == undriven else f"{driven} if {condition} else {undriven}"


def wrapped_conditional(driven: str, undriven: str, indent: int, before: int) -> str:
    """`conditional_expression` on one line or several.

    Args:
        indent, before: as in `call`.
    """
    whole = conditional_expression(driven, undriven)
    if driven == undriven or indent + before + len(whole) < LINE_LENGTH:
        return whole
    margin = " " * (indent + INDENT)
    return f"(\n{margin}{driven}\n{margin}if drive\n{margin}else {undriven}\n{' ' * indent})"
