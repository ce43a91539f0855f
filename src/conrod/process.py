"""What the system tells of a process: what it has, and how it ended."""

from __future__ import annotations

import os
import signal

# Kept back by a process whose memory is limited: to say that all is taken takes some.
RESERVE = 1 << 24  # bytes


def address_space() -> int:
    """Address space of this process [bytes]; 0 where the system does not tell."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except FileNotFoundError:
        return 0


def how_it_ended(status: int | None) -> str:
    """How a process ended, by its exit status as Python gives it: negative for a signal."""
    if status is not None and status < 0:
        return f"ended by signal {signal.Signals(-status).name}"
    return f"ended with status {status}"
