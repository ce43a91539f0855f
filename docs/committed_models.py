"""The committed models of all machines, for MuJoCo and for pymunk: `python -m docs.committed_models mjcf` writes.

A file that differs from what is written today by the rounding of another processor alone stays as it is.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from conrod import InvalidInput, export
from conrod.scenes import SCENES, catalogue_names, dynamics_names
from conrod.scenes.space import MACHINES

ROOT = Path(__file__).parents[1]
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
ROUNDING = 1e-12  # relative, or of 1


@dataclass(frozen=True)
class Model:
    """A committed model: its file, the machine's name, and whether it is without a drive, as those of dynamics are."""

    file: Path
    name: str
    format: str
    free: bool

    @property
    def text(self) -> str | None:
        """What is exported today; None if the engine cannot have the machine."""
        try:
            return str(export(self.name, self.format, free=self.free))
        except InvalidInput as refused:
            if "pymunk has no joint" not in str(refused):
                raise
            return None


def models(format: str) -> list[Model]:
    """Models of all machines in a format, `mjcf` or `pymunk`; machines in space are of MuJoCo alone."""
    folders: Mapping[str, tuple[object, bool]] = {
        "": (SCENES, False),
        "catalogue": (catalogue_names(), False),
        "dynamics": (dynamics_names(), True),
        **({"space": (MACHINES, False)} if format == "mjcf" else {}),
    }
    root = ROOT / ("mjcf" if format == "mjcf" else "pymunk_models")
    return [
        Model(
            root / folder / (f"{name}.xml" if format == "mjcf" else f"{name.replace('-', '_')}.py"), name, format, free
        )
        for folder, (names, free) in folders.items()
        for name in names  # type: ignore[attr-defined]
    ]


def equal_to_rounding(one: str, other: str) -> bool:
    """True if two texts are equal but for the last digits of numbers, and for line breaks, which depend on these."""
    one, other = (re.sub(r"\s*([()\[\]{},])\s*", r"\1", " ".join(text.split())) for text in (one, other))
    one, other = (re.sub(r",(?=[)\]}])", "", text) for text in (one, other))
    if NUMBER.split(one) != NUMBER.split(other):
        return False
    pairs = zip(map(float, NUMBER.findall(one)), map(float, NUMBER.findall(other)), strict=True)
    return all(abs(a - b) <= ROUNDING * max(1.0, abs(a)) for a, b in pairs)


def write_models(format: str) -> Iterator[Path]:
    """Write the models of a format, and yield the files that changed."""
    for model in models(format):
        text = model.text
        known = model.file.read_text(encoding="utf-8") if model.file.exists() else ""
        if text is None or equal_to_rounding(text, known):
            continue
        model.file.parent.mkdir(parents=True, exist_ok=True)
        model.file.write_text(text, encoding="utf-8")
        yield model.file


if __name__ == "__main__":
    for changed in write_models(sys.argv[1]):
        print(changed.relative_to(ROOT))
