"""A model on the bench: its own run, and runs and timings of edited copies of it."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from conrod.mjcf.lint.document import Document
from conrod.mjcf.lint.edits import Edit, Remove, SetOption, set_option
from conrod.mjcf.lint.runs import Observed, Poses, Run, Start, largest_change, run
from conrod.mjcf.stepping import looping_stepper
from conrod.own.models.loading import name_or_number
from conrod.studies.frame.paired_timing import Clock, PairedCost, paired_cost

# Changes of the observed positions below this share of their travel are none: what rounding makes of a run.
UNCHANGED = 1e-9


@dataclass(frozen=True)
class Trial:
    """Edits that were tried.

    Attributes:
        edits: none where the file has no place for them.
        change: largest change of the observed positions that they make, over the travel; None where there are none.
        cost: of a step without them over one with them.
    """

    edits: tuple[Edit, ...] = ()
    change: float | None = None
    cost: PairedCost | None = None

    @property
    def told_change(self) -> float | str:
        """The change as evidence."""
        return "not run" if self.change is None else self.change

    def changes_at_most(self, share: float) -> bool:
        """True where they were tried and change the motion by no more."""
        return self.change is not None and self.change <= share


class Bench:
    """Everything that rules ask of a model.

    Attributes:
        document: the file.
        drive: edits that every copy has: those that make the crank keep its speed, or that make the model run at all.
        model: compiled with the drive.
        start: state that all runs start from.
        keyframe: index of the keyframe that the start is taken from; None where it is the model's own pose.
        steps: of the model's own run.
    """

    def __init__(
        self,
        document: Document,
        start: Start,
        steps: int,
        observed: Observed,
        *,
        keyframe: int | None,
        drive: tuple[Edit, ...],
        clock: Clock,
    ) -> None:
        self.document, self.start, self.steps, self.observed = document, start, steps, observed
        self.keyframe, self.drive, self._clock = keyframe, drive, clock
        self._other_steps: dict[float, Bench] = {}
        self._runs: dict[tuple[Edit, ...], Run] = {}
        self._poses: dict[tuple[Edit, ...], Poses] = {}
        self._models: dict[tuple[Edit, ...], mujoco.MjModel] = {}
        self._compiled: dict[tuple[Edit, ...], mujoco.MjModel] = {}  # without edits of options

    @property
    def model(self) -> mujoco.MjModel:
        """The model itself."""
        return self.copy(())

    @property
    def run(self) -> Run:
        """The model's own run."""
        return self.run_of(())

    @property
    def poses(self) -> Poses:
        """Constraints along the model's own run."""
        return self.poses_of(())

    def copy(self, edits: Sequence[Edit]) -> mujoco.MjModel:
        """The model with edits.

        Raises:
            ValueError: it does not compile.
        """
        key = tuple(edits)
        if key not in self._models:
            options = [edit for edit in (*self.drive, *key) if isinstance(edit, SetOption) and edit.of_compiled]
            hard = tuple(edit for edit in (*self.drive, *key) if edit not in options)
            if hard not in self._compiled:
                self._compiled[hard] = self.document.compiled(hard) if hard else self.document.model
            model = copy.copy(self._compiled[hard])
            for edit in options:
                set_option(model, edit)
            self._models[key] = model
        return self._models[key]

    def run_of(self, edits: Sequence[Edit]) -> Run:
        """Run of the model with edits."""
        key = tuple(edits)
        if key not in self._runs:
            self._runs[key] = run(self.copy(key), self.start, self.steps, self.observed)
        return self._runs[key]

    def poses_of(self, edits: Sequence[Edit]) -> Poses:
        """Constraints along the run with edits."""
        key = tuple(edits)
        if key not in self._poses:
            self._poses[key] = Poses(self.copy(key), self.start, self.run_of(key))
        return self._poses[key]

    def with_step(self, step: float) -> Bench:
        """Bench of the same model with another step [s], for the same time."""
        if step in self._other_steps:
            return self._other_steps[step]
        steps = max(1, round(self.steps * float(self.model.opt.timestep) / step))
        other = self.with_edits((SetOption(("option",), "timestep", repr(step)),))
        other.steps, other._other_steps = steps, self._other_steps
        self._other_steps[step] = other
        return other

    def with_edits(self, edits: Sequence[Edit]) -> Bench:
        """The model with edits, on a bench of its own."""
        other = Bench(
            self.document,
            self.start,
            self.steps,
            self.observed,
            keyframe=self.keyframe,
            drive=(*self.drive, *edits),
            clock=self._clock,
        )
        other._compiled = self._compiled
        return other

    # -- measures ----------------------------------------------------------------------------------------------------

    @cached_property
    def size(self) -> float:
        """Size of the machine [m]: the diagonal of the box about its moving bodies and their joints, at the start."""
        data = self.start.data(self.model)
        mujoco.mj_kinematics(self.model, data)
        moving = self.model.body_weldid > 0
        places = np.concatenate([data.xpos[moving], data.xipos[moving], data.xanchor])
        size = float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
        return size if size > 0.0 else float(self.model.stat.extent)

    @cached_property
    def scale(self) -> float:
        """Length [m] that changes of positions are relative to: the observed travel; of what stands, the size."""
        travel = self.run.travel
        return travel if travel > UNCHANGED * self.size else self.size

    def change(self, edits: Sequence[Edit]) -> float:
        """The largest change of the observed positions that edits make, over the travel."""
        return relative(largest_change(self.run, self.run_of(edits)) / self.scale)

    def trial(self, edits: Sequence[Edit]) -> Trial:
        """Change and cost of edits, where the file has a place for all of them."""
        if not self.document.can_make(edits):
            return Trial()
        return Trial(tuple(edits), self.change(edits), self.cost(edits))

    def cost(self, edits: Sequence[Edit]) -> PairedCost:
        """Cost of a step of the model over one with edits."""
        own, edited = (looping_stepper(model, self.start.put, self.steps) for model in (self.model, self.copy(edits)))
        return paired_cost(own, edited, clock=self._clock)

    def cost_of(self, kind: str, indices: Sequence[int]) -> PairedCost | None:
        """Cost of elements together; None where they cannot be left out without making another machine."""
        edits = tuple(Remove(kind, index, name_or_number(self.model, kind, index)) for index in indices)
        if self.run.broke or not self.document.can_make(edits):
            return None
        try:
            without = self.copy(edits)
        except ValueError:
            return None
        if not np.array_equal(without.body_inertia, self.model.body_inertia) or self.change(edits) > 0.0:
            return None
        return self.cost(edits)


def relative(change: float) -> float:
    """A number that goes into JSON: infinity is none."""
    return change if math.isfinite(change) else 1e300
