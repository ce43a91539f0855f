"""Runs of a model as it is and hardened, against the machine with its loops closed."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.engines.mujoco.model import equality_jacobian
from conrod.exact.motion import Array
from conrod.mjcf.equalities import REDUNDANT, close_loops, openings
from conrod.mjcf.harden.recipe import Closure
from conrod.mjcf.harden.results import Request, Variant
from conrod.mjcf.runs import looks, looping_stepper, run, state_of
from conrod.own.models.loading import data_at_start, start_words
from conrod.studies.frame.paired_timing import PairedTiming, paired_cost

CLOSED = 1e-12  # of the model's size
# Under RK4 a sixteenth of the step leaves 1/65536 of the error; an eighth shows how well that is known.
REFERENCE, CHECK = 16, 8


@dataclass(frozen=True)
class Start:
    """State from which runs start."""

    state: Array
    name: str  # what a user calls it
    given: float  # largest opening of the pose as given [m]
    closed: bool  # whether the loops could be closed; the state is as given where they could not


def start_of(model: mujoco.MjModel, request: Request) -> Start:
    """The start that is asked for, or the first keyframe where there is one, with its loops closed where they can be.

    So are its rates: the nearest that open no loop.

    Raises:
        InvalidInput: the model has no such keyframe or actuator.
    """
    data, index = data_at_start(model, request.keyframe, request.controls)
    mujoco.mj_fwdPosition(model, data)
    given = float(openings(model, data, float(model.stat.extent)).max(initial=0.0))
    before, name = state_of(model, data), start_words(model, index, data.ctrl)
    if not close_loops(model, data, CLOSED * float(model.stat.extent)):
        return Start(before, name, given, closed=False)
    jacobian = equality_jacobian(model, data)
    data.qvel[:] -= np.linalg.lstsq(jacobian, jacobian @ data.qvel, rcond=REDUNDANT)[0]
    return Start(state_of(model, data), name, given, closed=True)


# -- runs --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pace:
    """Steps and samples of a run."""

    samples: int  # that it is looked at after the start
    stride: int  # steps from one to the next
    timestep: float  # [s]

    def finer(self, times: int) -> Pace:
        """Pace with the same samples, and so many times as many steps."""
        return Pace(self.samples, self.stride * times, self.timestep / times)


@dataclass(frozen=True)
class Swing:
    """A run at its S + 1 samples, the start among them."""

    points: Array  # (S + 1, bodies, 3) centres of gravity of all that can move [m]
    openings: Array  # (S + 1, closures) [m]
    steps: int  # that were completed
    broke: str  # the engine's warning that ended it, empty where it completed; the samples end before it

    @property
    def travel(self) -> float:
        """The longest way of a body from where it was at the start [m]."""
        return float(np.linalg.norm(self.points - self.points[0], axis=2).max())

    def drift(self, other: Swing) -> float:
        """The largest distance of a body from where it is in another run [m]."""
        return float(np.linalg.norm(self.points - other.points, axis=2).max(initial=0.0))


def swing(model: mujoco.MjModel, state: Array, pace: Pace, closures: Sequence[Closure]) -> Swing:
    """Run a model from a state; it ends at the first warning of numbers that are none."""
    made = run(paced(model, pace), state, pace.samples * pace.stride, pace.stride)
    moving, chosen, size = model.body_weldid > 0, [one.index for one in closures], float(model.stat.extent)
    seen = [(look.xipos[moving].copy(), openings(model, look, size)[chosen]) for look in looks(model, made.states)]
    points, gaps = (np.array(column) for column in zip(*seen, strict=True))
    return Swing(points, gaps, pace.stride * (len(seen) - 1), made.broke)


def paced(model: mujoco.MjModel, pace: Pace) -> mujoco.MjModel:
    """A copy that steps at the pace and does not begin again by itself where it breaks."""
    made = copy.copy(model)
    made.opt.timestep = pace.timestep
    made.opt.disableflags |= older.flag("AUTORESET")
    return made


# -- figures -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reference:
    """The machine with its loops closed: the hardened model under RK4 at a sixteenth of the step.

    What a soft loop adds to the motion is thus an error, as it is for the user.
    """

    swing: Swing
    known_to: float | None  # how far it is from itself at an eighth [m]; None where one of the two broke

    @classmethod
    def of(cls, precise: mujoco.MjModel, state: Array, pace: Pace, closures: Sequence[Closure]) -> Reference:
        """The reference, by a hardened model under RK4."""
        fine, check = (swing(precise, state, pace.finer(times), closures) for times in (REFERENCE, CHECK))
        rounding = float(np.finfo(float).eps) * float(precise.stat.extent)
        return cls(fine, None if fine.broke or check.broke else max(fine.drift(check), rounding))

    @property
    def travel(self) -> float | None:
        """The longest way of a body [m]; None where it broke."""
        return None if self.swing.broke else self.swing.travel

    def variant(
        self, name: str, model: mujoco.MjModel, state: Array, pace: Pace, closures: Sequence[Closure]
    ) -> Variant:
        """Figures of a model's run."""
        made = swing(model, state, pace, closures)
        if made.broke:
            return Variant(name, made.steps, made.broke)
        drift = None if self.known_to is None else made.drift(self.swing)
        return Variant(name, made.steps, "", tuple(made.openings.max(axis=0).tolist()), drift)


def cost(own: mujoco.MjModel, hardened: mujoco.MjModel, state: Array, pace: Pace) -> PairedTiming:
    """Cost of a hardened step over one as it is, both through the same motion, again and again from its start."""
    soft, hard = (looping_stepper(paced(one, pace), state, pace.samples * pace.stride) for one in (own, hardened))
    return paired_cost(hard, soft)
