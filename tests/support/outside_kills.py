"""Kills from outside, as a person, a batch system or a kernel short of memory sends them."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import cell_tasks as tasks


@contextmanager
def killing(
    victim: Callable[[], int | None], how: signal.Signals = signal.SIGKILL, times: int = 1
) -> Iterator[list[int]]:
    """Kill processes while the block runs; gives the ids of those that were.

    Args:
        victim: the process to kill, looked for again and again; None for not yet.
        times: how many to kill at most, one a second.
    """
    killed: list[int] = []
    done = threading.Event()

    def watch() -> None:
        while not done.is_set() and len(killed) < times:
            process = victim()
            if process is not None:
                os.kill(process, how)
                killed.append(process)
            time.sleep(0.01 if process is None else 1.0)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield killed
    finally:
        done.set()
        thread.join()


def attempts(folder: Path, number: int) -> list[Path]:
    """Files of the attempts at a cell, see `cell_tasks.wait_for_a_kill`."""
    return list(folder.glob(f"{number}-*"))


def waiting_cell(folder: Path) -> Callable[[], int | None]:
    """The process of the cell that waits for its kill."""

    def look() -> int | None:
        found = attempts(folder, tasks.CRASHES)
        return int(found[0].name.split("-")[1]) if found and found[0].read_text() else None

    return look


def was_alone(folder: Path, killed: int) -> bool:
    """Whether nothing ran while the killed cell's second attempt did."""
    again = next(file for file in attempts(folder, tasks.CRASHES) if int(file.name.split("-")[1]) != killed)
    begin, end = map(float, again.read_text().split())
    others = [file for file in folder.iterdir() if not file.name.startswith(f"{tasks.CRASHES}-")]
    assert others
    spans = [tuple(map(float, file.read_text().split())) for file in others]
    return all(last <= begin or first >= end for first, last in spans)


def children(process: int) -> Iterator[int]:
    """Processes that a process started."""
    for thread in list(Path(f"/proc/{process}/task").iterdir()):
        with suppress(OSError):  # it has ended meanwhile
            yield from map(int, (thread / "children").read_text().split())


def grandchild() -> int | None:
    """A process that a child of this process has started."""
    for child in children(os.getpid()):
        with suppress(OSError):
            for one in children(child):
                return one
    return None
