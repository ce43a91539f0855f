"""What JAX compiles in a worker is kept in the cache folder, bounded, and only where no other user may write."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from conrod.engines.mjx.compiled_functions import drop_oldest_files, keep_compiled_functions
from conrod.system import WORKER_MARK, other_writer


class Config(SimpleNamespace):
    """JAX's settings."""

    def update(self, name: str, value: Any) -> None:
        setattr(self, name, value)


def kept_in(monkeypatch: pytest.MonkeyPatch, folder: Path, given: str | None = None, *, worker: bool = True) -> Any:
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
    monkeypatch.setenv("LOCALAPPDATA", str(folder))
    monkeypatch.delenv(WORKER_MARK, raising=False)
    if worker:
        monkeypatch.setenv(WORKER_MARK, "1")
    config = Config(jax_compilation_cache_dir=given)
    keep_compiled_functions(config)
    return config.jax_compilation_cache_dir


def test_compiled_functions_are_kept_by_workers_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = kept_in(monkeypatch, tmp_path)
    assert Path(folder).is_dir()
    assert Path(folder).is_relative_to(tmp_path.resolve())
    assert kept_in(monkeypatch, tmp_path, worker=False) is None
    assert kept_in(monkeypatch, tmp_path, "the user's") == "the user's"


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_compiled_functions_are_not_kept_where_others_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    open_to_all = tmp_path / "all"
    open_to_all.mkdir()
    assert kept_in(monkeypatch, open_to_all) is not None
    open_to_all.chmod(0o777)
    assert "all may write" in other_writer(open_to_all)
    assert kept_in(monkeypatch, open_to_all) is None
    # Nor where a folder cannot be made.
    (tmp_path / "file").touch()
    assert kept_in(monkeypatch, tmp_path / "file") is None


def test_the_oldest_compiled_functions_go_first(tmp_path: Path) -> None:
    for age, name in enumerate(("new", "middle", "old", "oldest")):
        (tmp_path / name).write_bytes(bytes(100))
        os.utime(tmp_path / name, (1e9 - age, 1e9 - age))
    (tmp_path / "cut off").touch()
    drop_oldest_files(tmp_path, 250)
    assert {file.name for file in tmp_path.iterdir()} == {"new", "middle"}
