"""Physics engines behind one small interface: those that ship, and those that other packages bring by an entry point.

A package adds an engine with an entry point of the group `conrod.engines`, whose value is an `Engine` object::

    [project.entry-points."conrod.engines"]
    my-engine = "my_package.engine:ENGINE"
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from conrod.engines.engine import OTHER_LINE, LineStyle, Preset
from conrod.engines.engine import Engine as Engine
from conrod.errors import InvalidInput, unknown_choice

if TYPE_CHECKING:
    from conrod.engines.checked_engine import CheckedEngine

GROUP = "conrod.engines"


@dataclass(frozen=True)
class Look:
    """Title, colour and marker of an engine.

    Attributes:
        title: its name as its makers write it.
        colour: of all that is drawn of it.
        dot: marker of its runs where they are nothing in particular, as matplotlib's.
        module: that the engine's library is imported as; empty where it is the engine's name.
        distribution: that the library is installed with; empty where it is the engine's name.
        lacks: a part of the accelerations that it does not compute, for which its law allows; empty for none.
    """

    title: str
    colour: str
    dot: str = "s"
    module: str = ""
    distribution: str = ""
    lacks: str = ""


# Engines that ship, each in a package of conrod of the name of its distribution: `engine.ENGINE`, importing which loads
# the engine, and `PRESETS`, reading which does not. Okabe and Ito's colours, distinguishable by colour-blind readers.
ENGINES: Mapping[str, Look] = {"mujoco": Look("MuJoCo", "#0072B2", "o"), "pymunk": Look("pymunk", "#D55E00", "D")}
# Engines that ship and are extras to install, laid out alike. They take part where they are asked for by name.
OPTIONAL: Mapping[str, Look] = {
    "exudyn": Look("Exudyn", "#009E73", "^"),
    "box2d": Look("Box2D", "#CC79A7", "v", module="Box2D", distribution="Box2D"),
    "mjx": Look(
        "MJX",
        "#56B4E9",
        "P",
        module="mujoco.mjx",
        distribution="mujoco-mjx",
        lacks="dJ/dt v in the acceleration of its closures",
    ),
}
OTHER_COLOURS = ("#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def engine_names() -> tuple[str, ...]:
    """Names of the engines that take part unless others are asked for, those that ship first."""
    return (*ENGINES, *_brought())


def engine_packages() -> tuple[str, ...]:
    """Names of the distributions that the engines come with; of an extra where it was loaded."""
    brought = [point.dist.name for points in _brought().values() for point in points if point.dist is not None]
    loaded = [look.distribution or name for name, look in OPTIONAL.items() if (look.module or name) in sys.modules]
    return tuple(dict.fromkeys([*ENGINES, *loaded, *brought]))


def installed_extras() -> tuple[str, ...]:
    """Names of the extras that are installed."""
    return tuple(name for name, look in OPTIONAL.items() if find_spec(look.module or name) is not None)


def loadable_engines(extras: Iterable[str] = ()) -> tuple[list[Engine[Any]], list[str]]:
    """The engines that take part and some extras, and a line on each that is left out, with the reason."""
    found, left_out = list[Engine[Any]](), list[str]()
    for name in (*engine_names(), *extras):
        try:
            found.append(engine_named(name))
        except InvalidInput as error:
            left_out.append(str(error))
    return found, left_out


def is_brought(name: str) -> bool:
    """True if an engine is another package's."""
    return name in _brought()


def origin_of(name: str) -> str:
    """Origin of an engine: conrod, or the distribution that brings it."""
    return " and ".join(sorted(map(_distribution, _brought().get(name, [])))) or "conrod"


@cache
def engine_named(name: str) -> Engine[Any]:
    """The engine of a name.

    Raises:
        InvalidInput: there is none, with the choices; or it cannot be loaded, is no engine, or is an extra that is not
            installed.
    """
    if name in OPTIONAL and name not in installed_extras():
        raise InvalidInput(f"engine {name!r} is an extra that is not installed: pip install 'conrod[{name}]'")
    if name in ENGINES or name in OPTIONAL:
        return _shipped(name)
    if name not in _brought():
        raise unknown_choice("engine", name, (*engine_names(), *OPTIONAL))
    if len(points := _brought()[name]) > 1:
        both = " and ".join(sorted(_distribution(point) for point in points))
        raise InvalidInput(f"engine {name!r} is brought by {both}: uninstall all but one of them")
    return load_brought(name)


def _shipped(name: str) -> Engine[Any]:
    point = EntryPoint(name, f"conrod.engines.{name}.engine:ENGINE", GROUP)
    if name in ENGINES:
        own: Engine[Any] = point.load()  # that it cannot be, for want of memory, is for the run to say
        return own
    try:
        extra: Engine[Any] = point.load()
    except (Exception, SystemExit) as error:  # importing it runs code of another package
        raise InvalidInput(f"engine {name!r} cannot be loaded from {point.value}: {error!r}") from error
    return extra


@cache
def loaded_engine(name: str) -> CheckedEngine:
    """The engine of another package, loaded into this process.

    Raises:
        InvalidInput: it cannot be loaded, or is no engine.
    """
    from conrod.engines.checked_engine import CheckedEngine, numpy_functions
    from conrod.engines.door import EngineFault, guarded

    unchanged = numpy_functions()
    (point,) = _brought()[name]
    where = f"{point.value} ({_distribution(point)})"
    try:
        with guarded():
            engine = point.load()
            right = isinstance(engine, Engine) and engine.name == name
            found = CheckedEngine(engine, name, unchanged) if right else None
    except EngineFault as fault:
        raise InvalidInput(f"engine {name!r} cannot be loaded from {where}: {fault}") from None
    if found is None:
        raise InvalidInput(f"engine {name!r}: {where} is no object of a class that extends Engine, of this name")
    return found


# How an engine of another package is had: loaded here, or where a process pursues studies, in one of its own.
load_brought: Callable[[str], Engine[Any]] = loaded_engine


def look_of(name: str) -> Look:
    """The look of an engine, be it installed or not."""
    return ENGINES.get(name) or OPTIONAL.get(name) or Look(name, OTHER_COLOURS[sum(name.encode()) % len(OTHER_COLOURS)])


def presets_of(name: str) -> Mapping[str, Preset[Any]]:
    """Presets of an engine; none of one that is not installed."""
    if name in ENGINES or name in OPTIONAL:
        presets: Mapping[str, Preset[Any]] = import_module(f"conrod.engines.{name}").PRESETS
        return presets
    try:
        return engine_named(name).presets
    except InvalidInput:
        return {}


def line_style(engine: str, preset: str | None) -> LineStyle:
    """The line of a preset's curves; that of others where it is not known."""
    found = presets_of(engine).get(preset or "")
    return OTHER_LINE if found is None else found.style


@cache
def _brought() -> dict[str, list[EntryPoint]]:
    """Entry points by name, one of each distribution; an engine that ships is not replaced."""
    found: dict[str, dict[str, EntryPoint]] = {}
    for point in entry_points(group=GROUP):
        found.setdefault(point.name, {}).setdefault(_distribution(point), point)
    return {name: list(points.values()) for name, points in found.items() if name not in {**ENGINES, **OPTIONAL}}


def _distribution(point: EntryPoint) -> str:
    return "conrod" if point.dist is None else f"{point.dist.name} {point.dist.version}"
