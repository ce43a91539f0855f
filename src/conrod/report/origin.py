"""How a report on several machines came about, in a sentence."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any


def told_origin(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    """The one command that makes all pages, or that each page names its own.

    Args:
        scenes: entries of a report's document by the machine's name, at least one; `commands` are those, one or more,
            that made its page.
    """
    commands = {name: scene["commands"] for name, scene in scenes.items()}
    same = {_for(command, name, "") for name, each in commands.items() for command in each}
    if len(same) > 1 or any(len(each) > 1 for each in commands.values()):
        return "The machines were not all looked at by one command: each page names its own."
    first, command = next((name, each[0]) for name, each in commands.items())
    return f"Reproduced by `{_for(command, first, ' '.join(commands))}`; each page names its own command."


def _for(command: str, name: str, others: str) -> str:
    """A command with other names in a machine's place; as it is where a file was typed in it."""
    return command.replace(f" {name} ", f" {others} ", 1) if shlex.split(command)[2:3] == [name] else command
