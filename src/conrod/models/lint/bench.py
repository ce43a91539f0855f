"""A user's model on the bench: its file, its run, edited copies of it and their runs.

What stands last in a file counts, so that an edit is a section at its end: nothing else of the text changes, and the
file itself is only read. All runs are from one start, for the same time, and observe all bodies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.document import Document
from conrod.mjcf.runs import Run, data_at_state, run

# Changes of the observed positions below this share of their travel are none: what rounding makes of a run.
UNCHANGED_SHARE = 1e-9
BOUNDLESS = 1e300  # stands for infinity, which JSON has not


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
