"""Failure examples: the closed list of outcomes, each with runs that are made on purpose to end so.

A module of its own, because a worker process imports it.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from conrod.engines import engine_named
from conrod.engines.engine import step_length
from conrod.engines.running import run
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import SCENES, CamFollower, Scene, ShearPress
from conrod.studies.execution.local import Ended, isolated
from conrod.studies.frame.case import Measurement
from conrod.studies.frame.run import RunCase, measure
from conrod.studies.limits.case import LimitCase
from conrod.studies.limits.stream_run import stream_run


@dataclass(frozen=True)
class BoundedCase(LimitCase):
    """A run within limits of its own, in a process of its own, whatever those of the executor are.

    Attributes:
        timeout: longest time that it may take [s].
        headroom: most memory that it may take beyond what its process begins with [bytes], None for no limit.
        whole: kept whole first, as by `conrod.run`, rather than streamed.
    """

    timeout: float = 60.0
    headroom: int | None = None
    whole: bool = False

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        bounds = {"timeout": self.timeout, "headroom": self.headroom, "whole": self.whole}
        return super()._identity(parameters) | {"bounds": bounds}

    def perform(self) -> Measurement:
        answer = isolated(_run, self, timeout=self.timeout, memory=self.headroom)
        return Measurement(answer.outcome.slug, answer.reason) if isinstance(answer, Ended) else answer


def _run(case: BoundedCase) -> Measurement:
    if not case.whole:
        return stream_run(case)
    run(case.scene, case.settings, case.revolutions, case.start_angle)
    return measure(RunCase(case.name, case.scene, case.settings, case.revolutions, case.start_angle))


@dataclass(frozen=True)
class Example:
    """A preset with what was done to it.

    Attributes:
        outcome: how it ends.
        title: the fault, in a line.
        name: of the scene.
        changes: of settings, by their names.
        unchecked: settings that conrod refuses, put past its check.
        timeout, headroom: of a run that needs limits of its own, see `BoundedCase`.
    """

    outcome: Outcome
    title: str
    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str
    steps: int
    changes: Mapping[str, Any] = field(default_factory=dict)
    unchecked: Mapping[str, Any] = field(default_factory=dict)
    revolutions: float = 2.0
    timeout: float | None = None
    headroom: int | None = None

    @cached_property
    def settings(self) -> Settings:
        """The preset with its changes."""
        made = engine_named(self.engine).presets[self.preset](self.scene, self.steps)
        if self.changes or self.unchecked:
            made = replace(made, preset="custom", **self.changes)
        return unchecked(made, **self.unchecked)

    @cached_property
    def case(self) -> LimitCase:
        """The run."""
        run = self.name, self.scene, self.settings, self.revolutions
        if self.headroom is None and self.timeout is None:
            return LimitCase(*run)
        whole = self.headroom is not None
        return BoundedCase(*run, timeout=self.timeout or 60.0, headroom=self.headroom, whole=whole)


def unchecked(settings: Settings, **changes: Any) -> Settings:
    """Settings with values that their class refuses, for what an engine does when it is given them."""
    changed = copy.copy(settings)
    for name, value in changes.items():
        object.__setattr__(changed, name, value)
    return changed


PRESS, SAW, FAST_SAW, CAM = (SCENES[name] for name in ("shear-press", "saw-40rpm", "saw-500rpm", "cam-follower"))
# Of the rod's 390 mm the change point lacks a tenth and a hundredth of a millimetre.
NEARER, NEAREST = (ShearPress(crank=crank) for crank in (0.3899, 0.38999))
UNDERLOADED = CamFollower(preload=0.5)
HASTY = {"solref": (0.1 * step_length(SAW, 100), 1.0)}  # a time constant of a tenth of a step
HALF_GIGABYTE = 1 << 29  # bytes
ENDLESS = 1e6  # revolutions

EXAMPLES: tuple[Example, ...] = (
    Example(Outcome.COMPLETED, "nothing wrong", "saw-40rpm", SAW, "mujoco", "hardened", 1000),
    Example(
        Outcome.DIVERGED, "stabilisation faster than the step", "saw-40rpm", SAW, "mujoco", "tuned", 100,
        changes={"refsafe": False, **HASTY},
    ),
    Example(
        Outcome.RESET, "MuJoCo's silent reset", "saw-40rpm", SAW, "mujoco", "tuned", 100,
        changes={"refsafe": False, "autoreset": True, **HASTY},
    ),
    Example(Outcome.EXPLODED, "too few steps", "saw-500rpm", FAST_SAW, "mujoco", "tuned", 2),
    Example(
        Outcome.OPENED, "the solver-tolerance trap", "saw-40rpm", SAW, "mujoco", "stock", 1000,
        changes={"tolerance": 1e-8},
    ),
    Example(Outcome.OPENED, "too few steps", "saw-500rpm", FAST_SAW, "mujoco", "tuned", 5),
    Example(Outcome.FLIPPED, "through a change point", "press near its change point", NEAREST, "mujoco", "tuned", 500),
    Example(
        Outcome.LOCKED, "a light flywheel at its limit", "press near its change point", NEARER, "mujoco", "tuned", 500,
        changes={"armature": 1.0},
    ),
    Example(
        Outcome.STALLED, "a flywheel too light for the machine", "shear-press", PRESS, "mujoco", "tuned", 500,
        changes={"armature": 0.01},
    ),
    Example(Outcome.LOST_CONTACT, "follower float", "cam with half its preload", UNDERLOADED, "pymunk", "tuned", 4000),
    Example(
        Outcome.TUNNELLED, "a contact softer than the fall", "cam-follower", CAM, "mujoco", "tuned", 500,
        changes={"contact_solref": (0.1, 1.0)},
        revolutions=0.1,
    ),
    Example(
        Outcome.CRASHED, "an engine's own assertion", "saw-500rpm", FAST_SAW, "pymunk", "tuned", 100,
        unchecked={"iterations": 0},
    ),
    Example(
        Outcome.TIMED_OUT, "a run without end", "saw-500rpm", FAST_SAW, "pymunk", "tuned", 1000,
        revolutions=ENDLESS,
        timeout=2.0,
    ),
    Example(
        Outcome.OUT_OF_MEMORY, "every sample of a million revolutions", "saw-500rpm", FAST_SAW, "mujoco", "tuned", 1000,
        revolutions=ENDLESS,
        headroom=HALF_GIGABYTE,
    ),
    Example(Outcome.UNSUPPORTED, "a preset for other machines", "cam-follower", CAM, "mujoco", "hardened", 1000),
)  # fmt: skip
