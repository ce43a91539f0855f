"""The machines that ship as mechanism files, and every machine that has a name."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from conrod.errors import unknown_choice
from conrod.scenes import SCENES, Scene
from conrod.scenes.dynamics import dynamics_names, dynamics_scene, is_dynamics_name

if TYPE_CHECKING:
    from conrod.scenes.described_scene import DescribedScene

# The word that stands for all of them on the command line.
CATALOGUE = "catalogue"
_FOLDER = Path(__file__).parent
_ENDING = ".toml"


@dataclass(frozen=True)
class Heading:
    """What a line about a machine tells, read from its file without building anything.

    Attributes:
        links: moving ones.
        one_pass: whether its input cannot turn fully and is driven once from one angle to another.
    """

    title: str
    source: str
    links: int
    one_pass: bool


@cache
def catalogue_names() -> tuple[str, ...]:
    """Names of the machines, in alphabetical order; no file is read."""
    return tuple(sorted(path.stem for path in _FOLDER.glob(f"*{_ENDING}")))


def catalogue_file(name: str) -> Path:
    """The file of a machine.

    Raises:
        InvalidInput: there is none of that name; names the choices.
    """
    if name not in catalogue_names():
        raise unknown_choice("machine of the catalogue", name, catalogue_names())
    return _FOLDER / f"{name}{_ENDING}"


def catalogue_heading(name: str) -> Heading:
    """What is told of a machine in a line; raises InvalidInput as `catalogue_file`."""
    tables = tomllib.loads(catalogue_file(name).read_text(encoding="utf-8"))
    return Heading(tables["title"], tables["source"], len(tables["bodies"]), "from" in tables["driver"])


@cache
def catalogue_scene(name: str) -> DescribedScene:
    """The machine of a name, always the same object; raises InvalidInput as `catalogue_file`."""
    from conrod.scenes.described_scene import read_scene  # what reads units takes its time to load

    return read_scene(catalogue_file(name))


def scene_named(name: str) -> Scene:
    """The scene in closed form, the machine of the catalogue, or the scene of dynamics, that has a name.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    if name in SCENES:
        return SCENES[name]
    if name in catalogue_names():
        return catalogue_scene(name)
    if is_dynamics_name(name):
        return dynamics_scene(name)
    raise unknown_choice("scene", name, [*SCENES, *catalogue_names(), *dynamics_names()])
