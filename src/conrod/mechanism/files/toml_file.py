"""TOML files of users: read whole, within limits; data alone, of which nothing is executed or followed."""

from __future__ import annotations

import os
import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput

# A machine of 50 links takes 15 kB.
MOST_BYTES = 256 * 1024
# Tables in lists in tables: a file of the format needs 5, the parser itself gives up at some hundred.
MOST_DEPTH = 20
_PART = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_DEPTH}}}")
# A table's heading and a field at the beginning of a line; a place in a message, without the index in a list.
HEADING = re.compile(rf"\s*\[+\s*(?P<place>{_PART}(?:\s*\.\s*{_PART})*)\s*\]")
FIELD = re.compile(rf"\s*(?P<place>{_PART}(?:\s*\.\s*{_PART})*)\s*=")
PLACE = re.compile(r"[A-Za-z0-9_-]+(?:\.[A-Za-z0-9_-]+)*")
UNKNOWN_FIELD = re.compile(r"^unknown field(?: in ([^ ]+))? '([^']+)'")
DECIMAL_COMMA = re.compile(r"=\s*[+-]?\d+,\d")


def read_tables(path: Path) -> dict[str, Any]:
    """The tables of a file; raises InvalidInput where it cannot be read, or is no TOML; names the file and the line."""
    try:
        return parse(_content(path))
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None
    except FileNotFoundError:
        raise InvalidInput(f"{path}: there is no such file") from None
    except OSError as error:
        raise InvalidInput(f"{path}: it cannot be read: {error.strerror or error}") from None


def parse(content: bytes) -> dict[str, Any]:
    """The tables of a TOML text; raises InvalidInput where it is none; says where."""
    try:
        text = content.decode("utf-8-sig")  # some editors begin a file with a byte order mark
    except UnicodeDecodeError as error:
        raise InvalidInput(f"it is no text in UTF-8: byte {error.start} cannot be read; save it as UTF-8") from None
    _check_keys(text)
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise InvalidInput("its lists or tables lie too deep inside each other") from None
    except ValueError as error:  # TOMLDecodeError is one; numbers of too many digits raise another one
        raise InvalidInput(f"it is no TOML: {' '.join(str(error).split())[:200]}{_comma(text, error)}") from None
    _check_depth(tables)
    return tables


def line_of(text: str, message: str) -> int | None:
    """Line in which the first field stands that a message names by its place; None where it names none."""
    lines, table = dict[str, int](), ""
    for number, line in enumerate(text.splitlines(), 1):
        heading, field = HEADING.match(line), FIELD.match(line)
        table = heading["place"] if heading else table
        place = table if heading else f"{table}.{field['place']}".lstrip(".") if field else ""
        lines.setdefault(re.sub(r"[\s\"']", "", place), number)
    unknown = [f"{place}.{field}".lstrip(".") for place, field in UNKNOWN_FIELD.findall(message)]
    for named in (*unknown, *PLACE.findall(message)):
        parts = named.split(".")
        # What stands in an inline table is in the line of that: the nearest place that has one of its own.
        around = (lines.get(".".join(parts[:k])) for k in range(len(parts), 0, -1))
        found = next((line for line in around if line is not None), None)
        # A single word may be any word of a sentence but the first.
        if found is not None and (len(parts) > 1 or named in unknown or message.startswith(named)):
            return found
    return None


def _comma(text: str, error: ValueError) -> str:
    """A word on a decimal comma, if one stands in the line that an error names."""
    named = re.search(r"at line (\d+)", str(error))
    line = text.splitlines()[int(named.group(1)) - 1 :][:1] if named else []
    return "; decimals are written with a point, not with a comma" if line and DECIMAL_COMMA.search(line[0]) else ""


def _content(path: Path) -> bytes:
    # Looked at once it is open: what a name stands for may change, and a pipe would never end.
    with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise InvalidInput("it is no regular file")
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise InvalidInput(f"it is too large: at most {MOST_BYTES // 1024} KiB are read")
    return content


def _check_keys(text: str) -> None:
    """Refuse dotted names of very many parts, for which the parser takes time by their square or worse."""
    found = LONG_KEY.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise InvalidInput(f"line {line}: a name of more than {MOST_DEPTH} parts with dots between them")


def _check_depth(tables: dict[str, Any]) -> None:
    """Refuse what is nested deeper than any reader of it would go."""
    layer: list[Any] = [tables]
    for _ in range(MOST_DEPTH):
        layer = [
            inner
            for outer in layer
            for inner in (outer.values() if isinstance(outer, dict) else outer)
            if isinstance(inner, dict | list)
        ]
        if not layer:
            return
    raise InvalidInput("its lists or tables lie too deep inside each other")
