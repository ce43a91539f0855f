"""The slider-crank of `slider_crank_fmu.c` as an FMU, with a planted fault."""

from __future__ import annotations

import platform
import shutil
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path

OUTPUT, LOCAL = 'causality="output" initial="calculated"', 'causality="local"'
VARIABLES = {
    "slider.r[1]": (0, OUTPUT, '<Real unit="mm"/>'),
    "slider.r[2]": (1, OUTPUT, '<Real unit="m"/>'),
    "slider.v": (2, LOCAL, '<Real unit="m/s"/>'),
    "crank.phi": (3, LOCAL, '<Real declaredType="Angle"/>'),
    "slider.s": (4, LOCAL, "<Real/>"),
    "der(slider.s)": (2, LOCAL, '<Real derivative="5"/>'),
}
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="saw" guid="{fault}" generationTool="hand">
  {interfaces}
  <UnitDefinitions><Unit name="mm"/><Unit name="m"/><Unit name="m/s"/><Unit name="deg"/></UnitDefinitions>
  <TypeDefinitions><SimpleType name="Angle"><Real unit="deg"/></SimpleType></TypeDefinitions>
  <ModelVariables>{variables}</ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="1"/><Unknown index="2"/></Outputs>
    <Derivatives><Unknown index="6"/></Derivatives>
    <InitialUnknowns><Unknown index="1"/><Unknown index="2"/><Unknown index="6"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
BOTH = ("ModelExchange", "CoSimulation")  # as the standard orders them
SOURCE = Path(__file__).with_suffix(".c")
BINARY = "binaries/linux64/saw.so"


def compiled(folder: Path) -> Path | None:
    """The machine as a shared library; None without a compiler, or where `BINARY` is of another platform."""
    compiler = shutil.which("cc")
    if compiler is None or (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        return None
    library = folder / "saw.so"
    subprocess.run([compiler, "-O1", "-w", "-fPIC", "-shared", "-o", library, SOURCE, "-lm"], check=True)
    return library


def description(fault: str = "none") -> str:
    """The model description; what it calls its token is the fault."""
    interfaces = "".join(f'<{mode} modelIdentifier="saw"/>' for mode in BOTH)
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{reference}" {attributes}>{kind}</ScalarVariable>'
        for name, (reference, attributes, kind) in VARIABLES.items()
    )
    return DESCRIPTION.format(fault=fault, interfaces=interfaces, variables=variables)


def write_fmu(path: Path, library: Path | None, files: Mapping[str, str], binary: str = BINARY) -> Path:
    """An FMU of some files, and the library where there is one."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        if library is not None:
            archive.write(library, binary)
        for name, text in files.items():
            archive.writestr(name, text)
    return path
