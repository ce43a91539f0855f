"""The ledger: result and cost of every finished run, in one SQLite file that outlives the process."""

from __future__ import annotations

import gc
import json
import os
import platform
import sqlite3
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, fields
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import msgspec

from conrod.comparison.plain_values import plain_values
from conrod.errors import InvalidInput
from conrod.execution.case import SIZES, Case, CaseResult, identity_digest
from conrod.execution.ledger_file import (
    CHECKS_TABLE,
    LOCK_TIMEOUT,
    Claims,
    connect,
    connect_for_reading,
    name_ledger_in_errors,
)
from conrod.execution.results_table import tidy_row
from conrod.scenes.scene import canonical_json
from conrod.system import network_file_system, real_path

if TYPE_CHECKING:
    from conrod.execution.timing import Timing

MAX_RESULT_BYTES = 1 << 28  # usually some kB, or MB with curves and poses
LABEL_KEY = "label"  # kept with the identity, and no part of it: the preset that the settings are
TIMING_COLUMNS = "machine, seconds_per_revolution, reference_seconds, ratio, steps, repeats"


def default_ledger_path() -> Path:
    """Path in CONROD_LEDGER if that is set, else a file in the user's cache folder: one a machine on a network disk."""
    if named := os.environ.get("CONROD_LEDGER"):
        return Path(named)
    import platformdirs

    folder = platformdirs.user_cache_path("conrod")
    there = next(place for place in (folder, *folder.parents) if place.exists())
    return folder / ("ledger.sqlite" if not network_file_system(there)[0] else f"ledger-{platform.node()}.sqlite")


class Ledger:
    """Finished runs by the key of their case; timings apart from them, by machine.

    What `keep` returned from survives the process being killed at any moment. Several processes may use one ledger.
    Every method raises InvalidInput, in one line, where the file is locked for long, on a full disk, read-only or
    damaged as a whole; what was kept before stays. A single damaged row counts as not there.

    Attributes:
        claims: claims of this process on the cases that it runs; closed with the ledger.
        damaged: number of runs that `rows` left out because their rows cannot be read.
        emptied: number of runs of an older version that were removed when the ledger was opened.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection, emptied: int = 0) -> None:
        self.path, self.emptied = path, emptied
        self._connection = connection
        self.claims = Claims(real_path(path))
        self.damaged = 0

    @classmethod
    def open(cls, path: Path, patience: float = LOCK_TIMEOUT) -> Ledger:
        """Open the ledger in a file; create the file and its folders if missing.

        Args:
            patience: how long to wait for another process that writes [s].

        Raises:
            InvalidInput: the file cannot be made, is no ledger, or is a ledger of a newer conrod.
        """
        return cls(path, *connect(path, patience))

    @classmethod
    @contextmanager
    def open_for_reading(cls, path: Path) -> Iterator[Self]:
        """Open an existing ledger for reading, also where nothing can be written.

        Raises:
            InvalidInput: as `open`.
        """
        with connect_for_reading(path) as connection, cls(path, connection) as ledger:
            yield ledger

    def close(self) -> None:
        """Close the file; closing twice does nothing."""
        self._connection.close()
        self.claims.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    # -- runs --------------------------------------------------------------------------------------------------------

    def finished_keys(self, keys: Iterable[str]) -> set[str]:
        """Keys whose run the ledger has, with any outcome."""
        return {key for (key,) in self._select("SELECT key FROM runs WHERE key IN", set(keys))}

    def stops_at_limits(self, keys: Iterable[str]) -> dict[str, tuple[str, float]]:
        """Outcome and limit [s] or [bytes] by key, for runs that ended at a limit."""
        # They are few, and have an index of their own: all are read, whatever is asked for.
        with name_ledger_in_errors(self.path):
            found = self._connection.execute(
                "SELECT key, outcome, allowed FROM runs WHERE allowed IS NOT NULL"
            ).fetchall()
        wanted = set(keys) if found else ()
        return {key: (outcome, allowed) for key, outcome, allowed in found if key in wanted}

    def results(self, cases: Mapping[str, Case]) -> dict[str, CaseResult]:
        """Results of cases, given and returned by key in one order; cases without a run are left out.

        A run whose row, or whose case's row, is damaged counts as missing.
        """
        rows = self._select("SELECT key, identity, result FROM runs JOIN cells USING (key) WHERE key IN", cases)
        found: dict[str, CaseResult] = {}
        with _no_garbage_collection():
            saved = {key: _unpack(blob) for key, identity, blob in rows if _restore_identity(key, identity) is not None}
            for key, case in cases.items():
                if (values := saved.get(key)) is not None:
                    with suppress(InvalidInput):  # a damaged row, of values that are no result
                        found[key] = case.restore_result(values)
        return found

    def keep(self, case: Case, result: CaseResult, limit: float | None = None, *, replace: bool = False) -> None:
        """Save the result of a case; it replaces the one saved before.

        Args:
            limit: limit at which the run ended: time [s] if it timed out, memory [bytes] if it ran out of memory.
            replace: whether a run that ended at a limit replaces even a run that ended by itself, which another process
                may have made.
        """
        key = case.key
        with name_ledger_in_errors(self.path), self._begin_transaction():
            self._insert_case(key, case)
            self._connection.execute(
                "INSERT INTO runs VALUES (?, ?, ?, ?) ON CONFLICT (key) DO UPDATE SET outcome = excluded.outcome, "
                "allowed = excluded.allowed, result = excluded.result "
                "WHERE ? OR excluded.allowed IS NULL OR runs.allowed IS NOT NULL",
                (key, result.outcome, limit, _pack(result), replace),
            )

    def forget(self, keys: Collection[str]) -> None:
        """Delete the rows of runs that cannot be read, so that they can be saved again."""
        with name_ledger_in_errors(self.path), self._begin_transaction():
            for table in ("runs", "cells"):
                self._connection.executemany(f"DELETE FROM {table} WHERE key = ?", ((key,) for key in keys))
            # Rows and their index may have been damaged apart from each other.
            self._connection.execute("REINDEX")
        if self.finished_keys(keys):
            raise InvalidInput(f"the ledger {self.path} is damaged beyond its rows; remove it or name another")

    # -- timings -----------------------------------------------------------------------------------------------------

    def keep_timing(self, case: Case, timing: Timing) -> None:
        """Save a run's cost; it replaces the one saved on the same machine before."""
        key = case.key
        with name_ledger_in_errors(self.path), self._begin_transaction():
            self._insert_case(key, case)
            self._connection.execute(
                f"INSERT OR REPLACE INTO timings (key, {TIMING_COLUMNS}) VALUES (:key, :machine, "
                ":seconds_per_revolution, :reference_seconds, :ratio, :steps, :repeats)",
                {"key": key, **asdict(timing)},
            )

    def timings(self, keys: Iterable[str], machine: str) -> dict[str, Timing]:
        """Timings on a machine by key; keys without a timing are left out."""
        found = self._select(f"SELECT key, {TIMING_COLUMNS} FROM timings WHERE machine = ? AND key IN", keys, machine)
        return {key: timing for key, *values in found if (timing := _restore_timing(values)) is not None}

    # -- checks of files ---------------------------------------------------------------------------------------------

    def checked_file(self, key: str) -> dict[str, Any] | None:
        """Read the saved findings about a user's file, as plain values; None if the key has none."""
        with name_ledger_in_errors(self.path):
            if not self._has_checks():
                return None
            found = self._connection.execute("SELECT findings FROM checks WHERE key = ?", (key,)).fetchone()
        values = None if found is None else _decompress(found[0])
        # The key stands in the row, too: a row that was damaged is not taken for another.
        return values["found"] if isinstance(values, dict) and values.get("key") == key else None

    def keep_checked_file(self, key: str, name: str, values: Any) -> None:
        """Save the findings about a user's file, as plain values, under a key; replace earlier ones."""
        text = json.dumps({"key": key, "found": values}, separators=(",", ":")).encode()
        with name_ledger_in_errors(self.path), self._begin_transaction():
            self._connection.execute(CHECKS_TABLE)
            self._connection.execute(
                "INSERT OR REPLACE INTO checks VALUES (?, ?, ?)", (key, name, zlib.compress(text, 1))
            )

    def _has_checks(self) -> bool:
        """Return True if this ledger has the table of checked files, which older ones lack."""
        return bool(self._connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'checks'").fetchone())

    # -- all of it ---------------------------------------------------------------------------------------------------

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield a flat row for each run and each machine that timed it, in the order of the keys.

        Columns: see `tidy_row`. Damaged runs are left out, as in `results`, and counted in `damaged`.
        """
        self.damaged = 0
        with name_ledger_in_errors(self.path):
            found = self._connection.execute(
                f"SELECT cells.key, name, identity, result, {TIMING_COLUMNS} FROM cells "
                "LEFT JOIN runs ON runs.key = cells.key LEFT JOIN timings ON timings.key = cells.key "
                "ORDER BY cells.key, machine"
            )
            for key, name, text, blob, *timing in found:
                identity, saved = _restore_identity(key, text), None if blob is None else _unpack(blob)
                if identity is None or (saved is None and blob is not None):
                    self.damaged += 1
                    continue
                try:
                    row = tidy_row(key, name, identity, saved, None if timing[0] is None else _restore_timing(timing))
                except (AttributeError, KeyError, TypeError):  # JSON of other values than a result's
                    self.damaged += 1
                else:
                    yield row

    # -- SQLite ------------------------------------------------------------------------------------------------------

    def _select(self, statement: str, keys: Iterable[str], *first: str) -> list[Any]:
        with name_ledger_in_errors(self.path):
            chosen = f"{statement} (SELECT value FROM json_each(?))"
            return self._connection.execute(chosen, (*first, json.dumps(list(keys)))).fetchall()

    def _begin_transaction(self) -> sqlite3.Connection:
        """Begin a transaction, which is committed at the end of its `with`, or undone by an error."""
        # Ctrl-C may come after the beginning of one and before the `with` that would undo it.
        self._connection.rollback()
        # Locked for writing at once: waiting in the middle of a transaction is not possible in SQLite.
        self._connection.execute("BEGIN IMMEDIATE")
        return self._connection

    def _insert_case(self, key: str, case: Case) -> None:
        identity = json.dumps(case.identity() | case.labels, sort_keys=True, allow_nan=False)
        self._connection.execute("INSERT OR IGNORE INTO cells VALUES (?, ?, ?)", (key, case.name, identity))


def _pack(result: CaseResult) -> bytes:
    given = ((field, getattr(result, field.name)) for field in fields(result))
    values = {field.name: value for field, value in given if value is not None or field.default is not None}
    # The table of all runs reads the largest errors without the code of the study.
    values |= {SIZES: result.sizes()}
    text = msgspec.json.encode(values, enc_hook=plain_values)
    if b"null" in text:  # which may be a NaN: JSON has none, Python's own encoder does
        text = json.dumps(plain_values(values), separators=(",", ":")).encode()
    # The lightest compression halves the file; a stronger one costs more than writing does.
    return zlib.compress(text, 1)


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Collect no garbage: plain values have no cycles, and looking for some takes longer than reading them."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _unpack(blob: bytes) -> dict[str, Any] | None:
    """Return the plain values of the result in a row, or None if the row is damaged."""
    values = _decompress(blob)
    return values if isinstance(values, dict) and isinstance(values.get("outcome"), str) else None


def _decompress(blob: bytes) -> Any:
    """Return the plain values in a blob; None if it is damaged."""
    try:
        unpacking = zlib.decompressobj()
        text = unpacking.decompress(blob, MAX_RESULT_BYTES)
        return _decode_json(text) if unpacking.eof else None
    except (zlib.error, ValueError, TypeError, RecursionError):
        return None


def _decode_json(text: str | bytes) -> Any:
    """Decode JSON, a NaN and an infinity included; raises ValueError."""
    try:
        return msgspec.json.decode(text)  # four times as fast as Python's own decoder, which alone reads a NaN
    except msgspec.DecodeError:
        return json.loads(text)


def _restore_identity(key: str, text: str) -> dict[str, Any] | None:
    """Return the identity and labels in a row, or None unless the key was made from that identity."""
    try:
        found = _decode_json(text)
        bare = {name: value for name, value in found.items() if name != LABEL_KEY}
        return found if identity_digest(canonical_json(bare)) == key else None
    except (ValueError, TypeError, AttributeError, RecursionError):
        return None


def _restore_timing(values: list[Any]) -> Timing | None:
    """Return the timing in a row, or None if the row is damaged."""
    from conrod.execution.timing import Timing

    try:
        return msgspec.convert(dict(zip(TIMING_COLUMNS.split(", "), values, strict=True)), Timing)
    except msgspec.ValidationError:
        return None
