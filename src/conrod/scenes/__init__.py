"""Every machine that has a name: those whose motion is known in closed form, and those that ship as mechanism files.

Those of the catalogue are driven at constant speed; those of dynamics go under loads or in free motion, among them
chains of parallelogram four-bars of any length, `four-bar-chain-N`.
"""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conrod.errors import InvalidInput, Named, unknown_choice
from conrod.scenes.cam_follower import CamFollower as CamFollower
from conrod.scenes.scene import Scene as Scene
from conrod.scenes.slider_cranks import RPM as RPM
from conrod.scenes.slider_cranks import Saw as Saw
from conrod.scenes.slider_cranks import ShearPress as ShearPress

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

# The word that stands for the machines of the catalogue on the command line.
CATALOGUE = "catalogue"
# The chains that lists name; there is one for every count between LEAST_CHAIN and MOST_CHAIN.
LISTED_CHAINS = (2, 10, 40)
_MACHINES, _DYNAMICS = (Path(__file__).parent / name for name in ("catalogue", "dynamics"))
_ENDING = ".toml"


@cache
def catalogue_names() -> tuple[str, ...]:
    """Names of the machines of the catalogue, in alphabetical order; no file is read."""
    return tuple(sorted(path.stem for path in _MACHINES.glob(f"*{_ENDING}")))


@cache
def dynamics_names() -> tuple[str, ...]:
    """Names of the machines of dynamics, in alphabetical order, a few of the chains last; no file is read."""
    files = sorted(path.stem for path in _DYNAMICS.glob(f"*{_ENDING}"))
    return (*files, *(f"{CHAIN}{count}" for count in LISTED_CHAINS))


def catalogue_text(name: str) -> str:
    """The mechanism file of a machine, of the catalogue or of dynamics.

    Raises:
        InvalidInput: there is none of that name, or no chain of that length; names the choices.
    """
    count = _chain_count(name)
    if count is not None:
        from jinja2 import Template  # takes its time to load

        template = Template(_CHAIN.read_text(encoding="utf-8"), keep_trailing_newline=True, trim_blocks=True)
        return str(template.render(name=f"{CHAIN}{count}", count=count))
    for folder, names in ((_MACHINES, catalogue_names()), (_DYNAMICS, dynamics_names())):
        if name in names:
            return (folder / f"{name}{_ENDING}").read_text(encoding="utf-8")
    raise unknown_choice("scene", name, [*SCENES, *catalogue_names(), *dynamics_names()])


def catalogue_tables(name: str) -> dict[str, Any]:
    """What stands in the file of a machine, of which nothing is built; raises InvalidInput as `catalogue_text`."""
    return tomllib.loads(catalogue_text(name))


@cache
def catalogue_scene(name: str) -> DescribedScene:
    """The machine of a name, always the same object; raises InvalidInput as `catalogue_text`."""
    from conrod.scenes.described_scene import scene_of  # what reads units takes its time to load

    return scene_of(catalogue_tables(name))


def scene_named(name: str) -> Scene:
    """The scene in closed form, or the machine from a file, that has a name.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    return SCENES[name] if name in SCENES else catalogue_scene(name)


# -- chains ------------------------------------------------------------------------------------------------------------

# The N-four-bar problem of the IFToMM library of computational benchmark problems: one degree of freedom, but where
# all links lie in one line, where it gains N more.
CHAIN = "four-bar-chain-"
LEAST_CHAIN, MOST_CHAIN = 2, 40  # a mechanism file has 100 bodies at most
_CHAIN = _DYNAMICS / "four-bar-chain.toml.jinja"


def _chain_count(name: str) -> int | None:
    """Number of four-bars of the chain of a name; None of a name that is no chain's.

    Raises:
        InvalidInput: there is no chain of that length.
    """
    found = re.fullmatch(rf"{CHAIN}([1-9][0-9]*)", name)
    if found is None:
        return None
    count = int(found[1][: len(str(MOST_CHAIN)) + 1])
    if not LEAST_CHAIN <= count <= MOST_CHAIN:
        raise InvalidInput(f"{name}: chains have from {LEAST_CHAIN} to {MOST_CHAIN} four-bars")
    return count
