"""A pose whose closures have no finite Jacobian says nothing of redundant closures."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from conrod.models.lint import closures


@pytest.mark.parametrize("entry", [np.nan, np.inf])
def test_poses_without_a_finite_jacobian_are_left_out(entry: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closures, "data_at_state", lambda model, state: SimpleNamespace(qpos=np.zeros(2)))
    monkeypatch.setattr(closures, "close_loops", lambda model, data, tolerance: None)
    monkeypatch.setattr(closures, "row_equalities", lambda data: np.zeros(3, dtype=int))
    monkeypatch.setattr(closures, "equality_jacobian", lambda model, data: np.full((3, 2), entry))
    bench: Any = SimpleNamespace(run=SimpleNamespace(states=[np.zeros(4)]), model=None, size=1.0)
    assert list(closures.redundant_closure(bench)) == []
