"""The SQLite file of a ledger: made, recognised and refused in one line each."""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.studies.frame.writing import real_path

# 'crod' in ASCII: by it a ledger is known from any other SQLite file.
APPLICATION_ID = 0x63726F64
# Raised when the tables change; what stands in a measurement is versioned by the key of its cell.
SCHEMA_VERSION = 1
# A write takes a millisecond: who waits this long [s] waits for something that hangs.
PATIENCE = 30.0

SCHEMA = """
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
"""

_LOCKED = {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED}
_READ_ONLY = {sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM}
_DAMAGED = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB}


def connected(path: Path, patience: float = PATIENCE) -> sqlite3.Connection:
    """A connection to the ledger at a path; makes the file and its folders where there are none.

    Args:
        patience: how long to wait for another process that writes [s].

    Raises:
        InvalidInput: it cannot be made, or what is there is no ledger, or one of a newer conrod, or locked for long.
    """
    _check_place(path)
    with naming_ledger(path, patience):
        connection = sqlite3.connect(path, timeout=patience, isolation_level=None)
        try:
            if _is_blank(connection):
                _make(connection, patience)
            _check(connection, path)
            # Safe against a killed process; only a power cut may undo the last runs, and never more than them.
            connection.execute("PRAGMA synchronous = NORMAL")
            connection.text_factory = _text
        except BaseException:  # Ctrl-C, too
            connection.close()
            raise
    return connection


def connected_to_read(path: Path, patience: float = PATIENCE) -> sqlite3.Connection:
    """A connection to a ledger that is there, which writes nothing, on a full disk or in a read-only place too.

    There it sees what SQLite has moved from the journal into the file: all, unless a process was killed as it wrote.

    Raises:
        InvalidInput: as `connected`.
    """
    _check_place(path)
    address = f"{real_path(path).as_uri()}?mode=ro"
    with naming_ledger(path, patience):
        connection = sqlite3.connect(address, uri=True, timeout=patience, isolation_level=None)
        try:
            _check(connection, path)
        except sqlite3.OperationalError as error:
            connection.close()
            if _code(error) not in _READ_ONLY | {sqlite3.SQLITE_IOERR, sqlite3.SQLITE_FULL}:
                raise
            # A journal's index cannot be made there.
            connection = sqlite3.connect(f"{address}&immutable=1", uri=True, isolation_level=None)
            _check(connection, path)
        connection.text_factory = _text
    return connection


def _text(stored: bytes) -> str:
    # A damaged text is known by what is made of it; SQLite would stop at it.
    return stored.decode(errors="replace")


def _check_place(path: Path) -> None:
    """Make the parent folder, and refuse what is there already unless it is a file."""
    real = real_path(path)
    if real.is_dir():
        raise InvalidInput(f"{path} is a folder, not a ledger; give the name of a file")
    try:
        real.parent.mkdir(parents=True, exist_ok=True)
        if real.exists() and not real.is_file():
            raise InvalidInput(f"{path} is not a ledger: it is not a regular file")
    except OSError as error:
        raise InvalidInput(f"cannot use the ledger {path}: {error.strerror or error}") from None


def _make(connection: sqlite3.Connection, patience: float) -> None:
    _journal_ahead(connection, patience)
    # Looked at again with the file locked: two processes may make one ledger at the same time.
    connection.execute("BEGIN IMMEDIATE")
    with connection:
        if _is_blank(connection):
            for statement in SCHEMA.split(";\n"):
                connection.execute(statement)
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def _check(connection: sqlite3.Connection, path: Path) -> None:
    if _pragma(connection, "application_id") != APPLICATION_ID:
        raise InvalidInput(f"{path} is not a ledger of conrod: it is another program's SQLite file")
    version = _pragma(connection, "user_version")
    if version > SCHEMA_VERSION:
        raise InvalidInput(
            f"the ledger {path} is from a newer conrod (format {version}, this one knows {SCHEMA_VERSION}): "
            "update conrod or name another ledger"
        )


def _journal_ahead(connection: sqlite3.Connection, patience: float) -> None:
    """Write-ahead journal: readers and a writer do not wait for each other. SQLite itself does not wait here."""
    give_up = time.monotonic() + patience
    while True:
        try:
            connection.execute("PRAGMA journal_mode = WAL")
            return
        except sqlite3.OperationalError as error:
            if _code(error) not in _LOCKED or time.monotonic() > give_up:
                raise
            time.sleep(0.01)


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
            raise InvalidInput(f"the ledger {path} is locked: another process wrote for over {patience:g} s") from None
        if code == sqlite3.SQLITE_FULL or (code == sqlite3.SQLITE_IOERR and _is_full(path)):
            raise InvalidInput(f"cannot write the ledger {path}: the disk is full; what was kept is kept") from None
        if code in _READ_ONLY:
            raise InvalidInput(f"cannot write the ledger {path}: the place is read-only") from None
        if code in _DAMAGED:
            raise InvalidInput(f"{path} is not a ledger of conrod, or a damaged one: {error}") from None
        if code == sqlite3.SQLITE_IOERR:
            raise InvalidInput(f"cannot use the ledger {path}: {error}") from None
        raise
    except UnicodeDecodeError:  # of a message of SQLite's that quotes what it met
        raise InvalidInput(f"{path} is not a ledger of conrod, or a damaged one") from None


def _is_full(path: Path) -> bool:
    # SQLite reports a full disk as an input/output error where it meets it in its shared index.
    if not hasattr(os, "statvfs"):
        return False
    place = os.statvfs(real_path(path).parent)
    return place.f_bavail * place.f_frsize < 64 * 1024
