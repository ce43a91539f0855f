"""The SQLite file of a ledger: created, checked, refused with one line; and the claims of processes on it."""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import sqlite3
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.execution.case import CACHE_VERSION
from conrod.system import PLAIN_FILE, grants_a_lock_twice, lock_byte, network_file_system, own_path, unlock_byte

# 'crod' in ASCII: tells a ledger from any other SQLite file.
APPLICATION_ID = 0x63726F64
# A write takes a millisecond: who waits this long [s] waits for something that hangs.
LOCK_TIMEOUT = 30.0

LEDGER_TABLES = f"""
CREATE TABLE cells (
    key TEXT PRIMARY KEY,
    name TEXT NOT NULL,      -- of the scene, for people
    identity TEXT NOT NULL   -- JSON of what the key is made from
) STRICT;
CREATE TABLE runs (
    key TEXT PRIMARY KEY REFERENCES cells,
    outcome TEXT NOT NULL,
    allowed REAL,               -- what a run that ended at a limit was allowed: seconds or bytes
    result BLOB NOT NULL        -- JSON, zlib
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
PRAGMA user_version = {CACHE_VERSION};
"""

# Made when the first file is checked, so that ledgers that were there before have it, too.
CHECKS_TABLE = """
CREATE TABLE IF NOT EXISTS checks (
    key TEXT PRIMARY KEY,
    name TEXT NOT NULL,      -- of the file, for people
    findings BLOB NOT NULL   -- JSON, zlib
) STRICT
"""


def connect(path: Path, patience: float = LOCK_TIMEOUT, may_empty: bool = True) -> tuple[sqlite3.Connection, int]:
    """Connect to the ledger at a path; create the file and its folders if missing.

    Args:
        patience: how long to wait for another process that writes [s].
        may_empty: whether a ledger of an older version, whose results count no more, is emptied or else refused.

    Raises:
        InvalidInput: the file cannot be made, is no ledger, is a ledger of a newer conrod, or stays locked.

    Returns:
        The connection, and how many runs of an older version were removed.
    """
    real = own_path(path)
    if real.exists() and not real.is_file():
        raise InvalidInput(f"{path} is not a ledger: it is no regular file; give the name of a file")
    with name_ledger_in_errors(path):
        real.parent.mkdir(parents=True, exist_ok=True)
        journal = journal_mode(real)
        connection = sqlite3.connect(real, timeout=patience, isolation_level=None)
        return _checked_connection(connection, path, patience, may_empty, journal)


def journal_mode(path: Path) -> str:
    """SQLite's journal for a ledger: WAL, but on a network file system, which its shared memory does not reach.

    Raises:
        InvalidInput: commands that use the ledger at the same time would damage it, since no lock keeps them apart.
    """
    system, reaches_others = network_file_system(path.parent)
    if not system:
        return "WAL"
    if grants_a_lock_twice(path.parent):
        raise InvalidInput(f"the ledger {path} is on {system}, whose locks do nothing: name a file on a local disk")
    if not reaches_others and platform.node() not in path.name:
        raise InvalidInput(
            f"the ledger {path} is on {system}, whose locks do not reach other machines: name a file on a local disk, "
            f"or one with this machine's name in its own: {path.stem}-{platform.node()}{path.suffix}"
        )
    return "DELETE"


@contextmanager
def connect_for_reading(path: Path) -> Iterator[sqlite3.Connection]:
    """Connect to an existing ledger for reading, also on a read-only disk or in a read-only folder.

    SQLite's log of a ledger has files beside it, which it would have to make or write even for a reader.

    Raises:
        InvalidInput: as `connect`.
    """
    real, log = own_path(path), own_path(path).with_name(f"{path.name}-wal")
    if not real.is_file() or (os.access(real, os.W_OK) and os.access(real.parent, os.W_OK)):
        yield connect(path, may_empty=False)[0]
        return
    with tempfile.TemporaryDirectory(prefix="conrod-ledger-") as folder, name_ledger_in_errors(path):
        if log.exists() and log.stat().st_size:
            # Its last runs stand in the log alone.
            for file in (real, log):
                shutil.copy(file, folder)
            connection = sqlite3.connect(Path(folder) / real.name, isolation_level=None)
        else:
            connection = sqlite3.connect(f"{real.resolve().as_uri()}?immutable=1", uri=True, isolation_level=None)
        yield _checked_connection(connection, path, 0.0)[0]


def _checked_connection(
    connection: sqlite3.Connection, path: Path, patience: float, may_empty: bool = False, journal: str = "WAL"
) -> tuple[sqlite3.Connection, int]:
    """Return the connection if its file is a ledger, and how many runs of an older version were removed.

    Raises:
        InvalidInput: the file is no ledger, or one that cannot be used; the connection is closed.
    """
    emptied = 0
    with name_ledger_in_errors(path):
        try:
            if _is_blank(connection):
                _create_tables(connection, patience, journal)
            if may_empty and _is_older(connection):
                emptied = _empty_older_ledger(connection, path)
            if _pragma(connection, "application_id") != APPLICATION_ID:
                raise InvalidInput(f"{path} is not a ledger of conrod: it is another program's SQLite file")
            if _pragma(connection, "user_version") > CACHE_VERSION:
                raise InvalidInput(f"the ledger {path} is from a newer conrod: update conrod or name another ledger")
            if _is_older(connection):
                raise InvalidInput(f"the ledger {path} is from an older conrod, whose results count no more")
            if missing := _schema_fault(connection):
                raise InvalidInput(f"the ledger {path} is damaged: {missing}; remove it or name another")
            if journal != "WAL":  # a file that was made elsewhere may have the other
                connection.execute(f"PRAGMA journal_mode = {journal}")
            # What a file from elsewhere says of its tables calls no function that could do more than compute.
            connection.execute("PRAGMA trusted_schema = OFF")
            # Safe against a killed process; only a power cut may undo the last runs, and never more than them.
            connection.execute("PRAGMA synchronous = NORMAL")
        except BaseException:  # Ctrl-C, too
            connection.close()
            raise
    # A damaged text is known by what is made of it; SQLite would stop at it.
    connection.text_factory = lambda stored: stored.decode(errors="replace")
    return connection, emptied


def _create_tables(connection: sqlite3.Connection, patience: float, journal: str) -> None:
    give_up = time.monotonic() + patience
    while True:
        try:
            # Readers and a writer do not wait for each other. SQLite itself does not wait here.
            connection.execute(f"PRAGMA journal_mode = {journal}")
            break
        except sqlite3.OperationalError:
            if time.monotonic() > give_up:
                raise
            time.sleep(0.01)
    # Looked at again with the file locked: two processes may make one ledger at the same time.
    connection.execute("BEGIN IMMEDIATE")
    with connection:
        if _is_blank(connection):
            for statement in LEDGER_TABLES.split(";\n"):
                connection.execute(statement)


def _is_older(connection: sqlite3.Connection) -> bool:
    """True if the file is a ledger of an older version."""
    is_ledger = _pragma(connection, "application_id") == APPLICATION_ID
    return is_ledger and _pragma(connection, "user_version") < CACHE_VERSION


def _empty_older_ledger(connection: sqlite3.Connection, path: Path) -> int:
    """Replace the tables of an older ledger by empty ones; return the number of runs that it had."""
    connection.execute("BEGIN IMMEDIATE")
    with connection:
        if not _is_older(connection):  # looked at again with the file locked
            return 0
        kinds = dict(connection.execute("SELECT name, type FROM sqlite_master"))
        if foreign := _foreign_parts(kinds):
            raise InvalidInput(f"the ledger {path} is damaged: {foreign}; remove it or name another")
        count = connection.execute("SELECT count(*) FROM runs").fetchone()[0] if kinds.get("runs") == "table" else 0
        connection.execute("DROP INDEX IF EXISTS stopped")
        # A table before those that it refers to.
        for table in ("checks", "timings", "runs", "cells"):
            connection.execute(f"DROP TABLE IF EXISTS {table}")
        for statement in LEDGER_TABLES.split(";\n"):
            connection.execute(statement)
    return int(count)


def _is_blank(connection: sqlite3.Connection) -> bool:
    """True if the file has no table, as one left by a process killed while creating it."""
    tables = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    return not tables and not _pragma(connection, "application_id")


TABLE_COLUMNS = {
    "cells": {"key", "name", "identity"},
    "runs": {"key", "outcome", "allowed", "result"},
    "timings": {"key", "machine", "seconds_per_revolution", "reference_seconds", "ratio", "steps", "repeats"},
}


def _schema_fault(connection: sqlite3.Connection) -> str:
    """Name a missing table or column, or a trigger or view that conrod does not make; empty if none."""
    kinds = dict(connection.execute("SELECT name, type FROM sqlite_master WHERE type != 'index'"))
    for table, columns in TABLE_COLUMNS.items():
        if kinds.get(table) != "table":
            return f"its table {table} is missing"
        there = {row[1] for row in connection.execute(f"PRAGMA table_info({table})")}
        if lacking := sorted(columns - there):
            return f"its table {table} has no column {lacking[0]}"
    return _foreign_parts(kinds)


def _foreign_parts(kinds: Mapping[str, str]) -> str:
    """Name a trigger or view, given the kinds of a file's parts; empty without either."""
    others = [f"a {kind} {name}" for name, kind in kinds.items() if kind in ("trigger", "view")]
    return f"it has {others[0]}, which conrod does not make" if others else ""


def _pragma(connection: sqlite3.Connection, name: str) -> int:
    return int(connection.execute(f"PRAGMA {name}").fetchone()[0])


@contextmanager
def name_ledger_in_errors(path: Path) -> Iterator[None]:
    """Turn SQLite's errors about the file into InvalidInput with one line that names the ledger.

    Raises:
        InvalidInput: locked, read-only, damaged, full or otherwise out of reach.
    """
    try:
        yield
    except (sqlite3.Error, OSError, UnicodeDecodeError) as error:  # the last of a message that quotes what it met
        if getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_ERROR:
            raise
        said = "it is damaged" if isinstance(error, UnicodeDecodeError) else getattr(error, "strerror", None) or error
        raise InvalidInput(f"cannot use the ledger {path}: {said}") from None


# -- claims ------------------------------------------------------------------------------------------------------------

CLAIM_OFFSET_BYTES = 6  # of a name's digest: the offset of the byte that is locked, in a file that stays empty


class Claims:
    """Claims of this process on the runs it makes, so that no other process on the ledger makes them too.

    A claim is a lock on a byte of a file beside the ledger, and so ends with the process that has it, however that
    ends. Where the system or the file system has no locks all claims are granted, and work may be done twice.

    Attributes:
        path: path of the file; the first claim makes it, and it is never removed: another process may have it open.
    """

    def __init__(self, ledger: Path) -> None:
        self.path = ledger.with_name(f"{ledger.name}-claims")
        self._file: int | None = None

    def take(self, name: str) -> bool:
        """Claim a name; return False if another process has claimed it."""
        try:
            if self._file is None:
                self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | PLAIN_FILE, 0o666)
            lock_byte(self._file, _claim_offset(name))
        except OSError as error:  # else it cannot be opened, or there are no locks
            return not (self._file is not None and isinstance(error, BlockingIOError | PermissionError))
        return True

    def give_back(self, name: str) -> None:
        """Release a name, so that other processes can claim it."""
        if self._file is not None:
            unlock_byte(self._file, _claim_offset(name))

    def close(self) -> None:
        """Release all names."""
        if self._file is not None:
            os.close(self._file)
            self._file = None


def _claim_offset(name: str) -> int:
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:CLAIM_OFFSET_BYTES])
