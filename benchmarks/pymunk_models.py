"""The committed pymunk models of all machines that pymunk can have: `python -m benchmarks.pymunk_models` writes them.

A file that differs from what is written today by the rounding of another processor alone stays as it is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from conrod import InvalidInput, export
from conrod.scenes import SCENES, catalogue_names, dynamics_names

MODELS = Path(__file__).parents[1] / "pymunk_models"
NUMBER = re.compile(r"-?\d+\.\d+(?:e[-+]\d+)?")
ROUNDING = 1e-12  # relative, or of 1


def machines() -> dict[Path, tuple[str, bool]]:
    """Name of each machine by the file of its model, and whether it moves without a drive, as those of dynamics do."""
    folders = {"": (SCENES, False), "catalogue": (catalogue_names(), False), "dynamics": (dynamics_names(), True)}
    return {
        MODELS / folder / f"{name.replace('-', '_')}.py": (name, free)
        for folder, (names, free) in folders.items()
        for name in names
    }


def model_text(name: str, free: bool) -> str | None:
    """Model of a machine; None if pymunk cannot have it."""
    try:
        return str(export(name, "pymunk", free=free))
    except InvalidInput as refused:
        if "pymunk has no joint" not in str(refused):
            raise
        return None


def equal_to_rounding(one: str, other: str) -> bool:
    """True if two texts are equal but for the last digits of numbers."""
    if NUMBER.split(one) != NUMBER.split(other):
        return False
    pairs = zip(map(float, NUMBER.findall(one)), map(float, NUMBER.findall(other)), strict=True)
    return all(abs(a - b) <= ROUNDING * max(1.0, abs(a)) for a, b in pairs)


def write_models() -> Iterator[Path]:
    """Write the models, and yield the files that changed."""
    for file, machine in machines().items():
        text = model_text(*machine)
        if text is None or (file.exists() and equal_to_rounding(text, file.read_text(encoding="utf-8"))):
            continue
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        yield file


if __name__ == "__main__":
    for changed in write_models():
        print(changed.relative_to(MODELS.parent))
