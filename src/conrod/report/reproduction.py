"""The command that makes a report again, as the report prints it."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

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
