"""Reports without their drawing, which takes longer than all the rest."""

from __future__ import annotations

import pytest

from conrod.report.figure import Figure


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures by what they are said to show alone."""
    monkeypatch.setattr(Figure, "svg", lambda figure: f"<svg>{figure.alt}</svg>")
