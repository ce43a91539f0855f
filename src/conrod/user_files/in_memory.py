"""Models and tables in memory: each is judged in a process of its own, which takes a file."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from conrod.errors import InvalidInput

if TYPE_CHECKING:
    import mujoco

Model: TypeAlias = "str | Path | mujoco.MjModel | mujoco.MjSpec"


@contextmanager
def file_of_model(model: Model) -> Iterator[tuple[Path, str | None]]:
    """The file of a model, and what to call it; one in memory is saved for the while."""
    if isinstance(model, str | Path):
        yield Path(model), None
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "model.mjb")
        with _name_in_errors(path, "the model"):
            _save_model(model, path)
            yield path, "the model"


def _save_model(model: object, path: Path) -> None:
    """Write an MjModel or MjSpec as a binary file; raises InvalidInput for anything else."""
    import mujoco  # loaded late: a table in memory needs none

    if isinstance(model, mujoco.MjSpec):
        model = model.compile()
    if not isinstance(model, mujoco.MjModel):
        raise InvalidInput(
            f"a {type(model).__name__} cannot be judged: give a scene, a file, a mujoco.MjModel or MjSpec, a data "
            "frame or a mapping of numpy arrays"
        )
    mujoco.mj_saveModel(model, str(path))


@contextmanager
def file_of_table(table: Any) -> Iterator[tuple[Path, str | None]]:
    """The file of a table, and what to call it; one in memory is saved for the while."""
    if isinstance(table, str | Path):
        yield Path(table), None
        return
    columns = columns_of(table)
    if columns is None:
        raise InvalidInput(f"a {type(table).__name__} is no table: give a file, a data frame or a mapping of arrays")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "table.npz")
        with _name_in_errors(path, "the table"):
            np.savez(path, allow_pickle=False, **_arrays_by_name(columns))
            yield path, "the table"


@contextmanager
def _name_in_errors(path: Path, name: str) -> Iterator[None]:
    """Name in errors the object in memory in place of its temporary file."""
    try:
        yield
    except InvalidInput as error:
        raise type(error)(str(error).replace(str(path), name)) from None


def columns_of(subject: Any) -> Mapping[str, Any] | None:
    """Columns by name of a mapping or a data frame (pandas, polars, pyarrow); None for other objects."""
    if isinstance(subject, Mapping):
        return subject
    names = getattr(subject, "column_names", getattr(subject, "columns", None))
    return None if names is None else {str(name): subject[name] for name in names}


def _arrays_by_name(given: Mapping[str, Any]) -> dict[str, Any]:
    """Convert values to arrays by name; raises InvalidInput for a value that is no array."""
    arrays = {str(name): np.asarray(value) for name, value in given.items()}
    for name, array in arrays.items():
        # The last two are numpy's own keywords.
        if array.dtype.kind not in "fiu" or array.ndim == 0 or name in ("file", "allow_pickle"):
            raise InvalidInput(f"the table: {name!r}: an array of numbers is wanted, by the name of a column")
    return arrays
