"""The exact motion as a functional mock-up unit (FMI 3.0), which simulation tools load."""

import hashlib
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

import jinja2
import numpy as np

from conrod.exact.motion import Array
from conrod.exact.motion_table import MotionTable, motion_table
from conrod.models.export.pack import zip_archive
from conrod.report.table import visible_text
from conrod.scenes import Scene

COMPILER = "cc"
# No fused multiply-add, as in the check at export; only the functions of FMI are exported.
FLAGS = ("-std=c99", "-O2", "-shared", "-fPIC", "-ffp-contract=off", "-fvisibility=hidden")
ARCHITECTURES = {"amd64": "x86_64", "arm64": "aarch64"}  # names in FMI, where they differ
SUFFIXES = {"linux": ".so", "darwin": ".dylib"}
PACKAGE_FILES = files("conrod.models.export.fmu")


def fmu(name: str, scene: Scene) -> tuple[bytes, str | None]:
    """Build the FMU of a scene's exact motion; the same scene and compiler give the same bytes.

    Returns:
        The archive, and the reason why it has no binary, or None.

    Raises:
        InvalidInput: names the machine whose motion cannot be tabulated, with the reason.
    """
    table = motion_table(scene)
    start, stop = sorted(angle / scene.speed for angle in scene.kinematics.span)
    header = _table_header(table, scene.speed)
    about = {
        "name": name,
        "identifier": re.sub("[^A-Za-z0-9_]", "_", name if re.match("[A-Za-z_]", name) else f"_{name}"),
        "token": f"{{{hashlib.sha256(header.encode()).hexdigest()[:32]}}}",
        "description": f"Exact motion of: {scene.title}. SI units; x, y and turns as in: {scene.frame}",
        "tool": f"conrod {version('conrod')}",
        "columns": [column.rsplit(".", 1) for column in table.names],
        "plain": all(re.fullmatch("[A-Za-z_][A-Za-z0-9_]*[.][a-z]+", column) for column in table.names),
        "start": start if table.turns == 0 else 0.0,
        "stop": stop if table.turns == 0 else scene.period,
        "speed": scene.speed,
    }
    sources = {
        "motion.c": PACKAGE_FILES.joinpath("motion.c").read_text(encoding="utf-8"),
        "motion_table.h": f'{header}#define INSTANTIATION_TOKEN "{about["token"]}"\n',
    }
    binary, why_none = _build_binary(str(about["identifier"]), sources)
    contents = {
        "modelDescription.xml": _render_xml("modelDescription.xml", about),
        "sources/buildDescription.xml": _render_xml("buildDescription.xml", about),
        **{f"sources/{file}": content for file, content in sources.items()},
    }
    return zip_archive({**contents, **binary}), why_none


def _render_xml(file: str, about: Mapping[str, object]) -> str:
    """Render an XML template, with its variables escaped."""
    text = PACKAGE_FILES.joinpath(f"{file}.jinja").read_text(encoding="utf-8")
    return visible_text(
        jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined).from_string(text).render(about)
    )


def _table_header(table: MotionTable, speed: float) -> str:
    """Return the table of motion as a C header, each number in its shortest exact digits."""
    intervals, columns, terms = table.coefficients.shape
    return f"""/* Written by conrod: the exact motion of one machine, see motion.c. */
#define INTERVALS {intervals}
#define COLUMNS {columns}
#define ORDER {terms - 1}
#define TURNS {table.turns}
#define DEFAULT_SPEED {speed!r}
static const double knots[INTERVALS + 1] = {_initializer(table.knots)}; /* [rad] */
static const double gains[COLUMNS] = {_initializer(table.gains)}; /* over TURNS turns */
static const double coefficients[INTERVALS][COLUMNS][ORDER + 1] = {_initializer(table.coefficients)};
"""


def _initializer(values: Array) -> str:
    """Return an array as a C initialiser, without zeros at the ends of rows, which C adds."""
    if values.ndim > 1:
        return "{" + ",\n".join(map(_initializer, values)) + "}"
    return "{" + ", ".join(map(repr, (np.trim_zeros(values, "b") + 0.0).tolist() or [0.0])) + "}"


def _build_binary(identifier: str, sources: Mapping[str, str]) -> tuple[dict[str, bytes], str | None]:
    """Compile the binary for this platform.

    Returns:
        The binary by its name in the archive, and None; or nothing, and the reason."""
    compiler, machine = shutil.which(COMPILER), platform.machine().lower()
    if sys.platform not in SUFFIXES:
        return {}, f"binaries are not built on {sys.platform}"
    if compiler is None:
        return {}, f"there is no C compiler ({COMPILER}) here"
    with tempfile.TemporaryDirectory() as folder:
        for name, content in sources.items():
            (Path(folder) / name).write_text(content, encoding="utf-8", newline="\n")
        # Names without a folder: the binary then says nothing of where it was built.
        library = identifier + SUFFIXES[sys.platform]
        command = [compiler, *FLAGS, "-o", library, "motion.c"]
        try:
            subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=120.0)
            place = f"binaries/{ARCHITECTURES.get(machine, machine)}-{sys.platform}/{library}"
            return {place: (Path(folder) / library).read_bytes()}, None
        except (OSError, subprocess.SubprocessError) as error:
            return {}, f"the C compiler ({compiler}) fails: {error}"
