"""The command that makes a report again, as the report prints it.

How a report on several machines came about, in a sentence.
"""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from conrod.scenes import SCENES
from conrod.scenes.catalogue import CATALOGUE, catalogue_names

SCENE = "{scene}"


@dataclass(frozen=True)
class Reproduction:
    """A command of which the scenes are left open.

    Attributes:
        text: the command, quoted for a shell; the first {scene} in it stands for the scenes.
        typed: what is typed for those scenes that do not go by their names, such as a mechanism file's path, by name.
    """

    text: str
    typed: Mapping[str, str] = field(default_factory=dict)

    def of(self, *names: str) -> str:
        """The command for some scenes."""
        return self.text.replace(SCENE, " ".join(shlex.quote(self.typed.get(name, name)) for name in names), 1)

    def of_all(self, names: Collection[str]) -> str:
        """The command for all scenes of a report, in the shortest way that a user would type."""
        if set(names) == set(SCENES):
            return self.text.replace(f"{SCENE} ", "", 1)
        is_catalogue = not self.typed and set(names) == set(catalogue_names())
        return self.of(*((CATALOGUE,) if is_catalogue else names))

    def of_all_that_ship(self) -> str:
        """The command without any scene's name."""
        return self.text.replace(f"{SCENE} ", "", 1)


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
