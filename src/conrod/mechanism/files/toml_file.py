"""TOML files of users: read whole, within limits; data alone, of which nothing is executed or followed."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput

# A machine of 50 links takes 15 kB.
MOST_BYTES = 256 * 1024
# Dotted names of many parts take the parser time by the square of their number. A file of the format needs 5 parts, and
# none in quotes.
LONG_NAME = re.compile(r"(?<![A-Za-z0-9_-])(?:[A-Za-z0-9_-]++[ \t]*+\.[ \t]*+){20}")
QUOTED_PART = re.compile(r"""["'][ \t]*+\.""")
LONG_NUMBER = re.compile(r"[0-9_]{1000}")


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
    for number, line in enumerate(text.split("\n"), 1):
        if LONG_NAME.search(line) or len(QUOTED_PART.findall(line)) > 20 or LONG_NUMBER.search(line):
            raise InvalidInput(f"line {number}: names of more than 20 parts and numbers of 1000 digits are not read")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InvalidInput("its lists or tables lie too deep inside each other") from None
    except ValueError as error:
        raise InvalidInput(f"it is no TOML: {' '.join(str(error).split())[:200]}") from None


def _content(path: Path) -> bytes:
    if not path.is_file():
        raise InvalidInput("it is no regular file" if path.exists() else "there is no such file")
    with path.open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise InvalidInput(f"it is too large: at most {MOST_BYTES // 1024} KiB are read")
    return content
