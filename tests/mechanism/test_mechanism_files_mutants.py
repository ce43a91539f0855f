"""Mutated copies of the files that ship: one clear line, or a mechanism that both engines take."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import mutants
import pytest
from described import SHIPPED

from conrod.errors import InvalidInput
from conrod.scenes.described_scene import read_scene
from conrod.studies.execution.local import isolated

FEW, MANY = 2, 100  # of each file


def test_mutants_are_refused_in_one_line_or_move() -> None:
    ends: Counter[str] = Counter()
    for path in SHIPPED:
        ends += mutants.tried(path, range(FEW), engines=False)
    # Negative control: the mutants get through to motion, and not all of them do.
    assert ends["valid"] > 5
    assert ends["refused"] > 5


def test_mutants_that_move_do_not_crash_an_engine() -> None:
    answer = isolated(mutants.tried, SHIPPED[-1], range(5), True, timeout=300.0)
    assert isinstance(answer, Counter), answer


@pytest.mark.slow
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_many_mutants(path: Path) -> None:
    answer = isolated(mutants.tried, path, range(10_000, 10_000 + MANY), True, timeout=1200.0)
    assert isinstance(answer, Counter), answer


def test_what_hangs_is_seen() -> None:
    # Negative control of the time limit.
    with pytest.raises(TimeoutError), mutants.in_time("a loop", 0.05):
        sum(k for k in iter(int, 1))


def test_line_ends_of_windows_change_nothing(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_bytes(SHIPPED[-1].read_bytes().replace(b"\n", b"\r\n"))
    assert read_scene(path).parameters_text == read_scene(SHIPPED[-1]).parameters_text


def test_paths_that_are_no_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "loop.toml").symlink_to("loop.toml")
    (tmp_path / "nowhere.toml").symlink_to("none.toml")
    for path in (*tmp_path.glob("*.toml"), Path("/dev/zero"), Path("/dev/null"), tmp_path / ("a" * 300)):
        with mutants.in_time(str(path)), pytest.raises(InvalidInput) as told:
            read_scene(path)
        mutants.one_line(told.value)
    (tmp_path / "link.toml").symlink_to(SHIPPED[0])
    assert read_scene(tmp_path / "link.toml").kind == SHIPPED[0].stem
