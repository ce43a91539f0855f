"""The command that makes a report again, as the report prints it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field

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

    def of_all_that_ship(self) -> str:
        """The command without any scene's name."""
        return self.text.replace(f"{SCENE} ", "", 1)
