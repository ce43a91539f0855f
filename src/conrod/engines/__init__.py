"""Physics engines behind one interface, and the table of those that ship."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from conrod.engines.engine import Engine
from conrod.errors import unknown_choice

# Name -> module that holds the object ENGINE; imported when it is asked for, because engines are slow to load.
ENGINES: dict[str, str] = {
    "mujoco": "conrod.engines.mujoco.engine",
    "pymunk": "conrod.engines.pymunk.engine",
}


def engine_named(name: str) -> Engine[Any]:
    """The engine of a name.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    if name not in ENGINES:
        raise unknown_choice("engine", name, ENGINES)
    return _loaded(ENGINES[name])


@cache
def _loaded(module: str) -> Engine[Any]:
    engine: Engine[Any] = import_module(module).ENGINE
    return engine


__all__ = ["ENGINES", "Engine", "engine_named"]
