"""Golden records in files: a group in each, by task and name.

Numerical libraries choose their kernels by the processor, and sums of another order have another last digit. Where a
result amplifies rounding (the energy that a free motion gains, exact motion near a change point) no rule of 1e-13 holds
between two kinds of processor. So all commands run with the same kernels, whatever the processor: `KERNELS`.
"""

from __future__ import annotations

import json
import lzma
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tests.golden.record import Record

Group = dict[str, dict[str, Any]]
# Environment of the commands: OpenBLAS takes the kernels for AVX2, in one thread, numpy none for more than AVX2.
KERNELS: Mapping[str, str] = (
    {
        "OPENBLAS_CORETYPE": "Haswell",
        "OPENBLAS_NUM_THREADS": "1",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4,AVX512_ICL,AVX512_SPR",
    }
    if platform.machine().lower() in ("x86_64", "amd64")
    else {}
)
LIBRARIES = ("mujoco", "pymunk", "numpy", "scipy")


def read(data: Path, group: str) -> tuple[dict[str, str], Group]:
    """What the records of a group were made with, and the records: task -> name -> value; nothing where none are."""
    file = _file(data, group)
    if not file.exists():
        return {}, {}
    document = json.loads(lzma.decompress(file.read_bytes()))
    return document["environment"], document["tasks"]


def write(data: Path, group: str, tasks: Mapping[str, Mapping[str, Record]]) -> None:
    """Put the records of a group in the place of those that were."""
    values = {task: {name: record.value for name, record in records.items()} for task, records in tasks.items()}
    text = json.dumps({"environment": environment(), "tasks": values}, indent=0, allow_nan=False)
    _file(data, group).write_bytes(lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))


def environment() -> dict[str, str]:
    """What decides the last bit of a result."""
    processor = next((line for line in _cpu_lines() if line.startswith("model name")), platform.processor())
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "kernels": " ".join(KERNELS.values()),
        "processor": processor.partition(":")[2].strip() or processor,
        **{name: version(name) for name in LIBRARIES},
    }


def _cpu_lines() -> list[str]:
    file = Path("/proc/cpuinfo")
    return file.read_text(encoding="utf-8").splitlines() if file.exists() else []


def _file(data: Path, group: str) -> Path:
    return data / f"{group}.json.xz"
