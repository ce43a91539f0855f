"""The text of a model file, edited and compiled again.

What stands last in a file counts, so that an edit is a section at its end: nothing else of the text changes, and the
file itself is only read.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput
from conrod.mjcf.loading import load_model
from conrod.mjcf.unit_of_length import convert_to_metres

# The end tag, with nothing but comments behind it.
END = re.compile(rb"</mujoco\s*>(\s|<!--(?:(?!-->).)*-->)*\Z", re.DOTALL)


class Document:
    """A model file that can be edited.

    Attributes:
        folder: folder that relative paths of includes and assets start from.
        unit: unit of the file's lengths [m].
        model: compiled, in metres.
    """

    def __init__(self, path: Path, unit: float = 1.0) -> None:
        if path.suffix.lower() == ".mjb":
            raise InvalidInput(f"{path}: a binary model cannot be taken apart; give the MJCF that it was made from")
        self.model, self.unit = load_model(path), unit
        convert_to_metres(self.model, unit)
        self.folder = path.resolve().parent
        self._content = path.read_bytes()
        if not (end := END.search(self._content)):
            raise InvalidInput(f"{path}: it is no MJCF: it does not end with </mujoco>; mj_saveLastXML writes MJCF")
        self._end = end.start()
        if other := self.recompile_difference(self.folder):
            raise InvalidInput(f"{path}: compiled from its text it is another model ({other})")

    def text_with(self, edits: Sequence[str]) -> bytes:
        """The file's text with edits appended before its end, in lines that end as the file's do."""
        line_end = "\r\n" if b"\r\n" in self._content else "\n"
        lines = "".join(f"  {edit}{line_end}" for edit in edits)
        return self._content[: self._end] + lines.encode() + self._content[self._end :]

    def recompile_difference(self, folder: Path, edits: Sequence[str] = ()) -> str:
        """Name the difference of the model with edits when compiled from a folder; empty if none."""
        try:
            return first_difference(self.compile_with(edits) if edits else self.model, self.compile_with(edits, folder))
        except ValueError as error:
            return " ".join(str(error).split())

    def compile_with(self, edits: Sequence[str], folder: Path | None = None) -> mujoco.MjModel:
        """Compile the model with edits, in metres, with includes and assets relative to a folder.

        Args:
            edits: sections of MJCF, in the file's unit of length.

        Raises:
            ValueError: the edited model does not compile.
        """
        with contextlib.chdir(folder or self.folder), silence_warnings():
            model = mujoco.MjModel.from_xml_string(self.text_with(edits))
        convert_to_metres(model, self.unit)
        return model


def first_difference(one: mujoco.MjModel, other: mujoco.MjModel) -> str:
    """Name of the first array that differs between two compiled models, names apart; empty if none."""
    for name in dir(one):
        value = getattr(one, name)
        if not name.startswith(("_", "name")) and isinstance(value, np.ndarray) and "path" not in name:
            same = value.shape == getattr(other, name).shape
            if not same or not np.array_equal(value, getattr(other, name), equal_nan=value.dtype.kind == "f"):
                return name
    return "" if str(one.opt) == str(other.opt) else "option"
