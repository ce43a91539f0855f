"""Claims of processes that share a ledger: what one of them runs, the others do not run as well.

A claim is a lock on a byte of a file beside the ledger, and so ends with the process that has it, however that ends.
Where the system has no such locks all claims are granted, and work may be done twice.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # not POSIX
    fcntl = None  # type: ignore[assignment]  # as the absence of a module is typed

ANYWHERE = 6  # bytes of a digest: where the byte of a name is, in a file that stays empty


class Claims:
    """Claims of this process.

    Attributes:
        path: of the file, which is made by the first claim and left where it is: another process may have it open.
    """

    def __init__(self, ledger: Path) -> None:
        self.path = ledger.with_name(f"{ledger.name}-claims")
        self._file: int | None = None

    def take(self, name: str) -> bool:
        """Claim a name; False where another process has it."""
        if fcntl is None:
            return True
        try:
            if self._file is None:
                self._file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o666)
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _place(name))
        except (BlockingIOError, PermissionError):
            return self._file is None  # which cannot be opened
        except OSError:
            return True  # of a file system without locks
        return True

    def give_back(self, name: str) -> None:
        """Let others have it."""
        if self._file is not None:
            with suppress(OSError):
                fcntl.lockf(self._file, fcntl.LOCK_UN, 1, _place(name))

    def close(self) -> None:
        """Give all back."""
        if self._file is not None:
            os.close(self._file)
            self._file = None


def _place(name: str) -> int:
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:ANYWHERE])
