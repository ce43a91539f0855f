"""A user's FMU (FMI 2.0 and 3.0), as Modelica, Simulink and Amesim write them: run by FMPy, judged as a table is."""

from __future__ import annotations

import lzma
import zipfile
import zlib
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import isclose, prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from conrod.errors import InvalidInput, nearest, unknown_choice
from conrod.exact.link_rotations import ROTATIONS
from conrod.exact.motion import Array
from conrod.execution import local
from conrod.models.tables.columns import (
    MAX_LISTED_HEADINGS,
    TIME,
    Column,
    ColumnRequest,
    bare_unit,
    column_with_unit,
    quantities,
    rotation_column,
)
from conrod.models.tables.reading import MAX_TABLE_ROWS, Reading, check_values
from conrod.scenes import Scene

MIN_STEPS = 8  # steps of a run
# Outputs of an FMU that conrod wrote, by the quantity of a link's rotation.
WRITTEN_NAMES = dict(zip(ROTATIONS, ("angle", "rate", "acceleration"), strict=True))
SOLVER_TOLERANCES = {"model-exchange": 1e-9}  # of CVode, relative; FMPy's own is 1e-5


def run_fmu(
    path: Path, scene: Scene, request: ColumnRequest, mode: str | None, steps: int, revolutions: float, timeout: float
) -> Reading:
    """Run an FMU in a separate process and read its trajectory.

    Args:
        mode: None for the first that it has.
        steps: per revolution.
        timeout: longest time of the run [s].

    Raises:
        InvalidInput: the FMU or an option cannot be used, or the run does not complete.
    """
    with TemporaryDirectory(prefix="conrod-fmu-") as folder:
        fmu = local.call_on_file(read_fmu, path, folder)
        mode = fmu.modes[0] if mode is None else mode
        if mode not in fmu.modes:
            raise unknown_choice("mode in --preset", mode, fmu.modes)
        columns = choose_variables(fmu, tuple(scene.lengths), request)
        used = [fmu.variables[column.index - 1] for column in columns[1:]]
        unused = tuple(one.name for one in fmu.variables if one.output and one not in used)[:MAX_LISTED_HEADINGS]
        span = scene.kinematics.mechanism.driver.span  # of an input that makes one pass, that pass
        ends = (0.0, revolutions * scene.period) if span is None else sorted(angle / scene.speed for angle in span)
        count = round((ends[1] - ends[0]) / scene.period * steps)
        if not MIN_STEPS <= count < MAX_TABLE_ROWS:
            raise InvalidInput(
                f"--steps-per-rev {steps}: {count} steps in all: {MIN_STEPS} to {MAX_TABLE_ROWS - 1} are taken"
            )
        values = local.call_on_file(simulate, path, folder, mode, (*ends, count), used, timeout=timeout)
    has = "".join(f"; it has {other}, too: --preset {other}" for other in fmu.modes if other != mode)
    solver = f", CVode at {SOLVER_TOLERANCES[mode]:.0e}" if mode in SOLVER_TOLERANCES else ""
    tool = f"; {fmu.tool}" if fmu.tool else ""
    token = f"; its binary does not contain its token {fmu.foreign_token[:60]!r}, and may be of another build"
    form = f"FMI {fmu.version} {mode}, {steps} steps a turn{solver}{tool}{has}{token if fmu.foreign_token else ''}"
    return check_values(columns, values, np.arange(1, len(values) + 1), unused, form)


# -- its variables as columns ------------------------------------------------------------------------------------------
MAX_COMPARED_NAMES = 20_000  # names that a mistyped one is compared with


def choose_variables(fmu: FmuDescription, points: Sequence[str], request: ColumnRequest) -> list[Column]:
    """Choose the variables of an FMU that are used as columns, in the order of `quantities`, time first.

    An output that is called as a quantity of the scene is, `C.x`, is that quantity unless another is named.

    Raises:
        InvalidInput: a variable is missing or has no unit, or no variable can be judged.
    """
    variables = {variable.name: (place, variable) for place, variable in enumerate(fmu.variables, start=1)}
    outputs = [variable.name for variable in fmu.variables if variable.output]
    more = ", ..." if len(outputs) > MAX_LISTED_HEADINGS else ""
    listed = f"its outputs are {', '.join(outputs[:MAX_LISTED_HEADINGS]) or 'none'}{more}"
    columns = [Column(TIME, 0, TIME, "s", 1.0, "FMI")]
    names = WRITTEN_NAMES.items()
    written = {rotation_column(q, link): f"{link}.{name}" for link in request.links for q, name in names}
    for quantity, dimension in quantities(points, request.links).items():
        own = next((name for name in (quantity, written.get(quantity)) if name in outputs), None)
        name = request.columns.get(quantity, own)
        if name is None or quantity == TIME:
            continue
        if name not in variables:
            near = " or ".join(map(repr, nearest(name, list(variables)[:MAX_COMPARED_NAMES]))) or "none like it"
            raise InvalidInput(f"it has no variable {name!r}, but {near} among {len(variables)}; {listed}")
        place, variable = variables[name]
        column = column_with_unit(
            quantity, dimension, place, name, "" if bare_unit(variable.unit) == "" else variable.unit, request
        )
        if column.unit_from == "assumed":
            said = f"say with --unit {dimension} what it is in"
            raise InvalidInput(f"{name} has no unit in the model description: {said}")
        columns.append(replace(column, unit_from=column.unit_from.replace("heading", "model description")))
    if len(columns) == 1:
        said = f"--column {points[0]}.x=VARIABLE"
        raise InvalidInput(f"say which variables are the motion of an observed point: {said}; {listed}")
    return columns


# -- the archive -------------------------------------------------------------------------------------------------------

DESCRIPTION = "modelDescription.xml"
MAX_UNPACKED_BYTES = 1 << 30  # models of whole plants unpack to some hundred MB
# The last but one: encrypted.
ARCHIVE_ERRORS = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, ValueError, RuntimeError, OSError)


def unpack(path: Path, folder: str) -> list[str]:
    """Unpack an FMU; return the names of its files.

    Raises:
        InvalidInput: the file is no FMU, or an archive that was made to do harm.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names, total = archive.namelist(), sum(entry.file_size for entry in archive.infolist())
            if DESCRIPTION in names and total <= MAX_UNPACKED_BYTES:
                archive.extractall(folder)
    except ARCHIVE_ERRORS as error:
        raise InvalidInput(f"it is no zip archive, or a damaged one: {error}") from None
    if total > MAX_UNPACKED_BYTES:
        raise InvalidInput(f"it unpacks to {len(names)} files, {total} bytes: more than a model has")
    if DESCRIPTION not in names:
        raise InvalidInput(f"it is no FMU: it has no {DESCRIPTION}")
    return names


# -- the description ---------------------------------------------------------------------------------------------------

# By the names that a user gives them, as FMPy calls them, and its attribute of each.
MODES = {"co-simulation": "CoSimulation", "model-exchange": "ModelExchange"}
MAX_ELEMENTS = 1_000_000  # of all real variables
REAL_TYPES = ("Real", "Float32", "Float64")


@dataclass(frozen=True)
class FmuVariable:
    """A real variable of an FMU, or one element of an array variable.

    Attributes:
        name: name as a user writes it, `slider.r[1]`.
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
class FmuDescription:
    """Model description of an FMU, as its XML file states it.

    Attributes:
        version: version of FMI.
        tool: tool that wrote the FMU; empty where it does not say.
        modes: modes of the FMU, of `MODES`.
        foreign_token: token (a GUID in FMI 2.0) where no binary contains it, so that description and binary may be of
            different builds; else empty.
    """

    version: str
    tool: str
    modes: tuple[str, ...]
    variables: tuple[FmuVariable, ...]
    foreign_token: str = ""


def read_fmu(path: Path, folder: str) -> FmuDescription:
    """Unpack an FMU into a folder and read its description; none of its code is loaded.

    Raises:
        InvalidInput: the FMU cannot be used here; says why.
    """
    try:
        import fmpy
    except ImportError:
        raise InvalidInput("FMPy, which runs FMUs, is not installed: pip install 'conrod[fmi]'") from None
    names = unpack(path, folder)
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
    folders = [f"binaries/{name}/" for name in (fmpy.platform, fmpy.platform_tuple)]
    binaries = [name for name in names if name.startswith(tuple(folders))]
    if not binaries:
        there = sorted({name.rpartition("/")[0] for name in names if name.startswith("binaries/")})
        raise InvalidInput(
            f"it has no binary for this platform, {' or '.join(folders)}, but {', '.join(there) or 'none'}; of C "
            "sources `fmpy compile` builds one"
        )
    token = found.guid or ""
    foreign = "" if any(_contains(Path(folder, name), token) for name in binaries) else token
    return FmuDescription(found.fmiVersion, found.generationTool or "", modes, tuple(_real_variables(found)), foreign)


def _contains(file: Path, text: str) -> bool:
    """Whether a file contains a text; a token is looked for without its braces, which some generators add."""
    return file.is_file() and text.strip("{} ").encode() in file.read_bytes()


def _real_variables(found: Any) -> Iterator[FmuVariable]:
    """Yield the real variables of a model description, arrays by element."""
    count = 0
    for one in found.modelVariables:
        if one.type not in REAL_TYPES or one.causality == "independent":
            continue
        count += prod(one.shape)
        if count > MAX_ELEMENTS:
            sizes = f"its variable {one.name} has {len(one.shape)} dimensions"
            raise InvalidInput(f"{sizes} and brings it to more than {MAX_ELEMENTS} real numbers, which no model has")
        unit = one.unit or (one.declaredType and one.declaredType.unit) or ""
        places = product(*(range(1, size + 1) for size in one.shape))
        for index, place in enumerate(places):
            element = f"[{','.join(map(str, place))}]" if place else ""
            yield FmuVariable(f"{one.name}{element}", unit, one.causality == "output", one.name, index)


# -- a run -------------------------------------------------------------------------------------------------------------


def simulate(
    _: Path, folder: str, mode: str, span: tuple[float, float, int], variables: Sequence[FmuVariable]
) -> Array:
    """Run an unpacked FMU from its initialisation to the end.

    Args:
        span: start and stop [s], and the number of samples from one to the other.

    Returns:
        Time and variables (T, 1 + variables), in the FMU's units.

    Raises:
        InvalidInput: a call of the FMU failed, or the FMU stopped before the end.
    """
    import fmpy

    start, stop, count = span
    said = deque[str](maxlen=1)

    def log(*arguments: Any) -> None:
        said.append(arguments[-1].decode(errors="replace"))

    try:
        result = fmpy.simulate_fmu(
            folder, fmi_type=MODES[mode], start_time=start, stop_time=stop,
            output_interval=(stop - start) / count, relative_tolerance=SOLVER_TOLERANCES.get(mode),
            output=[variable.array for variable in variables], logger=log, record_events=False, remote_platform=None,
        )  # fmt: skip
    except Exception as error:  # of FMPy, CVode and ctypes; the FMU's own words say more than its status
        reason = " ".join([*str(error).split(), *"".join(said).split()])
        raise InvalidInput(f"{mode} failed: {reason}") from None
    times, rows = result["time"], len(result)
    if not isclose(times[-1], stop, rel_tol=1e-9, abs_tol=1e-9 * (stop - start)):
        raise InvalidInput(f"{mode} failed: it ended at {times[-1]:.6g} s of {stop:.6g} s")
    return np.column_stack([times, *(result[one.array].reshape(rows, -1)[:, one.index] for one in variables)])
