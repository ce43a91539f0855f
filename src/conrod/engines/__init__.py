"""Physics engines behind one small interface, and the table of those that conrod knows."""

from __future__ import annotations

from conrod.engines.engine import Engine
from conrod.engines.registry import ENGINES, engine_named, engine_names

__all__ = ["ENGINES", "Engine", "engine_named", "engine_names"]
