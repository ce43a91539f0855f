"""TOML files of users: read whole, within limits; data alone, of which nothing is executed or followed."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput

# A machine of 50 links takes 15 kB.
MOST_BYTES = 256 * 1024
_PART = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
# A table's heading and a field at the beginning of a line; a place in a message, without the index in a list.
HEADING = re.compile(rf"\s*\[+\s*(?P<place>{_PART}(?:\s*\.\s*{_PART})*)\s*\]")
FIELD = re.compile(rf"\s*(?P<place>{_PART}(?:\s*\.\s*{_PART})*)\s*=")
PLACE = re.compile(r"[A-Za-z0-9_-]+(?:\.[A-Za-z0-9_-]+)*")
UNKNOWN_FIELD = re.compile(r"^unknown field(?: in ([^ ]+))? '([^']+)'")


def read_tables(path: Path) -> dict[str, Any]:
    """The tables of a file; raises InvalidInput where it cannot be read, or is no TOML; names the file and the line."""
    try:
        return parse(_content(path))
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None
    except OSError as error:
        raise InvalidInput(f"{path}: it cannot be read: {error.strerror or error}") from None


def parse(content: bytes) -> dict[str, Any]:
    """The tables of a TOML text; raises InvalidInput where it is none; says where."""
    try:
        text = content.decode("utf-8-sig")  # some editors begin a file with a byte order mark
    except UnicodeDecodeError as error:
        raise InvalidInput(f"it is no text in UTF-8: byte {error.start} cannot be read; save it as UTF-8") from None
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InvalidInput("its lists or tables lie too deep inside each other") from None
    except ValueError as error:  # TOMLDecodeError is one; numbers of too many digits raise another one
        raise InvalidInput(f"it is no TOML: {' '.join(str(error).split())[:200]}") from None


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


def _content(path: Path) -> bytes:
    if not path.is_file():
        raise InvalidInput("it is no regular file" if path.exists() else "there is no such file")
    with path.open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise InvalidInput(f"it is too large: at most {MOST_BYTES // 1024} KiB are read")
    return content
