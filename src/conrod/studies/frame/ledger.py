"""The ledger: what every finished run showed and cost, in one SQLite file that outlives the process."""

from __future__ import annotations

import json
import os
import sqlite3
import zlib
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import msgspec
import platformdirs

from conrod.errors import InvalidInput
from conrod.scenes.scene import canonical_json
from conrod.studies.frame.case import Case, Measurement, key_of
from conrod.studies.frame.ledger_file import PATIENCE, Claims, connected, connected_for_reading, naming_ledger
from conrod.studies.frame.writing import real_path

if TYPE_CHECKING:
    from conrod.studies.frame.timing import Timing

LARGEST = 1 << 28  # bytes of a measurement: some kB, or MB where a run's payload is kept
LABEL = "label"  # kept with the identity, and no part of it: the preset that the settings are
TIMING = "machine, seconds_per_revolution, reference_seconds, ratio, steps, repeats"


def default_path() -> Path:
    """CONROD_LEDGER where it is set, otherwise a file in the user's cache folder."""
    named = os.environ.get("CONROD_LEDGER")
    return Path(named) if named else platformdirs.user_cache_path("conrod") / "ledger.sqlite"


class Ledger:
    """Finished runs by the key of their case; timings apart from them, by machine.

    What `keep` returned from survives the process being killed at any moment. Several processes may use one ledger.
    Every method raises InvalidInput, in one line, where the file is locked for long, on a full disk, read-only or
    damaged as a whole; what was kept before stays. A single damaged row counts as not there.

    Attributes:
        claims: of this process on what it runs; closed with the ledger.
        damaged: how many runs `rows` has left out.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._connection = connection
        self.claims = Claims(real_path(path))
        self.damaged = 0

    @classmethod
    def open(cls, path: Path, patience: float = PATIENCE) -> Ledger:
        """The ledger in a file; makes the file and its folders where there are none.

        Args:
            patience: how long to wait for another process that writes [s].

        Raises:
            InvalidInput: it cannot be made, or what is there is no ledger, or one of a newer conrod.
        """
        return cls(path, connected(path, patience))

    @classmethod
    @contextmanager
    def reading(cls, path: Path) -> Iterator[Self]:
        """The ledger in a file that is there, of which nothing is kept; it may lie where nothing can be written.

        Raises:
            InvalidInput: as `open`.
        """
        with connected_for_reading(path) as connection, cls(path, connection) as ledger:
            yield ledger

    def close(self) -> None:
        """Give the file back; closing twice does nothing."""
        self._connection.close()
        self.claims.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    # -- runs --------------------------------------------------------------------------------------------------------

    def finished(self, keys: Iterable[str]) -> set[str]:
        """Those of the keys of which the ledger has a run, however it ended."""
        return {key for (key,) in self._select("SELECT key FROM runs WHERE key IN", set(keys))}

    def stopped(self, keys: Iterable[str]) -> dict[str, tuple[str, float]]:
        """Those of the keys whose run ended at a limit: outcome, and what it was allowed [s] or [bytes]."""
        # They are few, and have an index of their own: all are read, whatever is asked for.
        with naming_ledger(self.path):
            found = self._connection.execute(
                "SELECT key, outcome, allowed FROM runs WHERE allowed IS NOT NULL"
            ).fetchall()
        wanted = set(keys) if found else ()
        return {key: (outcome, allowed) for key, outcome, allowed in found if key in wanted}

    def measurements(self, keys: Iterable[str]) -> dict[str, Measurement]:
        """Measurements of the runs of the keys that have been run; in the order of the keys.

        A row that is damaged, what is known of the run's case included, counts as not there.
        """
        wanted = list(keys)
        rows = self._select("SELECT key, identity, measurement FROM runs JOIN cells USING (key) WHERE key IN", wanted)
        found = {key: _unpacked(blob) for key, identity, blob in rows if _identity(key, identity) is not None}
        return {key: measured for key in wanted if (measured := found.get(key)) is not None}

    def keep(self, case: Case, measurement: Measurement, limit: float | None = None, *, replace: bool = False) -> None:
        """Keep what a run showed, in the place of what was kept of it before.

        Args:
            limit: what a run that ended at a limit was allowed: time [s] where it timed out, memory [bytes] where it
                ran out of that.
            replace: let such a run take the place even of one that ended by itself, which may be another process's.
        """
        key = case.key
        with naming_ledger(self.path), self._writing():
            self._note(key, case)
            self._connection.execute(
                "INSERT INTO runs VALUES (?, ?, ?, ?) ON CONFLICT (key) DO UPDATE SET outcome = excluded.outcome, "
                "allowed = excluded.allowed, measurement = excluded.measurement "
                "WHERE ? OR excluded.allowed IS NULL OR runs.allowed IS NOT NULL",
                (key, measurement.outcome, limit, _packed(measurement), replace),
            )

    def forget(self, keys: Collection[str]) -> None:
        """Drop what there is of runs that cannot be read, so that they can be kept anew."""
        with naming_ledger(self.path), self._writing():
            for table in ("runs", "cells"):
                self._connection.executemany(f"DELETE FROM {table} WHERE key = ?", ((key,) for key in keys))
            # Rows and their index may have been damaged apart from each other.
            self._connection.execute("REINDEX")
        if self.finished(keys):
            raise InvalidInput(f"the ledger {self.path} is damaged beyond its rows; remove it or name another")

    # -- timings -----------------------------------------------------------------------------------------------------

    def keep_timing(self, case: Case, timing: Timing) -> None:
        """Keep what a run cost, in the place of what it cost on the same machine before."""
        key = case.key
        with naming_ledger(self.path), self._writing():
            self._note(key, case)
            self._connection.execute(
                f"INSERT OR REPLACE INTO timings (key, {TIMING}) VALUES (:key, :machine, :seconds_per_revolution, "
                ":reference_seconds, :ratio, :steps, :repeats)",
                {"key": key, **asdict(timing)},
            )

    def timings(self, keys: Iterable[str], machine: str) -> dict[str, Timing]:
        """Timings of the runs of the keys that were timed on a machine."""
        found = self._select(f"SELECT key, {TIMING} FROM timings WHERE machine = ? AND key IN", keys, machine)
        return {key: timing for key, *values in found if (timing := _timing(values)) is not None}

    # -- all of it ---------------------------------------------------------------------------------------------------

    def rows(self) -> Iterator[dict[str, Any]]:
        """A flat row for each run, and for each machine on which it was timed; in the order of the keys.

        Columns: see `tidy_row`. What is damaged is left out, see `measurements`; `damaged` counts those runs.
        """
        from conrod.studies.frame.results_table import tidy_row

        self.damaged = 0
        with naming_ledger(self.path):
            found = self._connection.execute(
                f"SELECT cells.key, name, identity, measurement, {TIMING} FROM cells "
                "LEFT JOIN runs ON runs.key = cells.key LEFT JOIN timings ON timings.key = cells.key "
                "ORDER BY cells.key, machine"
            )
            for key, name, text, blob, *timing in found:
                identity, measured = _identity(key, text), None if blob is None else _unpacked(blob)
                if identity is None or (measured is None and blob is not None):
                    self.damaged += 1
                else:
                    yield tidy_row(key, name, identity, measured, None if timing[0] is None else _timing(timing))

    # -- SQLite ------------------------------------------------------------------------------------------------------

    def _select(self, statement: str, keys: Iterable[str], *first: str) -> list[Any]:
        with naming_ledger(self.path):
            chosen = f"{statement} (SELECT value FROM json_each(?))"
            return self._connection.execute(chosen, (*first, json.dumps(list(keys)))).fetchall()

    def _writing(self) -> sqlite3.Connection:
        """A transaction: committed at its end, undone by an error."""
        # Locked for writing at once: waiting in the middle of a transaction is not possible in SQLite.
        self._connection.execute("BEGIN IMMEDIATE")
        return self._connection

    def _note(self, key: str, case: Case) -> None:
        identity = json.dumps(case.identity() | case.labels, sort_keys=True, allow_nan=False)
        self._connection.execute("INSERT OR IGNORE INTO cells VALUES (?, ?, ?)", (key, case.name, identity))


def _packed(measurement: Measurement) -> bytes:
    # Its fields hold plain values: `plain` would copy them all, which takes longer than all the rest here.
    values = {name: value for name, value in vars(measurement).items() if value is not None}
    text = msgspec.json.encode(values)
    if b"null" in text:  # which may be a NaN: JSON has none, Python's own encoder does
        text = json.dumps(values, separators=(",", ":")).encode()
    # The lightest compression halves the file; a stronger one costs more than writing does.
    return zlib.compress(text, 1)


def _unpacked(blob: bytes) -> Measurement | None:
    """The measurement, None if the row is damaged."""
    try:
        # Not msgspec's decoder: Python's own wrote and reads a NaN.
        unpacking = zlib.decompressobj()
        text = unpacking.decompress(blob, LARGEST)
        return Measurement(**json.loads(text)) if unpacking.eof else None
    except (zlib.error, ValueError, TypeError, RecursionError):
        return None


def _identity(key: str, text: str) -> dict[str, Any] | None:
    """The identity, with the labels beside it, None unless it is the one that the key was made from."""
    try:
        found = json.loads(text)
        bare = {name: value for name, value in found.items() if name != LABEL}
        return found if key_of(canonical_json(bare)) == key else None
    except (ValueError, TypeError, AttributeError, RecursionError):
        return None


def _timing(values: list[Any]) -> Timing | None:
    """The timing, None if the row is damaged."""
    from conrod.studies.frame.timing import Timing

    try:
        return msgspec.convert(dict(zip(TIMING.split(", "), values, strict=True)), Timing)
    except msgspec.ValidationError:
        return None
