"""Settings as plain values, of which keys and reports are made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# Fields that settings gained after results had been kept, with the value that all runs before them had. Where a field
# has it, it is not told: keys of results, and reports, stay what they were.
LATER_FIELDS: Mapping[str, Any] = {"refsafe": True, "rounded_state": False, "dressing": [], "cam": "contact"}


def plain(settings: object) -> dict[str, Any]:
    """The fields of a settings object as values that JSON has, later ones only where they differ from before."""
    # `dataclasses.asdict` would copy each value, which took most of the time to find a finished run.
    values = {name: list(value) if isinstance(value, tuple) else value for name, value in vars(settings).items()}
    for name, before in LATER_FIELDS.items():
        if values.get(name) == before:
            del values[name]
    return values
