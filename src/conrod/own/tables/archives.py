"""Columns of numpy archives (.npz) and Parquet files."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array

LARGEST_ENTRY = 1 << 30  # bytes that an entry of an archive may unpack to


@dataclass(frozen=True)
class Archive:
    """A file of named columns, of which those that are used are loaded.

    Attributes:
        headings: of all columns; a unit is in brackets.
        rows: of each.
        column: gives the values (T,) of the column at a place.
    """

    form: str
    headings: tuple[str, ...]
    rows: Sequence[int]
    column: Callable[[int], Array]


def open_npz(path: Path) -> Archive:
    """A numpy archive: an array (T,) a column, (T, 2) for x and y; an entry `units` of names and units.

    Raises:
        InvalidInput: it is no such archive, or holds what would have to be executed to be read.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            largest = max((entry.file_size for entry in archive.infolist()), default=0)
        if largest > LARGEST_ENTRY:
            raise InvalidInput(f"{path}: an array of {largest} bytes is too large: at most {LARGEST_ENTRY} are kept")
        with np.load(path, allow_pickle=False) as loaded:
            arrays = {name: np.asarray(loaded[name]) for name in loaded.files}
    except (OSError, ValueError, zipfile.BadZipFile, EOFError, KeyError) as error:
        reason = "it holds Python objects, which are not loaded" if "pickle" in str(error) else "it is no numpy archive"
        raise InvalidInput(f"{path}: {reason}") from None
    units = _units_entry(arrays)
    columns = _flat({name: array for name, array in arrays.items() if array.ndim and array.dtype.kind in "fiu"})
    headings = tuple(f"{name} [{units[name]}]" if units.get(name) else name for name in columns)
    values = list(columns.values())
    return Archive(
        "numpy archive", headings, [len(v) for v in values], lambda place: np.asarray(values[place], dtype=float)
    )


def _units_entry(arrays: Mapping[str, Any]) -> dict[str, str]:
    units = arrays.get("units")
    if units is None or units.ndim != 2 or units.shape[1] != 2 or units.dtype.kind != "U":
        return {}
    return {str(name): str(unit) for name, unit in units}


def _flat(arrays: Mapping[str, Any]) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    for name, array in arrays.items():
        if array.ndim == 1:
            columns[name] = array
        elif array.ndim == 2 and array.shape[1] == 2:
            columns |= {f"{name}.{axis}": array[:, k] for k, axis in enumerate("xy")}
    return columns


def open_parquet(path: Path) -> Archive:
    """A Parquet file; a column's unit is in its name, or in its field's metadata under `unit`.

    Raises:
        InvalidInput: it is no Parquet file, or pyarrow is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise InvalidInput(f"{path}: reading Parquet needs pyarrow: pip install 'conrod[parquet]'") from None
    try:
        file = pyarrow.parquet.ParquetFile(path)
    except (pyarrow.ArrowException, OSError):
        raise InvalidInput(f"{path}: it is no Parquet file") from None
    schema = file.schema_arrow
    headings = []
    for field in schema:
        unit = (field.metadata or {}).get(b"unit", b"").decode(errors="replace")
        headings.append(f"{field.name} [{unit}]" if unit else field.name)

    def column(place: int) -> Array:
        name = schema.names[place]
        try:
            # By what it is called whole: a name with a point is not a path.
            values = file.read(columns=[name], use_threads=False).column(0)
            return np.asarray(values.cast(pyarrow.float64()).to_numpy(zero_copy_only=False), dtype=float)
        except (pyarrow.ArrowException, OSError, KeyError):
            kind = schema.field(place).type
            raise InvalidInput(f"{path}: column {name!r} ({kind}) cannot be read as numbers") from None

    return Archive("Parquet", tuple(headings), [file.metadata.num_rows] * len(schema.names), column)
