"""What the system tells of a process: what it has, whether that was enough, and how it ended."""

from __future__ import annotations

import os
import signal

from conrod.errors import InvalidInput

# Kept back by a process whose memory is limited: to say that all is taken takes some.
RESERVE = 1 << 24  # bytes


# Less than this is too little for an engine to load its libraries, compile a model or make its state. (With 32 MB left,
# MuJoCo fails in a handful of ways, of which only some say why; with 64 MB it does not.)
SPARE = 1 << 26  # bytes
# What libraries say that were given no memory, and as what kinds of error.
SIGNS = ("allocate memory", "insufficient memory", "failed to map segment")
FOREIGN = (ImportError, OSError, RuntimeError, ValueError)


def ran_out_of_memory(error: Exception) -> bool:
    """Whether an error came of this process's memory limit; to be asked before what the process holds is let go."""
    if isinstance(error, MemoryError):
        return True
    limit = memory_limit()
    if limit is None or isinstance(error, InvalidInput):
        return False
    told = any(sign in str(error) for sign in SIGNS)
    return told or (isinstance(error, FOREIGN) and limit - address_space() < SPARE)


def memory_limit() -> int | None:
    """Largest address space that this process may have [bytes]; None where there is no limit."""
    try:
        import resource
    except ImportError:  # not POSIX
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if limit == resource.RLIM_INFINITY else limit


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
