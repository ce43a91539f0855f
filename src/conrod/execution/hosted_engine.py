"""Engines of other packages, each hosted in a separate process while studies are pursued.

An engine may change numpy, the working folder or signals, or end its process, when it is imported or asked for its
presets; here that harms its own process alone. Runs are made in workers, which load the engine themselves.
"""

from __future__ import annotations

import threading
import weakref
from typing import Any

from conrod import engines
from conrod.engines.plugin import PluginDescription, PluginEngine
from conrod.engines.plugin_values import EngineFault
from conrod.errors import InvalidInput
from conrod.execution.worker_process import CallLimits, CallNotStarted, KilledFromOutside, WorkerDied, WorkerProcess

ANSWER_TIMEOUT = 60.0  # [s], for an engine to load, or to answer a question that is no run


class HostedEngine(PluginEngine):
    """An engine of another package that runs in a separate process, restarted when it has ended."""

    def __init__(self, name: str) -> None:
        """Start the process and load the engine in it.

        Raises:
            InvalidInput: the engine cannot be loaded; says why.
            EngineFault: the engine ends its process while it is loaded, or takes too long.
        """
        self._loaded_as, self._lock = name, threading.Lock()
        self._process: WorkerProcess | None = None
        super().__init__(self._call(_describe_plugin, name))

    def ask(self, what: str, *arguments: Any, **named: Any) -> Any:
        return self._call(_ask_plugin, self._loaded_as, what, arguments, named)

    def _call(self, function: Any, *arguments: Any) -> Any:
        """Call a function in the engine's process; EngineFault if it gives no answer."""
        with self._lock:
            if self._process is None or not self._process.ready:
                self._process = WorkerProcess(CallLimits(timeout=ANSWER_TIMEOUT))
                weakref.finalize(self, WorkerProcess.end, self._process)
            try:
                return self._process.call(function, *arguments)
            except (WorkerDied, KilledFromOutside, CallNotStarted) as error:
                raise EngineFault(f"the process that asked it {error.args[0]}") from None
            except (TimeoutError, MemoryError) as error:
                raise EngineFault(f"it gave no answer: {error}") from None


def _describe_plugin(name: str) -> PluginDescription:
    """Load an engine in this process, and return its description."""
    return engines.load_plugin_here(name).description


def _ask_plugin(name: str, what: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    """Call a method of an engine in this process by the method's name."""
    return engines.load_plugin_here(name).ask(what, *arguments, **named)


def host_engine(name: str) -> PluginEngine:
    """Load the engine of another package by its name, in a separate process.

    Raises:
        InvalidInput: the engine cannot be loaded; says why.
    """
    try:
        return HostedEngine(name)
    except EngineFault as fault:
        raise InvalidInput(f"engine {name!r} cannot be loaded: {fault} ({engines.origin_of(name)})") from None
