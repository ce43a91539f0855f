"""A user's MJCF, of which copies with further sections are compiled; the file itself is only read.

What stands last in a file counts, so that an edit is a section at its end: nothing else of the text changes.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.parsers import expat

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import warnings_kept_quiet
from conrod.errors import InvalidInput
from conrod.own.models.loading import load_model


class Document:
    """A model file that can be edited.

    Attributes:
        folder: that its includes and assets are looked for from.
        model: compiled.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() == ".mjb":
            raise InvalidInput(f"{path}: a binary model cannot be taken apart; give the MJCF that it was made from")
        self.model = load_model(path)
        self.folder = path.resolve().parent
        self._content = path.read_bytes()
        try:
            root, self._end = _root_of(self._content)
        except expat.ExpatError as error:
            raise InvalidInput(f"{path}: it is not well-formed XML: {error}") from None
        if root != "mujoco":
            raise InvalidInput(f"{path}: <{root}> is no MJCF; mj_saveLastXML writes MJCF of what MuJoCo loads")
        if other := self.otherwise(self.folder):
            raise InvalidInput(f"{path}: compiled from its text it is another model ({other})")

    def text(self, edits: Sequence[str]) -> bytes:
        """The file with edits at its end."""
        lines = "".join(f"  {edit}\n" for edit in edits)
        return self._content[: self._end] + lines.encode() + self._content[self._end :]

    def otherwise(self, folder: Path, edits: Sequence[str] = ()) -> str:
        """Differences of the model with edits when it is compiled from a folder; empty if there are none."""
        try:
            return differing(self.compiled(edits) if edits else self.model, self.compiled(edits, folder))
        except ValueError as error:
            return " ".join(str(error).split())

    def compiled(self, edits: Sequence[str], folder: Path | None = None) -> mujoco.MjModel:
        """The model with edits, its includes and assets looked for from a folder.

        Raises:
            ValueError: it does not compile.
        """
        with contextlib.chdir(folder or self.folder), warnings_kept_quiet():
            return mujoco.MjModel.from_xml_string(self.text(edits))


def _root_of(content: bytes) -> tuple[str, int]:
    """Tag of the root, and the byte at which its end tag begins."""
    parser, tags, ends = expat.ParserCreate(), list[str](), list[int]()

    def begin(tag: str, _: Mapping[str, str]) -> None:
        tags.append(tag)

    def end(_: str) -> None:
        ends.append(parser.CurrentByteIndex)

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.Parse(content, True)
    return tags[0], ends[-1]


def differing(one: mujoco.MjModel, other: mujoco.MjModel) -> str:
    """Name of the first array that two compiled models do not share, bit for bit, names apart; empty if none."""
    for name in dir(one):
        value = getattr(one, name)
        if not name.startswith(("_", "name")) and isinstance(value, np.ndarray) and "path" not in name:
            same = value.shape == getattr(other, name).shape
            if not same or not np.array_equal(value, getattr(other, name), equal_nan=value.dtype.kind == "f"):
                return name
    return "" if str(one.opt) == str(other.opt) else "option"
