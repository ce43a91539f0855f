"""The SQLite file of a ledger, made, recognised and refused in one line each; and what processes on it claim."""

from __future__ import annotations

import hashlib
import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.studies.frame.writing import real_path

try:
    import fcntl
except ImportError:  # not POSIX
    fcntl = None  # type: ignore[assignment]  # as the absence of a module is typed

# 'crod' in ASCII: by it a ledger is known from any other SQLite file.
APPLICATION_ID = 0x63726F64
# Raised when the tables change; what stands in a measurement is versioned by the key of its cell.
SCHEMA_VERSION = 1
# A write takes a millisecond: who waits this long [s] waits for something that hangs.
PATIENCE = 30.0

SCHEMA = f"""
CREATE TABLE cells (
    key TEXT PRIMARY KEY,
    name TEXT NOT NULL,      -- of the scene, for people
    identity TEXT NOT NULL   -- JSON of what the key is made from
) STRICT;
CREATE TABLE runs (
    key TEXT PRIMARY KEY REFERENCES cells,
    outcome TEXT NOT NULL,
    allowed REAL,               -- what a run that ended at a limit was allowed: seconds or bytes
    measurement BLOB NOT NULL   -- JSON, zlib
) STRICT;
CREATE INDEX stopped ON runs (key) WHERE allowed IS NOT NULL;
CREATE TABLE timings (
    key TEXT NOT NULL REFERENCES cells,
    machine TEXT NOT NULL,
    seconds_per_revolution REAL NOT NULL,
    reference_seconds REAL NOT NULL,
    ratio REAL NOT NULL,
    steps INTEGER NOT NULL,
    repeats INTEGER NOT NULL,
    PRIMARY KEY (key, machine)
) STRICT;
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""

_LOCKED = {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED}
_READ_ONLY = {sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM}
_DAMAGED = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB}


def connected(path: Path, patience: float = PATIENCE, *, reading: bool = False) -> sqlite3.Connection:
    """A connection to the ledger at a path; makes the file and its folders where there are none.

    Args:
        patience: how long to wait for another process that writes [s].
        reading: write nothing, on a full disk or in a read-only place too. There it sees what SQLite has moved from the
            journal into the file: all, unless a process was killed as it wrote.

    Raises:
        InvalidInput: it cannot be made, or what is there is no ledger, or one of a newer conrod, or locked for long.
    """
    _check_place(path)
    address = f"{real_path(path).as_uri()}?mode={'ro' if reading else 'rwc'}"
    with naming_ledger(path, patience):
        connection = sqlite3.connect(address, uri=True, timeout=patience, isolation_level=None)
        try:
            try:
                if not reading and _is_blank(connection):
                    _make(connection, patience)
                _check(connection, path)
            except sqlite3.OperationalError as error:
                if not reading or _code(error) not in _READ_ONLY | {sqlite3.SQLITE_IOERR, sqlite3.SQLITE_FULL}:
                    raise
                connection.close()
                # A journal's index cannot be made there.
                connection = sqlite3.connect(f"{address}&immutable=1", uri=True, isolation_level=None)
                _check(connection, path)
            # Safe against a killed process; only a power cut may undo the last runs, and never more than them.
            connection.execute("PRAGMA synchronous = NORMAL")
        except BaseException:  # Ctrl-C, too
            connection.close()
            raise
    # A damaged text is known by what is made of it; SQLite would stop at it.
    connection.text_factory = lambda stored: stored.decode(errors="replace")
    return connection


def _check_place(path: Path) -> None:
    """Make the parent folder, and refuse what is there already unless it is a file."""
    real = real_path(path)
    try:
        real.parent.mkdir(parents=True, exist_ok=True)
        if real.exists() and not real.is_file():
            what = "a folder" if real.is_dir() else "not a regular file"
            raise InvalidInput(f"{path} is not a ledger: it is {what}; give the name of a file")
    except OSError as error:
        raise InvalidInput(f"cannot use the ledger {path}: {error.strerror or error}") from None


def _make(connection: sqlite3.Connection, patience: float) -> None:
    give_up = time.monotonic() + patience
    while True:
        try:
            # Readers and a writer do not wait for each other. SQLite itself does not wait here.
            connection.execute("PRAGMA journal_mode = WAL")
            break
        except sqlite3.OperationalError as error:
            if _code(error) not in _LOCKED or time.monotonic() > give_up:
                raise
            time.sleep(0.01)
    # Looked at again with the file locked: two processes may make one ledger at the same time.
    connection.execute("BEGIN IMMEDIATE")
    with connection:
        if _is_blank(connection):
            for statement in SCHEMA.split(";\n"):
                connection.execute(statement)


def _check(connection: sqlite3.Connection, path: Path) -> None:
    if _pragma(connection, "application_id") != APPLICATION_ID:
        raise InvalidInput(f"{path} is not a ledger of conrod: it is another program's SQLite file")
    version = _pragma(connection, "user_version")
    if version > SCHEMA_VERSION:
        known = f"(format {version}, this one knows {SCHEMA_VERSION})"
        raise InvalidInput(f"the ledger {path} is from a newer conrod {known}: update conrod or name another ledger")


def _is_blank(connection: sqlite3.Connection) -> bool:
    """A file that nobody has put anything into, such as one left by a process killed while it made it."""
    tables = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    return not tables and not _pragma(connection, "application_id") and not _pragma(connection, "user_version")


def _pragma(connection: sqlite3.Connection, name: str) -> int:
    return int(connection.execute(f"PRAGMA {name}").fetchone()[0])


def _code(error: sqlite3.Error) -> int:
    """SQLite's primary result code; the rest of the bits say where in SQLite it arose."""
    return getattr(error, "sqlite_errorcode", 0) & 0xFF


@contextmanager
def naming_ledger(path: Path, patience: float) -> Iterator[None]:
    """Say in one line what SQLite met, if it lies with the file and not with conrod.

    Raises:
        InvalidInput: locked, read-only, damaged, full or otherwise out of reach.
    """
    try:
        yield
    except sqlite3.Error as error:
        code = _code(error)
        if code in _LOCKED:
            why = f"the ledger {path} is locked: another process wrote for over {patience:g} s"
        elif code == sqlite3.SQLITE_FULL or (code == sqlite3.SQLITE_IOERR and _is_full(path)):
            why = f"cannot write the ledger {path}: the disk is full; what was kept is kept"
        elif code in _READ_ONLY:
            why = f"cannot write the ledger {path}: the place is read-only"
        elif code in _DAMAGED:
            why = f"{path} is not a ledger of conrod, or a damaged one: {error}"
        elif code == sqlite3.SQLITE_IOERR:
            why = f"cannot use the ledger {path}: {error}"
        else:
            raise
        raise InvalidInput(why) from None
    except UnicodeDecodeError:  # of a message of SQLite's that quotes what it met
        raise InvalidInput(f"{path} is not a ledger of conrod, or a damaged one") from None


def _is_full(path: Path) -> bool:
    # SQLite reports a full disk as an input/output error where it meets it in its shared index.
    if not hasattr(os, "statvfs"):
        return False
    place = os.statvfs(real_path(path).parent)
    return place.f_bavail * place.f_frsize < 64 * 1024


# -- claims ------------------------------------------------------------------------------------------------------------

ANYWHERE = 6  # bytes of a digest: where the byte of a name is, in a file that stays empty


class Claims:
    """Claims of this process on what it runs, which the others on its ledger then do not run as well.

    A claim is a lock on a byte of a file beside the ledger, and so ends with the process that has it, however that
    ends. Where the system has no such locks all claims are granted, and work may be done twice.

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
