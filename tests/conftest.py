"""What takes longer than what a test looks at: drawings, processes of their own, and looks for garbage."""

from __future__ import annotations

import gc
import os
import subprocess
from collections.abc import Iterator

import pytest
from forked_workers import forking_subprocess

from conrod import ONE_THREAD

os.environ.update(ONE_THREAD)  # as the command does, before numpy is loaded

from conrod.execution import worker_process
from conrod.report.figure import Figure

if "MUTANT_UNDER_TEST" not in os.environ:
    worker_process.subprocess = forking_subprocess()  # type: ignore[attr-defined]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for no garbage while modules are loaded, and never among what they hold: all of it is used to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture
def started_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers are started as a user's are, each by a Python of its own."""
    monkeypatch.setattr(worker_process, "subprocess", subprocess)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures by what they are said to show alone."""
    monkeypatch.setattr(Figure, "svg", lambda figure: f"<svg>{figure.alt}</svg>")


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Users' files are looked at in this process: to begin another takes longer than the look."""
    # What `call_on_file` calls, for modules that are imported meanwhile keep `call_on_file` itself.
    monkeypatch.setattr("conrod.execution.local.call_isolated", lambda task, *given, **_: task(*given))


if "MUTANT_UNDER_TEST" in os.environ:  # `make mutants` sees which tests reach a function in this process alone
    if os.environ["MUTANT_UNDER_TEST"] == "stats":
        # A worker has nobody to tell which functions are reached, and mutmut would end it.
        worker_process.SAFE_PATH = {**worker_process.SAFE_PATH, "MUTANT_UNDER_TEST": "none"}

    @pytest.fixture(autouse=True)
    def _looks_in_this_process(at_once: None) -> None:
        """Users' files are looked at here in every test."""
