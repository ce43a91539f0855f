"""A user's model on the bench: its file, its run, edited copies of it and their runs.

What stands last in a file counts, so that an edit is a section at its end: nothing else of the text changes, and the
file itself is only read. All runs are from one start, for the same time, and observe all bodies.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.loading import load_model
from conrod.mjcf.runs import Run, data_at_state, run

# Changes of the observed positions below this share of their travel are none: what rounding makes of a run.
UNCHANGED_SHARE = 1e-9
# The end tag, with nothing but comments behind it.
END = re.compile(rb"</mujoco\s*>(\s|<!--(?:(?!-->).)*-->)*\Z", re.DOTALL)
BOUNDLESS = 1e300  # stands for infinity, which JSON has not


class Document:
    """A model file that can be edited.

    Attributes:
        folder: folder that relative paths of includes and assets start from.
        model: compiled.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() == ".mjb":
            raise InvalidInput(f"{path}: a binary model cannot be taken apart; give the MJCF that it was made from")
        self.model = load_model(path)
        self.folder = path.resolve().parent
        self._content = path.read_bytes()
        if not (end := END.search(self._content)):
            raise InvalidInput(f"{path}: it is no MJCF: it does not end with </mujoco>; mj_saveLastXML writes MJCF")
        self._end = end.start()
        if other := self.recompile_difference(self.folder):
            raise InvalidInput(f"{path}: compiled from its text it is another model ({other})")

    def text_with(self, edits: Sequence[str]) -> bytes:
        """The file's text with edits appended before its end."""
        lines = "".join(f"  {edit}\n" for edit in edits)
        return self._content[: self._end] + lines.encode() + self._content[self._end :]

    def recompile_difference(self, folder: Path, edits: Sequence[str] = ()) -> str:
        """Name the difference of the model with edits when compiled from a folder; empty if none."""
        try:
            return first_difference(self.compile_with(edits) if edits else self.model, self.compile_with(edits, folder))
        except ValueError as error:
            return " ".join(str(error).split())

    def compile_with(self, edits: Sequence[str], folder: Path | None = None) -> mujoco.MjModel:
        """Compile the model with edits, with includes and assets relative to a folder.

        Raises:
            ValueError: the edited model does not compile.
        """
        with contextlib.chdir(folder or self.folder), silence_warnings():
            return mujoco.MjModel.from_xml_string(self.text_with(edits))


def first_difference(one: mujoco.MjModel, other: mujoco.MjModel) -> str:
    """Name of the first array that differs between two compiled models, names apart; empty if none."""
    for name in dir(one):
        value = getattr(one, name)
        if not name.startswith(("_", "name")) and isinstance(value, np.ndarray) and "path" not in name:
            same = value.shape == getattr(other, name).shape
            if not same or not np.array_equal(value, getattr(other, name), equal_nan=value.dtype.kind == "f"):
                return name
    return "" if str(one.opt) == str(other.opt) else "option"


# -- runs -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LintBench:
    """A model with its start and its run, which rules examine."""

    document: Document  # the file
    model: mujoco.MjModel  # compiled from it with the edits
    edits: tuple[str, ...]  # sections of MJCF that were appended to the file
    start: Array  # state that all runs start from
    steps: int  # number of steps of the run
    keyframe: int | None  # index of the keyframe that the start is taken from; None where it is the model's own pose

    def with_edits(self, edits: Sequence[str], steps: int | None = None) -> LintBench:
        """The model with further edits, run for the same time; raises ValueError if they do not compile."""
        every = (*self.edits, *edits)
        return replace(self, model=self.document.compile_with(every), edits=every, steps=steps or self.steps)

    @cached_property
    def finer(self) -> LintBench:
        """The model with half its step."""
        return self.with_edits((f'<option timestep="{0.5 * self.step!r}"/>',), 2 * self.steps)

    @property
    def step(self) -> float:
        """Step of the model [s]."""
        return float(self.model.opt.timestep)

    @cached_property
    def run(self) -> Run:
        """The model's run."""
        return run(self.model, self.start, self.steps)

    @cached_property
    def constraint_violations(self) -> Array:
        """Violation of each equality (T, neq) [m] at the samples of the run."""
        return self.run.constraint_violations(self.size)

    # -- measures ----------------------------------------------------------------------------------------------------

    @cached_property
    def size(self) -> float:
        """Size of the machine [m]: the diagonal of the box about its moving bodies and their joints, at the start."""
        data = data_at_state(self.model, self.start)
        mujoco.mj_kinematics(self.model, data)
        moving = self.model.body_weldid > 0
        places = np.concatenate([data.xpos[moving], data.xipos[moving], data.xanchor])
        size = float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
        return size if size > 0.0 else float(self.model.stat.extent)

    def change(self, edits: Sequence[str]) -> float:
        """Largest change of the observed positions that edits make, over the travel."""
        return self.change_to(self.with_edits(edits).run)

    def change_to(self, other: Run) -> float:
        """Largest difference of observed positions to another run, over the travel; BOUNDLESS if one broke."""
        one = self.run.points
        if len(one) != len(other.points):
            return BOUNDLESS
        largest = float(np.linalg.norm(one - other.points, axis=2).max()) if one.size else 0.0
        # What stands has no travel.
        share = largest / (self.run.travel if self.run.travel > UNCHANGED_SHARE * self.size else self.size)
        return share if math.isfinite(share) else BOUNDLESS
