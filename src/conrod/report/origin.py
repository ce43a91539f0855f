"""How a report on several machines came about, in a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def told_origin(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    """The one command that makes all pages, or that each page names its own.

    Args:
        scenes: entries of a report's document by the machine's name, at least one; `commands` are those, one or more,
            that made its page.
    """
    commands = {name: scene["commands"] for name, scene in scenes.items()}
    same = {command.replace(name, "", 1) for name, each in commands.items() for command in each}
    if len(same) > 1 or any(len(each) > 1 for each in commands.values()):
        return "The machines were not all looked at by one command: each page names its own."
    first, command = next((name, each[0]) for name, each in commands.items())
    return f"Reproduced by `{command.replace(first, ' '.join(commands), 1)}`; each page names its own command."
