"""Threads of linear algebra that an exact motion and the limits of an input take."""

from __future__ import annotations

import pytest
from free_machines import chain
from threadpoolctl import threadpool_info, threadpool_limits

from conrod.exact.dynamics import configurations
from conrod.exact.dynamics.configurations import Configurations
from conrod.exact.dynamics.pieces import Samples


def blas_threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_the_curve_of_a_motion_is_worked_out_by_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """With two, a chain of twenty four-bars took 46 s of CPU time in place of 3 s."""
    seen, sampled = [], configurations.sampled

    def watched(*arguments: object) -> Samples | None:
        seen.append(blas_threads())
        return sampled(*arguments)  # type: ignore[arg-type]  # as they are

    monkeypatch.setattr(configurations, "sampled", watched)
    with threadpool_limits(2, user_api="blas"):
        Configurations(chain(1)).reach(0.1)
        assert blas_threads() == {2}
    assert seen
    assert all(threads == {1} for threads in seen)
