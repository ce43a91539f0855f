"""MJX, where it is installed."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import pytest

from conrod.engines.registry import engine_named
from conrod.testing import EngineConformance


@pytest.fixture
def mjx() -> Any:
    """The engine."""
    pytest.importorskip("jax", reason="the extra conrod[mjx] is not installed")
    return engine_named("mjx")


@pytest.mark.slow
@pytest.mark.skipif(find_spec("mujoco.mjx") is None, reason="the extra conrod[mjx] is not installed")
class TestConformance(EngineConformance):
    scenes = ("saw-40rpm",)

    @pytest.fixture(autouse=True)
    def installed(self, mjx: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        """MJX, loaded where it is tested alone."""
        monkeypatch.setattr(type(self), "engine", mjx, raising=False)
