"""A user's FMU: its archive, what it says of itself, and a run of it by FMPy.

All of this is called confined: an FMU may be made to do harm, and is native code that may do anything.
"""

from __future__ import annotations

import lzma
import zipfile
import zlib
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import isclose, prod
from pathlib import Path
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array

# -- the archive -------------------------------------------------------------------------------------------------------

DESCRIPTION = "modelDescription.xml"
# Models of whole plants describe 200 000 variables in some 60 MB, and unpack to some hundred.
MOST_FILES, MOST_BYTES, MOST_DESCRIPTION = 100_000, 1 << 30, 1 << 27
# The last but one: encrypted.
BROKEN = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, ValueError, RuntimeError, OSError)


def unpack(path: Path, folder: Path, wanted: Sequence[str]) -> tuple[str, ...]:
    """Unpack the model description and some folders of an FMU, "binaries/linux64/"; return the names of all its files.

    Raises:
        InvalidInput: it is no such archive, or one that was made to do harm.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = {entry.filename: entry.file_size for entry in archive.infolist()}
            total = sum(entries.values())
            if DESCRIPTION not in entries:
                raise InvalidInput(f"it is no FMU: it has no {DESCRIPTION}")
            if len(entries) > MOST_FILES or total > MOST_BYTES or entries[DESCRIPTION] > MOST_DESCRIPTION:
                raise InvalidInput(f"it unpacks to {len(entries)} files, {total} bytes: more than a model has")
            named = [name for name in entries if name == DESCRIPTION or name.startswith(tuple(wanted))]
            archive.extractall(folder, members=named)
    except InvalidInput:
        raise
    except BROKEN as error:
        raise InvalidInput(f"it is no zip archive, or a damaged one: {error}") from None
    return tuple(entries)


# -- the description ---------------------------------------------------------------------------------------------------

# By the names that a user gives them, as FMPy calls them, and its attribute of each.
MODES = {"co-simulation": "CoSimulation", "model-exchange": "ModelExchange"}
REAL = ("Real", "Float32", "Float64")
MOST_VARIABLES = 1_000_000  # elements of arrays among them


@dataclass(frozen=True)
class Variable:
    """A real variable, or an element of one that is an array.

    Attributes:
        name: as a user writes it, `slider.r[1]`.
        unit: declared; empty for none.
        array: the FMU's own variable.
        index: place of the element in it, from 0.
    """

    name: str
    unit: str
    output: bool
    array: str
    index: int


@dataclass(frozen=True)
class Description:
    """Description of an FMU, known before it is run.

    Attributes:
        version: of FMI.
        tool: that wrote it; empty where it does not say.
        modes: that it has, of `MODES`.
    """

    version: str
    tool: str
    modes: tuple[str, ...]
    variables: tuple[Variable, ...]


def read_fmu(path: Path, folder: str) -> Description:
    """Unpack an FMU into a folder and read its description; none of its code is loaded.

    Raises:
        InvalidInput: it cannot be used here; says why.
    """
    try:
        import fmpy
    except ImportError:
        raise InvalidInput("FMPy, which runs FMUs, is not installed: pip install 'conrod[fmi]'") from None
    folders = [f"binaries/{name}/" for name in (fmpy.platform, fmpy.platform_tuple)]
    names = unpack(path, Path(folder), [*folders, "resources/"])
    try:
        found = fmpy.read_model_description(folder)
    except Exception as error:  # FMPy raises all kinds, and lxml more of them
        reason = " ".join(str(error).splitlines()[:2])
        raise InvalidInput(f"its description cannot be used: {reason} (`fmpy validate` says all)") from None
    interfaces = zip(MODES, (found.coSimulation, found.modelExchange), strict=True)
    modes = tuple(name for name, interface in interfaces if interface)
    if found.fmiVersion == "1.0" or not modes:
        has = f"FMI {found.fmiVersion}, {' and '.join(modes) or 'neither'}"
        raise InvalidInput(f"co-simulation and model exchange of FMI 2.0 and 3.0 are run: it has {has}")
    if not any(name.startswith(tuple(folders)) for name in names):
        there = sorted({name.rpartition("/")[0] for name in names if name.startswith("binaries/")})
        raise InvalidInput(
            f"it has no binary for this platform, {' or '.join(folders)}, but {', '.join(there) or 'none'}; of C "
            "sources `fmpy compile` builds one"
        )
    return Description(found.fmiVersion, found.generationTool or "", modes, tuple(_variables(found)))


def _variables(found: Any) -> Iterator[Variable]:
    reals = [one for one in found.modelVariables if one.type in REAL and one.causality != "independent"]
    if (count := sum(prod(one.shape) for one in reals)) > MOST_VARIABLES:
        raise InvalidInput(f"it has {count} real variables: at most {MOST_VARIABLES} are read")
    for one in reals:
        unit = one.unit or (one.declaredType and one.declaredType.unit) or ""
        places = product(*(range(1, size + 1) for size in one.shape))
        for index, place in enumerate(places):
            element = f"[{','.join(map(str, place))}]" if place else ""
            yield Variable(f"{one.name}{element}", unit, one.causality == "output", one.name, index)


# -- a run -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Order:
    """A run that is asked for.

    Attributes:
        mode: of `MODES`.
        steps: per revolution, of communication in co-simulation, of samples in model exchange.
        tolerance: of CVode, relative; None in co-simulation.
        start, stop: [s].
        count: of samples from start to stop.
    """

    mode: str
    steps: int
    tolerance: float | None
    start: float
    stop: float
    count: int

    def __str__(self) -> str:
        solver = "" if self.tolerance is None else f", CVode at {self.tolerance:.0e}"
        return f"{self.mode}, {self.steps} steps a turn{solver}"


def simulate(_: Path, folder: str, order: Order, variables: Sequence[Variable]) -> Array:
    """Run an unpacked FMU from its initialisation to the end.

    Returns:
        Time and variables (T, 1 + variables), in the FMU's units.

    Raises:
        InvalidInput: a call of it failed, or it ended before its time.
    """
    import fmpy

    said = deque[str](maxlen=1)

    def log(*arguments: Any) -> None:
        said.append(arguments[-1].decode(errors="replace"))

    try:
        result = fmpy.simulate_fmu(
            folder, fmi_type=MODES[order.mode], start_time=order.start, stop_time=order.stop,
            output_interval=(order.stop - order.start) / order.count, relative_tolerance=order.tolerance,
            output=[variable.array for variable in variables], logger=log, record_events=False, remote_platform=None,
        )  # fmt: skip
    except Exception as error:  # of FMPy, CVode and ctypes; the FMU's own words say more than its status
        reason = " ".join([*str(error).split(), *"".join(said).split()])
        raise InvalidInput(f"{order.mode} failed: {reason}") from None
    times, rows = result["time"], len(result)
    if not isclose(times[-1], order.stop, rel_tol=1e-9, abs_tol=1e-9 * (order.stop - order.start)):
        raise InvalidInput(f"{order.mode} failed: it ended at {times[-1]:.6g} s of {order.stop:.6g} s")
    return np.column_stack([times, *(result[one.array].reshape(rows, -1)[:, one.index] for one in variables)])
