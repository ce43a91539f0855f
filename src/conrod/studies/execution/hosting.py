"""Engines of other packages as a process that pursues studies has them: each in a process of its own, never in it.

What an engine does as it is imported, asked for its presets or for a grid, to numpy, the working folder, signals or its
process itself, is then done to nothing else. Runs are made in workers, which load the engine themselves.
"""

from __future__ import annotations

import threading
import weakref
from typing import Any

from conrod import engines
from conrod.engines.plugin import PluginDescription, PluginEngine
from conrod.engines.plugin_values import EngineFault
from conrod.errors import InvalidInput
from conrod.studies.execution.worker_process import (
    KilledFromOutside,
    Limits,
    NeverBegun,
    WorkerDied,
    WorkerProcess,
)

ANSWERED = 60.0  # [s] in which an engine is loaded, or answers what is no run


class HostedEngine(PluginEngine):
    """An engine of another package whose code runs in a process of its own, started anew where it has ended."""

    def __init__(self, name: str) -> None:
        """Load it there.

        Raises:
            InvalidInput: the engine cannot be loaded; says why.
            EngineFault: it ends its process as it is loaded, or takes too long.
        """
        self._loaded_as, self._lock = name, threading.Lock()
        self._process: WorkerProcess | None = None
        super().__init__(self._call(_described, name))

    def ask(self, what: str, *arguments: Any, **named: Any) -> Any:
        return self._call(_asked, self._loaded_as, what, arguments, named)

    def _call(self, function: Any, *arguments: Any) -> Any:
        with self._lock:
            if self._process is None or not self._process.ready:
                self._process = WorkerProcess(Limits(timeout=ANSWERED))
                weakref.finalize(self, WorkerProcess.end, self._process)
            try:
                return self._process.call(function, *arguments)
            except (WorkerDied, KilledFromOutside, NeverBegun) as error:
                raise EngineFault(f"the process that asked it {error.args[0]}") from None
            except (TimeoutError, MemoryError) as error:
                raise EngineFault(f"it gave no answer: {error}") from None


def _described(name: str) -> PluginDescription:
    return engines.load_plugin_here(name).description


def _asked(name: str, what: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    return engines.load_plugin_here(name).ask(what, *arguments, **named)


def host(name: str) -> PluginEngine:
    """The engine of another package by its name, in a process of its own.

    Raises:
        InvalidInput: it cannot be loaded; says why.
    """
    try:
        return HostedEngine(name)
    except EngineFault as fault:
        raise InvalidInput(f"engine {name!r} cannot be loaded: {fault} ({engines.origin_of(name)})") from None
