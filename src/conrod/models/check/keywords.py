"""Keywords of `conrod.check` that are spelled in another way now."""

from __future__ import annotations

from collections.abc import Iterable

from conrod.errors import InvalidInput

NEW_KEYWORDS = {
    "point": "points", "drive": "drives", "column": "columns", "unit": "units", "ctrl": "controls", "engine": "engines"
}  # fmt: skip


def refuse_old_keywords(names: Iterable[str]) -> None:
    """Refuse a keyword of an earlier conrod; raises InvalidInput, which gives the new one."""
    for name in names:
        if name in NEW_KEYWORDS:
            raise InvalidInput(f"{name}=... is now {NEW_KEYWORDS[name]}=...")
        if name == "set":
            raise InvalidInput("set=... is gone: make the scene with its parameters, conrod.scene(NAME, crank='80 mm')")
