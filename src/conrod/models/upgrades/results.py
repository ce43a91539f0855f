"""What was found of a model in several releases of MuJoCo, as plain data that need no engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from conrod.exact.motion import Array
from conrod.execution.paired_timing import PairedTiming
from conrod.mjcf.request import Controls

# Causes of a change, in the order in which they are looked for.
REFUSED, COMPILED, TERM, ROUNDING = "refused", "compiled", "term", "rounding"
# Two motions have parted where a body is this share of the model's size from where it was.
PARTED_SHARE = 1e-6
# Largest change, as a share of the model's size, that counts as last digits.
LAST_DIGITS_SHARE = 1e-12


@dataclass(frozen=True)
class ModelRun:
    """A user's request: how the model runs in each release.

    Attributes:
        path: the model's file.
        keyframe: keyframe to start from; None for the first, or the model's own pose.
        controls: controls that replace those of the keyframe.
        seconds: length of the run [s].
    """

    path: str
    keyframe: str | None = None
    controls: Controls = ()
    seconds: float = 2.0


@dataclass(frozen=True, eq=False)
class ReleaseRun:
    """Run of a model in a release of MuJoCo, at T samples, and fields of the model as compiled.

    Attributes:
        fields: physical numbers of the compiled model, by the names of MuJoCo's fields.
        names: names of bodies, geoms, joints of degrees of freedom and actuators, by kind.
        options: integrator, solver and Jacobian, by the words of conrod's list of changes.
        timestep: time step [s].
        every: steps from one sample to the next.
        extent: size of the model [m], as MuJoCo computes it.
        states: parts of the state at the samples, each (T, n).
        bodies: positions (T, nbody, 3) [m] of the bodies at the samples.
        contacts: largest number of contacts at a sample.
        broke: why the run broke off: a warning of MuJoCo, or "not finite"; empty if it came to its end.
    """

    fields: Mapping[str, Array]
    names: Mapping[str, tuple[str, ...]]
    options: Mapping[str, str]
    timestep: float
    every: int
    extent: float
    states: Mapping[str, Array]
    bodies: Array
    contacts: int
    broke: str

    @property
    def samples(self) -> int:
        """Number of samples, T."""
        return len(self.bodies)

    def time_of(self, sample: int) -> float:
        """Time [s] of a sample."""
        return sample * self.every * self.timestep


@dataclass(frozen=True, eq=False)
class StepTerms:
    """Terms of the equations of motion at one state, and the state one step later.

    Attributes:
        forces: generalised forces (nv,) by name, in the order in which they are computed.
        contacts: pairs of geoms in contact, each with its distance [m].
        qacc: acceleration (nv,).
        after: coordinates and rates after the step.
    """

    forces: Mapping[str, Array]
    contacts: tuple[tuple[int, int, float], ...]
    qacc: Array
    after: Array


@dataclass(frozen=True)
class ModelChange:
    """Change of the model's own run from one release to the next.

    Attributes:
        version, before: the release with the change, and the release before.
        kind: cause of the change: `REFUSED`, `COMPILED`, `TERM` or `ROUNDING`.
        cause: the cause in words.
        ended: how the run ended before and after; "completed", or why it broke off.
        moved: largest distance [m] of a body from where it was in the release before.
        share: that distance over the model's size.
        body: the body that is furthest away.
        at: time [s] at which it is.
        differs_at: time [s] of the first sample that differs in any bit.
        parted_at: time [s] at which the motions have parted by `PARTED_SHARE`; None if they have not.
        explained: entries of the changelog that can be the cause; empty if there are none.
    """

    version: str
    before: str
    kind: str
    cause: str
    ended: tuple[str, str]
    moved: float | None = None
    share: float | None = None
    body: str = ""
    at: float | None = None
    differs_at: float | None = None
    parted_at: float | None = None
    explained: tuple[str, ...] = ()

    @property
    def last_digits(self) -> bool:
        """True if the motion changed by rounding alone, and has not grown."""
        return self.share is not None and self.share <= LAST_DIGITS_SHARE and self.ended[0] == self.ended[1]


@dataclass(frozen=True)
class ModelCost:
    """CPU time of a step in a release over that in the reference release; None and a reason if it cannot be timed."""

    version: str
    timing: PairedTiming | None
    noise: PairedTiming | None
    reason: str = ""

    @property
    def word(self) -> str:
        """`slower` or `faster` where the interval is beyond 1 and beyond the scatter of the reference."""
        return "" if self.timing is None or self.noise is None else self.timing.against_noise(self.noise)


@dataclass(frozen=True)
class UpgradeStudy:
    """Findings on a model in several releases of MuJoCo.

    Attributes:
        file: what the model is called.
        start: the start of its run, in words.
        seconds: length of its run [s].
        steps: number of its steps.
        extent: size of the model [m].
        measured: releases that ran it, the oldest first.
        unsupported: why a release could not be had, by release.
        changes: changes from one release to the next; none for releases that agree to the last bit.
        source: address of the engine's changelog.
        reference: release that costs are relative to; empty if none were asked for.
        costs: costs in the other releases.
    """

    file: str
    start: str
    seconds: float
    steps: int
    extent: float
    measured: tuple[str, ...]
    unsupported: Mapping[str, str]
    changes: tuple[ModelChange, ...]
    source: str
    reference: str = ""
    costs: tuple[ModelCost, ...] = field(default=())
