"""Golden records in files: a group in each, by task and name.

Numerical libraries choose their kernels by the vector instructions of the processor, and sums of another order have
another last digit. Where a result amplifies rounding (the energy that a free motion gains, exact motion near a change
point) no rule of 1e-13 holds between two kinds of processor: each kind has records of its own, made with the same code.

Of the group `motion` records of MuJoCo's presets tuned and hardened, and of presses, are missing since their rules
changed: `python -m golden write motion` on an otherwise idle machine of each kind makes them.
"""

from __future__ import annotations

import json
import lzma
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from golden.record import Record

Group = dict[str, dict[str, Any]]
LIBRARIES = ("mujoco", "pymunk", "numpy", "scipy")


def read(data: Path, group: str) -> tuple[dict[str, str], Group]:
    """What the records of a group were made with, and the records: task -> name -> value; nothing where none are."""
    own = _file(data, group)
    file = own if own.exists() else next(iter(sorted(data.glob(f"*/{own.name}"))), None)
    if file is None:
        return {}, {}
    document = json.loads(lzma.decompress(file.read_bytes()))
    return document["environment"], document["tasks"]


def write(data: Path, group: str, tasks: Mapping[str, Mapping[str, Record]]) -> None:
    """Put the records of a group in the place of those that were."""
    values = {task: {name: record.value for name, record in records.items()} for task, records in tasks.items()}
    text = json.dumps({"environment": environment(), "tasks": values}, indent=0, allow_nan=False)
    _file(data, group).parent.mkdir(exist_ok=True)
    _file(data, group).write_bytes(lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))


def environment() -> dict[str, str]:
    """What decides the last bit of a result."""
    processor = next((line for line in _cpu_lines() if line.startswith("model name")), platform.processor())
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "instructions": instructions(),
        "processor": processor.partition(":")[2].strip() or processor,
        **{name: version(name) for name in LIBRARIES},
    }


def instructions() -> str:
    """The widest vector instructions of the processor, by which numerical libraries choose their kernels."""
    flags = next((line.split() for line in _cpu_lines() if line.startswith("flags")), [])
    known = {"avx512": "avx512f", "avx2": "avx2"}
    return next((name for name, flag in known.items() if flag in flags), platform.machine())


def _cpu_lines() -> list[str]:
    file = Path("/proc/cpuinfo")
    return file.read_text(encoding="utf-8").splitlines() if file.exists() else []


def _file(data: Path, group: str) -> Path:
    return data / instructions() / f"{group}.json.xz"
