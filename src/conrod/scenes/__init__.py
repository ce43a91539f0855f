"""All machines with a name: those with a closed form, and those that ship as mechanism files.

Machines of the catalogue are driven at constant speed; those of dynamics move under loads or freely, among them
chains of parallelogram four-bars of any length, `four-bar-chain-N`.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conrod.errors import InvalidInput, Named, unknown_choice
from conrod.mechanism.units import RPM as RPM
from conrod.scenes.cam_follower import CamFollower as CamFollower
from conrod.scenes.saw import Saw as Saw
from conrod.scenes.scene import Scene as Scene
from conrod.scenes.shear_press import ShearPress as ShearPress

if TYPE_CHECKING:
    from conrod.scenes.described_scene import DescribedScene

SCENES: dict[str, Scene] = Named(
    {
        "shear-press": ShearPress(),
        "saw-40rpm": Saw(speed=40.0 * RPM),
        "saw-500rpm": Saw(speed=500.0 * RPM),
        "cam-follower": CamFollower(),
    },
    "scene",
)

# Word for all machines of the catalogue on the command line.
CATALOGUE = "catalogue"
SPATIAL = "spatial"  # and for all machines in space
# Chains that appear in lists; any length from MIN_CHAIN_LENGTH to MAX_CHAIN_LENGTH has a name.
LISTED_CHAINS = (2, 10, 40)
_CATALOGUE_FOLDER, _DYNAMICS_FOLDER = (Path(__file__).parent / name for name in ("catalogue", "dynamics"))
_FILE_SUFFIX = ".toml"


@cache
def catalogue_names() -> tuple[str, ...]:
    """Names of the catalogue's machines, in alphabetical order; no file is read."""
    return tuple(sorted(path.stem for path in _CATALOGUE_FOLDER.glob(f"*{_FILE_SUFFIX}")))


@cache
def dynamics_names() -> tuple[str, ...]:
    """Names of the machines for dynamics, in alphabetical order, a few chains last; no file is read."""
    files = sorted(path.stem for path in _DYNAMICS_FOLDER.glob(f"*{_FILE_SUFFIX}"))
    return (*files, *(f"{CHAIN}{count}" for count in LISTED_CHAINS))


def catalogue_text(name: str) -> str:
    """Text of the mechanism file of a machine of the catalogue or of dynamics.

    Raises:
        InvalidInput: no machine has that name, or no chain has that length; names the choices.
    """
    count = _chain_count(name)
    if count is not None:
        from jinja2 import Template  # slow to load

        template = Template(_CHAIN_TEMPLATE.read_text(encoding="utf-8"), keep_trailing_newline=True, trim_blocks=True)
        return str(template.render(name=f"{CHAIN}{count}", count=count))
    for folder, names in ((_CATALOGUE_FOLDER, catalogue_names()), (_DYNAMICS_FOLDER, dynamics_names())):
        if name in names:
            return (folder / f"{name}{_FILE_SUFFIX}").read_text(encoding="utf-8")
    raise _unknown_scene(name)


def _unknown_scene(name: str) -> InvalidInput:
    """Return the error for an unknown scene; of one with another speed, such as saw-320rpm, with what to type."""
    names = [*SCENES, *catalogue_names(), *dynamics_names()]
    error = unknown_choice("scene", name, names, "conrod show")
    asked = re.fullmatch(r"(.+)-(\d+(?:\.\d+)?)rpm", name)
    known = [one for one in names if asked and (one == asked[1] or re.fullmatch(rf"{re.escape(asked[1])}-\d+rpm", one))]
    if asked is None or not known:
        return error
    return InvalidInput(
        f"unknown scene {name!r}: another speed is given by --set: {known[-1]} --set speed={asked[2]}rpm"
    )


def catalogue_tables(name: str) -> dict[str, Any]:
    """Tables of a machine's file, before anything is built; raises InvalidInput as `catalogue_text`."""
    return tomllib.loads(catalogue_text(name))


@cache
def catalogue_scene(name: str) -> DescribedScene:
    """Scene of a named machine file, always the same object; raises InvalidInput as `catalogue_text`."""
    from conrod.scenes.described_scene import scene_from_tables  # parsing of units is slow to load

    return scene_from_tables(catalogue_tables(name))


def scene_named(name: str) -> Scene:
    """Look up a scene by its name, in closed form or from a file.

    Raises:
        InvalidInput: no scene has that name; names the choices.
    """
    return SCENES[name] if name in SCENES else catalogue_scene(name)


def machines_in_space(names: Sequence[str]) -> list[str]:
    """Names, among those given, of machines in space or of all such machines."""
    others = [name for name in names if name not in SCENES and not Path(name).suffix]
    if not others:  # their models are slow to load
        return []
    from conrod.scenes.space import MACHINES

    return [name for name in others if name in (*MACHINES, SPATIAL)]


# -- chains ------------------------------------------------------------------------------------------------------------

# The N-four-bar problem of the IFToMM library of computational benchmark problems: one degree of freedom, and N more
# in poses where all links lie in one line.
CHAIN = "four-bar-chain-"
MIN_CHAIN_LENGTH, MAX_CHAIN_LENGTH = 2, 40  # four-bars; a mechanism file has 100 bodies at most
_CHAIN_TEMPLATE = _DYNAMICS_FOLDER / "four-bar-chain.toml.jinja"


def _chain_count(name: str) -> int | None:
    """Number of four-bars in the chain of a name; None for a name of another machine.

    Raises:
        InvalidInput: no chain has that length.
    """
    found = re.fullmatch(rf"{CHAIN}([1-9][0-9]*)", name)
    if found is None:
        return None
    count = int(found[1][: len(str(MAX_CHAIN_LENGTH)) + 1])
    if not MIN_CHAIN_LENGTH <= count <= MAX_CHAIN_LENGTH:
        raise InvalidInput(f"{name}: chains have from {MIN_CHAIN_LENGTH} to {MAX_CHAIN_LENGTH} four-bars")
    return count
