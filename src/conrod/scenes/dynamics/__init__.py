"""Scenes of dynamics that have a name: machines under loads or in free motion, as mechanism files that ship."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from conrod.errors import unknown_choice
from conrod.scenes.dynamics.chain import CHAIN, chain_count, chain_text

if TYPE_CHECKING:
    from conrod.scenes.described_scene import DescribedScene

# The chains that lists name; there is one for every count between LEAST and MOST.
LISTED_CHAINS = (2, 10, 40)
_FOLDER = Path(__file__).parent
_ENDING = ".toml"


@dataclass(frozen=True)
class DynamicsHeading:
    """What a line about a scene tells, read from its text without building anything.

    Attributes:
        links: moving ones.
    """

    title: str
    source: str
    links: int


@cache
def dynamics_names() -> tuple[str, ...]:
    """Names of the scenes, in alphabetical order, a few of the chains among them; no file is read."""
    files = (path.stem for path in _FOLDER.glob(f"*{_ENDING}"))
    return tuple(sorted(files)) + tuple(f"{CHAIN}{count}" for count in LISTED_CHAINS)


def is_dynamics_name(name: str) -> bool:
    """Whether a scene of dynamics has this name, or a chain would have.

    Raises:
        InvalidInput: it is a chain's, of a length that there is none of.
    """
    return name in dynamics_names() or chain_count(name) is not None


def dynamics_text(name: str) -> str:
    """The mechanism file of a scene.

    Raises:
        InvalidInput: there is none of that name; names the choices.
    """
    count = chain_count(name)
    if count is not None:
        return chain_text(count)
    if name not in dynamics_names():
        raise unknown_choice("scene of dynamics", name, dynamics_names())
    return (_FOLDER / f"{name}{_ENDING}").read_text(encoding="utf-8")


def dynamics_heading(name: str) -> DynamicsHeading:
    """What is told of a scene in a line; raises InvalidInput as `dynamics_text`."""
    tables = tomllib.loads(dynamics_text(name))
    return DynamicsHeading(tables["title"], tables["source"], len(tables["bodies"]))


@cache
def dynamics_scene(name: str) -> DescribedScene:
    """The scene of a name, always the same object; raises InvalidInput as `dynamics_text`."""
    from conrod.scenes.described_scene import scene_of  # what reads units takes its time to load

    return scene_of(tomllib.loads(dynamics_text(name)))
