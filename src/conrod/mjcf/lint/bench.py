"""A model on the bench, with its run, edited copies of it and their runs; and what a rule is.

All runs are from one start, for the same time, and observe the same points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.equalities import Rows, openings, rows_at
from conrod.mjcf.lint.document import Document
from conrod.mjcf.lint.findings import Edit, Finding, SetOption
from conrod.mjcf.runs import STATE, Run, data_at, run
from conrod.own.models.loading import FoundPoint

# Changes of the observed positions below this share of their travel are none: what rounding makes of a run.
UNCHANGED = 1e-9
LOOKS = 40
# Of a model of many coordinates fewer, or their ranks would take longer than its run.
FEWEST, COORDINATES = 3, 100
BOUNDLESS = 1e300  # stands for infinity, which JSON has not


@dataclass(frozen=True, eq=False)
class Bench:
    """Everything that rules ask of a model.

    Attributes:
        copies: of the model with further edits, each on a bench of its own.
    """

    document: Document  # the file
    start: Array  # state that all runs start from
    steps: int  # of the run
    observed: tuple[FoundPoint, ...]  # points that are observed; every body where there is none
    keyframe: int | None  # index of the keyframe that the start is taken from; None where it is the model's own pose
    edits: tuple[Edit, ...]  # of the file, among them those that make the crank keep its speed
    copies: dict[tuple[tuple[Edit, ...], int], Bench] = field(default_factory=dict)

    def edited(self, edits: Sequence[Edit], steps: int | None = None) -> Bench:
        """The model with further edits, for the same time."""
        key = (*self.edits, *edits), steps or self.steps
        if key not in self.copies:
            self.copies[key] = replace(self, edits=key[0], steps=key[1])
        return self.copies[key]

    def with_step(self, step: float) -> Bench:
        """The model with another step [s]."""
        option = SetOption(("option",), "timestep", repr(step))
        return self.edited((option,), max(1, round(self.steps * self.step / step)))

    @cached_property
    def model(self) -> mujoco.MjModel:
        """The model, compiled.

        Raises:
            ValueError: the edits do not compile.
        """
        return self.document.compiled(self.edits) if self.edits else self.document.model

    @property
    def step(self) -> float:
        """Step of the model [s]."""
        return float(self.model.opt.timestep)

    # -- the run -----------------------------------------------------------------------------------------------------

    @cached_property
    def run(self) -> Run:
        """The model's run."""
        return run(self.model, self.start, self.steps, self.observed)

    def poses(self, every: int = 0) -> Iterator[mujoco.MjData]:
        """Data of poses along the run, with all that `mj_forward` makes; one object, used again and again.

        Args:
            every: take every so manieth sample, 0 for some `LOOKS` poses.
        """
        data = data_at(self.model, self.start)
        looks = min(LOOKS, max(FEWEST, LOOKS * COORDINATES**2 // self.model.nv**2))
        for state in self.run.states[:: every or max(1, len(self.run.states) // looks)]:
            mujoco.mj_setState(self.model, data, state, STATE)
            mujoco.mj_forward(self.model, data)
            yield data

    @cached_property
    def rows(self) -> list[Rows]:
        """Equality constraints at each look."""
        return [rows_at(self.model, data) for data in self.poses()]

    @cached_property
    def openings(self) -> Array:
        """Opening (samples, neq) [m] of each connect or weld; 0 for other equalities and those that are off."""
        found = [openings(self.model, data) for data in self.poses(1)]
        return np.reshape(found, (len(found), self.model.neq))

    @property
    def freedom(self) -> int:
        """Degrees of freedom that the closures leave, at the pose where they leave the fewest."""
        coordinates = int(self.model.nv)
        return min((coordinates - rows.rank for rows in self.rows), default=coordinates)

    # -- measures ----------------------------------------------------------------------------------------------------

    @cached_property
    def size(self) -> float:
        """Size of the machine [m]: the diagonal of the box about its moving bodies and their joints, at the start."""
        data = data_at(self.model, self.start)
        mujoco.mj_kinematics(self.model, data)
        moving = self.model.body_weldid > 0
        places = np.concatenate([data.xpos[moving], data.xipos[moving], data.xanchor])
        size = float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
        return size if size > 0.0 else float(self.model.stat.extent)

    def change(self, edits: Sequence[Edit]) -> float:
        """The largest change of the observed positions that edits make, over the travel."""
        return self.change_to(self.edited(edits).run)

    def change_from(self, start: Array) -> float:
        """The same of another start."""
        return self.change_to(run(self.model, start, self.steps, self.observed))

    def change_to(self, other: Run) -> float:
        """The same of another run; beyond all bounds where one of the two broke earlier."""
        one = self.run.points
        if len(one) != len(other.points):
            return BOUNDLESS
        largest = float(np.linalg.norm(one - other.points, axis=2).max()) if one.size else 0.0
        # What stands has no travel.
        share = largest / (self.run.travel if self.run.travel > UNCHANGED * self.size else self.size)
        return share if math.isfinite(share) else BOUNDLESS

    def tried(self, finding: Finding, edits: Sequence[Edit], same: float) -> Finding:
        """A finding with edits, where the file has a place for them; safe where the motion changes by no more."""
        if not self.document.can_make(edits):
            return finding
        change = self.change(edits)
        return replace(finding, edits=tuple(edits), safe=change <= same, change=change)


Judge = Callable[[Bench], Iterator[Finding]]


@dataclass(frozen=True)
class Rule:
    """One kind of trouble that a model is searched for.

    Attributes:
        judge: looks at a model on the bench; its name is the rule's, its docstring what it finds, as in docs/lint.md.
    """

    judge: Judge
    why: str  # what it finds is harmful
    needs_motion: bool  # whether it needs a run that does not break

    @property
    def name(self) -> str:
        """Name for the command line and for results."""
        return self.judge.__name__.replace("_", "-")

    def findings(self, bench: Bench) -> Iterator[Finding]:
        """What it finds in a model, with its name and reason."""
        return (replace(found, rule=self.name, why=self.why) for found in self.judge(bench))


def rule(why: str, needs_motion: bool = True) -> Callable[[Judge], Rule]:
    """Make a rule of a function that judges a model; its entry in `RULES` has it judged."""
    return lambda judge: Rule(judge, why, needs_motion)
