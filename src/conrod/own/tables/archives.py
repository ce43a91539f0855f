"""Columns of numpy archives (.npz) and Parquet files."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.columns import Column, Source

LARGEST_ENTRY = 1 << 30  # bytes that an entry of an archive may unpack to


def open_npz(path: Path) -> Source:
    """A numpy archive: an array (T,) a column, (T, 2) for x and y; an entry `units` of names and units.

    Raises:
        InvalidInput: it is no such archive, or holds what would have to be executed to be read.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            largest = max((entry.file_size for entry in archive.infolist()), default=0)
        if largest > LARGEST_ENTRY:
            raise InvalidInput(f"an array of {largest} bytes is too large: at most {LARGEST_ENTRY} are kept")
        with np.load(path, allow_pickle=False) as loaded:
            arrays = {name: np.asarray(loaded[name]) for name in loaded.files}
    except InvalidInput:
        raise
    except (OSError, ValueError, zipfile.BadZipFile, EOFError, KeyError) as error:
        reason = "it holds Python objects, which are not loaded" if "pickle" in str(error) else "it is no numpy archive"
        raise InvalidInput(reason) from None
    units, columns = _units_entry(arrays.get("units")), dict[str, Any]()
    for name, array in arrays.items():
        numeric = array.dtype.kind in "fiu"
        if numeric and array.ndim == 1:
            columns[name] = array
        elif numeric and array.ndim == 2 and array.shape[1] == 2:
            columns |= {f"{name}.{axis}": array[:, k] for k, axis in enumerate("xy")}

    def read(wanted: Sequence[Column], most: int) -> tuple[Array, NDArray[np.int64]]:
        chosen = {column.target.name: list(columns.values())[column.index] for column in wanted}
        lengths = {name: len(values) for name, values in chosen.items()}
        if len(set(lengths.values())) > 1:
            raise InvalidInput(f"columns of different lengths: {', '.join(f'{n} {k}' for n, k in lengths.items())}")
        numbers = _numbered(max(lengths.values()), most)
        return np.column_stack([np.asarray(values, dtype=float) for values in chosen.values()]), numbers

    return Source("numpy archive", tuple(_heading(name, units.get(name)) for name in columns), (), read)


def _units_entry(units: Any) -> dict[str, str]:
    if units is None or units.ndim != 2 or units.shape[1] != 2 or units.dtype.kind != "U":
        return {}
    return {str(name): str(unit) for name, unit in units}


def _heading(name: str, unit: str | None) -> str:
    return f"{name} [{unit}]" if unit else name


def _numbered(rows: int, most: int) -> NDArray[np.int64]:
    if rows > most:
        raise InvalidInput(f"it has {rows} rows: at most {most} are kept: thin it out")
    return np.arange(1, rows + 1)


def open_parquet(path: Path) -> Source:
    """A Parquet file; a column's unit is in its name, or in its field's metadata under `unit`.

    Raises:
        InvalidInput: it is no Parquet file, or pyarrow is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise InvalidInput("reading Parquet needs pyarrow: pip install 'conrod[parquet]'") from None
    try:
        file = pyarrow.parquet.ParquetFile(path)
    except (pyarrow.ArrowException, OSError):
        raise InvalidInput("it is no Parquet file") from None
    schema = file.schema_arrow

    def values_of(name: str) -> Array:
        try:
            # By what it is called whole: a name with a point is not a path.
            values = file.read(columns=[name], use_threads=False).column(0)
            return np.asarray(values.cast(pyarrow.float64()).to_numpy(zero_copy_only=False), dtype=float)
        except (pyarrow.ArrowException, OSError, KeyError):
            raise InvalidInput(f"column {name!r} ({schema.field(name).type}) cannot be read as numbers") from None

    def read(wanted: Sequence[Column], most: int) -> tuple[Array, NDArray[np.int64]]:
        numbers = _numbered(file.metadata.num_rows, most)
        return np.column_stack([values_of(schema.names[column.index]) for column in wanted]), numbers

    units = [(field.metadata or {}).get(b"unit", b"").decode(errors="replace") for field in schema]
    return Source("Parquet", tuple(map(_heading, schema.names, units)), (), read)
