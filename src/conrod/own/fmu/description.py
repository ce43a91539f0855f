"""What an FMU says of itself: version, modes, variables with their units; to be read confined, it is a user's file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput
from conrod.own.fmu.archive import unpack

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
    """What is known of an FMU before it is run.

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
        raise _other_platform(names, folders)
    return Description(found.fmiVersion, found.generationTool or "", modes, tuple(_variables(found)))


def _other_platform(names: tuple[str, ...], wanted: list[str]) -> InvalidInput:
    has = sorted({name.split("/")[1] for name in names if name.startswith("binaries/") and name.count("/") > 1})
    sources = any(name.startswith("sources/") for name in names)
    compile_it = "; it has its C sources: `fmpy compile` builds one (that runs what they say)" if sources else ""
    return InvalidInput(
        f"it has no binary for this platform ({' or '.join(name.split('/')[1] for name in wanted)}): "
        f"it has {', '.join(has) or 'none'}{compile_it}"
    )


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
