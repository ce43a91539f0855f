"""A model file as lint can take it apart: without what is not there, in metres, and MJCF in place of URDF."""

from __future__ import annotations

import contextlib
from pathlib import Path

import mujoco

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput
from conrod.mjcf.document import END, Document
from conrod.mjcf.missing_files import spec_without_missing


class PreparedDocument(Document):
    """A model's text prepared for lint, with lengths in a unit [m]; compiles to a model in metres."""

    def __init__(self, text: bytes, folder: Path, unit: float) -> None:
        self.folder, self.unit, self._content = folder, unit, text
        if not (end := END.search(text)):
            raise InvalidInput("it does not end with </mujoco>; mj_saveLastXML writes MJCF")
        self._end = end.start()
        self.model = self.compile_with(())


def prepared_document(path: Path, unit: float, *, whole: bool) -> PreparedDocument:
    """Prepare a model file for lint.

    Args:
        unit: unit of its lengths [m].
        whole: whether all that it names is there.

    Raises:
        InvalidInput: it is a binary file, or MuJoCo does not read what it wrote itself.
    """
    if path.suffix.lower() == ".mjb":
        raise InvalidInput("a binary model cannot be taken apart; give the MJCF that it was made from")
    folder = path.resolve().parent
    with silence_warnings(), contextlib.chdir(folder):
        found = None if whole else spec_without_missing(Path(path.name))
        spec = found[0] if found else mujoco.MjSpec.from_file(path.name)
        try:
            spec.compile()
            text = spec.to_xml().encode()
        except ValueError as error:
            raise InvalidInput(" ".join(str(error).split())) from None
    try:
        return PreparedDocument(text, folder, unit)
    except ValueError as error:
        raise InvalidInput(" ".join(str(error).split())) from None
