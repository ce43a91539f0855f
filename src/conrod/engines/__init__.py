"""The engines that conrod knows: those that ship with it, and plugins of other packages (entry points).

A package adds an engine with an entry point of the group `conrod.engines`, whose value is an `Engine` object::

    [project.entry-points."conrod.engines"]
    my-engine = "my_package.engine:ENGINE"
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points, version
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from conrod.engines.engine import DEFAULT_LINE, LineStyle, Preset
from conrod.engines.engine import Engine as Engine
from conrod.errors import InvalidInput, unknown_choice

if TYPE_CHECKING:
    from conrod.engines.checked_plugin import CheckedPlugin

ENTRY_POINT_GROUP = "conrod.engines"


@dataclass(frozen=True)
class EngineStyle:
    """Title, colour and marker with which reports show an engine, and where its library comes from.

    Attributes:
        title: the engine's name as its makers write it.
        colour: of its curves and markers.
        marker: of single runs, in matplotlib's notation.
        module: name under which the engine's library is imported; empty if it is the engine's name.
        distribution: name under which the library is installed; empty if it is the engine's name.
        model_ending: ending of the names of its model files, if it writes any.
        missing_term: term that the engine leaves out of its accelerations, which its error law allows for; or empty.
        first_run: what its first run on a machine does and how long that takes, if it is minutes; or empty.
    """

    title: str
    colour: str
    marker: str = "s"
    module: str = ""
    distribution: str = ""
    model_ending: str = ".xml"
    missing_term: str = ""
    first_run: str = ""


# Engines that ship, each in the package `conrod.engines.NAME`: importing `engine.NAME_ENGINE` loads the engine, and
# importing `NAME_PRESETS` does not. Colours are Okabe and Ito's, and one of Tol's,
# which colour-blind readers can tell apart.
ENGINES: Mapping[str, EngineStyle] = {
    "mujoco": EngineStyle("MuJoCo", "#0072B2", "o"),
    "pymunk": EngineStyle("pymunk", "#D55E00", "D", model_ending=".py"),
}
# Engines that ship as optional extras, laid out alike. They run only when they are named.
OPTIONAL_ENGINES: Mapping[str, EngineStyle] = {
    "exudyn": EngineStyle("Exudyn", "#009E73", "^"),
    "drake": EngineStyle("Drake", "#000000", "h", module="pydrake", distribution="drake"),
    "box2d": EngineStyle("Box2D", "#CC79A7", "v", module="Box2D", distribution="Box2D"),
    "mjx": EngineStyle(
        "MJX",
        "#56B4E9",
        "P",
        module="mujoco.mjx",
        distribution="mujoco-mjx",
        missing_term="dJ/dt v in the acceleration of its closures",
    ),
    "newton": EngineStyle(
        "Newton",
        "#E69F00",
        "X",
        first_run="Newton compiles kernels where a solver first runs, for minutes, and keeps them in ~/.cache/warp",
    ),
    "rapier": EngineStyle("Rapier", "#882255", "<", module="rapier3d", distribution="rapier3d"),
}
PLUGIN_COLOURS = ("#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def engine_names() -> tuple[str, ...]:
    """Names of the engines that run by default: MuJoCo and pymunk, then installed plugins."""
    return (*ENGINES, *plugin_entry_points())


def engine_packages() -> tuple[str, ...]:
    """Names of the distributions of the default engines, and of the extras that were imported."""
    brought = [
        point.dist.name for points in plugin_entry_points().values() for point in points if point.dist is not None
    ]
    loaded = [
        look.distribution or name for name, look in OPTIONAL_ENGINES.items() if (look.module or name) in sys.modules
    ]
    return tuple(dict.fromkeys([*ENGINES, *loaded, *brought]))


def environment() -> dict[str, str]:
    """Return the versions of Python and packages, the machine and the system."""
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
        **{name: version(name) for name in (*engine_packages(), "numpy")},
    }


def installed_extras() -> tuple[str, ...]:
    """Names of the optional engines whose library is installed."""
    return tuple(name for name, look in OPTIONAL_ENGINES.items() if find_spec(look.module or name) is not None)


def loadable_engines(extras: Iterable[str] = ()) -> tuple[list[Engine[Any]], list[str]]:
    """Load the default engines and the extras named; return them, and one line for each that fails."""
    found, left_out = list[Engine[Any]](), list[str]()
    for name in (*engine_names(), *extras):
        try:
            found.append(engine_named(name))
        except InvalidInput as error:
            left_out.append(str(error))
    return found, left_out


def is_plugin(name: str) -> bool:
    """Return True if another package provides the engine."""
    return name in plugin_entry_points()


def origin_of(name: str) -> str:
    """Name and version of the package that provides an engine; "conrod" for a shipped engine."""
    return " and ".join(sorted(map(_distribution_name, plugin_entry_points().get(name, [])))) or "conrod"


@cache
def engine_named(name: str) -> Engine[Any]:
    """Load an engine by its name, once in a process.

    Raises:
        InvalidInput: there is none, with the choices; or it cannot be loaded, is no engine, or is an extra that is not
            installed.
    """
    if name in OPTIONAL_ENGINES and name not in installed_extras():
        raise InvalidInput(f"engine {name!r} is an extra that is not installed: pip install 'conrod[{name}]'")
    if name in ENGINES or name in OPTIONAL_ENGINES:
        return _load_shipped(name)
    if name not in plugin_entry_points():
        raise unknown_choice("engine", name, (*engine_names(), *OPTIONAL_ENGINES))
    if len(points := plugin_entry_points()[name]) > 1:
        both = " and ".join(sorted(_distribution_name(point) for point in points))
        raise InvalidInput(f"engine {name!r} is brought by {both}: uninstall all but one of them")
    return load_plugin(name)


def _load_shipped(name: str) -> Engine[Any]:
    """Load an engine that ships with conrod."""
    point = EntryPoint(name, f"conrod.engines.{name}.engine:{name.upper()}_ENGINE", ENTRY_POINT_GROUP)
    if name in ENGINES:
        own: Engine[Any] = point.load()  # that it cannot be, for want of memory, is for the run to say
        return own
    try:
        extra: Engine[Any] = point.load()
    except (Exception, SystemExit) as error:  # importing it runs code of another package
        raise InvalidInput(f"engine {name!r} cannot be loaded from {point.value}: {error!r}") from error
    return extra


@cache
def load_plugin_here(name: str) -> CheckedPlugin:
    """Load a plugin's engine into this process, with its results checked.

    Raises:
        InvalidInput: the plugin cannot be loaded, or is no engine.
    """
    from conrod.engines.checked_plugin import CheckedPlugin, numpy_functions
    from conrod.engines.plugin_values import EngineFault, catch_faults

    unchanged = numpy_functions()
    (point,) = plugin_entry_points()[name]
    where = f"{point.value} ({_distribution_name(point)})"
    try:
        with catch_faults():
            engine = point.load()
            right = isinstance(engine, Engine) and engine.name == name
            found = CheckedPlugin(engine, name, unchanged) if right else None
    except EngineFault as fault:
        raise InvalidInput(f"engine {name!r} cannot be loaded from {where}: {fault}") from None
    if found is None:
        raise InvalidInput(f"engine {name!r}: {where} is no object of a class that extends Engine, of this name")
    return found


# How a plugin's engine is loaded: into this process, or, in a process that runs studies, into a separate one.
load_plugin: Callable[[str], Engine[Any]] = load_plugin_here


def engine_style(name: str) -> EngineStyle:
    """Style of an engine in reports, whether it is installed or not."""
    return (
        ENGINES.get(name)
        or OPTIONAL_ENGINES.get(name)
        or EngineStyle(name, PLUGIN_COLOURS[sum(name.encode()) % len(PLUGIN_COLOURS)])
    )


def presets_of(name: str) -> Mapping[str, Preset[Any]]:
    """Presets of an engine by name; empty if the engine is not installed."""
    if name in ENGINES or name in OPTIONAL_ENGINES:
        presets: Mapping[str, Preset[Any]] = getattr(import_module(f"conrod.engines.{name}"), f"{name.upper()}_PRESETS")
        return presets
    try:
        return engine_named(name).presets
    except InvalidInput:
        return {}


def line_style(engine: str, preset: str | None) -> LineStyle:
    """Line style of a preset's curves; the default one for an unknown preset."""
    found = presets_of(engine).get(preset or "")
    return DEFAULT_LINE if found is None else found.style


@cache
def plugin_entry_points() -> dict[str, list[EntryPoint]]:
    """Entry points of plugins by engine name, one per distribution; engines that ship are not replaced."""
    found: dict[str, dict[str, EntryPoint]] = {}
    for point in entry_points(group=ENTRY_POINT_GROUP):
        found.setdefault(point.name, {}).setdefault(_distribution_name(point), point)
    return {
        name: list(points.values()) for name, points in found.items() if name not in {**ENGINES, **OPTIONAL_ENGINES}
    }


def _distribution_name(point: EntryPoint) -> str:
    """Name and version of the distribution that declares an entry point."""
    return "conrod" if point.dist is None else f"{point.dist.name} {point.dist.version}"
