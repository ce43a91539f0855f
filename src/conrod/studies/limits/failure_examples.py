"""A run that is made on purpose to end in a certain way.

The closed list of outcomes, each with runs that end so.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

from conrod.engines import engine_named
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import SCENES, CamFollower, Scene, ShearPress
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.study import Study
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.extremes import Extremes
from conrod.studies.limits.grade import grade_of
from conrod.studies.limits.perform import BoundedCell
from conrod.studies.limits.solver_notes import solver_note


@dataclass(frozen=True)
class Specimen:
    """A preset with what was done to it.

    Attributes:
        outcome: how it ends.
        title, what: what it is, and what was done to the preset, each in a line.
        name: of the scene.
        changes: of settings, by their names.
        step_constant: time constant of the joints in steps, set beside the changes; None leaves the preset's.
        unchecked: settings that conrod refuses, put past its check.
        timeout, headroom: of a run that needs limits of its own, see `BoundedCell`.
    """

    outcome: Outcome
    title: str
    what: str
    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str
    steps: int
    changes: Mapping[str, Any] = field(default_factory=dict)
    step_constant: float | None = None
    unchecked: Mapping[str, Any] = field(default_factory=dict)
    revolutions: float = 2.0
    timeout: float | None = None
    headroom: int | None = None

    @cached_property
    def settings(self) -> Settings:
        """The preset with its changes."""
        made = engine_named(self.engine).presets[self.preset](self.scene, self.steps)
        changes = dict(self.changes)
        if self.step_constant is not None:
            changes["solref"] = (self.step_constant * made.timestep, 1.0)
        if changes or self.unchecked:
            made = replace(made, preset="custom", **changes)
        return unchecked(made, **self.unchecked) if self.unchecked else made

    @cached_property
    def cell(self) -> LimitCell:
        """The run."""
        if self.headroom is not None:
            return BoundedCell(
                self.name, self.scene, self.settings, self.revolutions, headroom=self.headroom, whole=True
            )
        if self.timeout is not None:
            return BoundedCell(self.name, self.scene, self.settings, self.revolutions, timeout=self.timeout)
        return LimitCell(self.name, self.scene, self.settings, self.revolutions)


def unchecked(settings: Settings, **changes: Any) -> Settings:
    """Settings with values that their class refuses, for what an engine does when it is given them."""
    changed = copy.copy(settings)
    for name, value in changes.items():
        object.__setattr__(changed, name, value)
    return changed


PRESS, SAW, FAST_SAW, CAM = (SCENES[name] for name in ("shear-press", "saw-40rpm", "saw-500rpm", "cam-follower"))
# Of the rod's 390 mm the change point lacks 1 mm, a tenth and a hundredth of a millimetre.
NEAR, NEARER, NEAREST = (ShearPress(crank=crank) for crank in (0.389, 0.3899, 0.38999))
UNDERLOADED = CamFollower(preload=0.5)
HALF_GIGABYTE = 1 << 29  # bytes
ENDLESS = 1e6  # revolutions

GALLERY: tuple[Specimen, ...] = (
    Specimen(
        Outcome.COMPLETED,
        "nothing wrong",
        "the preset as it is",
        *("saw-40rpm", SAW, "mujoco", "hardened", 1000),
    ),
    Specimen(
        Outcome.DIVERGED,
        "stabilisation faster than the step",
        "time constant of the joints a tenth of a step, refsafe off",
        *("saw-40rpm", SAW, "mujoco", "tuned", 100),
        changes={"refsafe": False},
        step_constant=0.1,
    ),
    Specimen(
        Outcome.RESET,
        "MuJoCo's silent reset",
        "time constant of the joints a tenth of a step, refsafe off, autoreset on",
        *("saw-40rpm", SAW, "mujoco", "tuned", 100),
        changes={"refsafe": False, "autoreset": True},
        step_constant=0.1,
    ),
    Specimen(
        Outcome.EXPLODED,
        "too few steps",
        "two steps a revolution",
        *("saw-500rpm", FAST_SAW, "mujoco", "tuned", 2),
    ),
    Specimen(
        Outcome.EXPLODED,
        "too few steps for a contact",
        "sixteen steps a revolution",
        *("cam-follower", CAM, "pymunk", "tuned", 16),
    ),
    Specimen(
        Outcome.OPENED,
        "the solver-tolerance trap",
        "the drive's armature, and the solver's default tolerance 1e-8",
        *("saw-40rpm", SAW, "mujoco", "stock", 1000),
        changes={"tolerance": 1e-8},
    ),
    Specimen(
        Outcome.OPENED,
        "too few steps",
        "five steps a revolution",
        *("saw-500rpm", FAST_SAW, "mujoco", "tuned", 5),
    ),
    Specimen(
        Outcome.OPENED,
        "too few steps",
        "eight steps a revolution",
        *("saw-500rpm", FAST_SAW, "pymunk", "tuned", 8),
    ),
    Specimen(
        Outcome.FLIPPED,
        "through a change point",
        "crank and rod differ by 0.01 mm in 390",
        *("press near its change point", NEAREST, "mujoco", "tuned", 500),
    ),
    Specimen(
        Outcome.FLIPPED,
        "through a change point",
        "crank and rod differ by 1 mm in 390, 100 steps a revolution",
        *("press near its change point", NEAR, "pymunk", "tuned", 100),
    ),
    Specimen(
        Outcome.LOCKED,
        "a light flywheel at a limit pose",
        "crank and rod differ by 0.1 mm in 390, a flywheel of 1 kg m2",
        *("press near its change point", NEARER, "mujoco", "tuned", 500),
        changes={"armature": 1.0},
    ),
    Specimen(
        Outcome.STALLED,
        "a flywheel too light for the machine",
        "a flywheel of 0.01 kg m2",
        *("shear-press", PRESS, "mujoco", "tuned", 500),
        changes={"armature": 0.01},
    ),
    *(
        Specimen(
            Outcome.LOST_CONTACT,
            "follower float",
            "half the preload that the cam's acceleration takes",
            *("cam with half its preload", UNDERLOADED, engine, "tuned", 4000),
        )
        for engine in ("mujoco", "pymunk")
    ),
    Specimen(
        Outcome.TUNNELLED,
        "a contact softer than the fall",
        "time constant of the contact 0.1 s, stopped after a tenth of a turn, on the roller's way through the cam",
        *("cam-follower", CAM, "mujoco", "tuned", 500),
        changes={"contact_solref": (0.1, 1.0)},
        revolutions=0.1,
    ),
    Specimen(
        Outcome.CRASHED,
        "an engine's own assertion",
        "no iterations at all, which conrod refuses, put past its check",
        *("saw-500rpm", FAST_SAW, "pymunk", "tuned", 100),
        unchecked={"iterations": 0},
    ),
    Specimen(
        Outcome.TIMED_OUT,
        "a run without end",
        "a million revolutions in two seconds",
        *("saw-500rpm", FAST_SAW, "pymunk", "tuned", 1000),
        revolutions=ENDLESS,
        timeout=2.0,
    ),
    Specimen(
        Outcome.OUT_OF_MEMORY,
        "every sample of a million revolutions",
        "kept whole rather than streamed, in half a gigabyte",
        *("saw-500rpm", FAST_SAW, "mujoco", "tuned", 1000),
        revolutions=ENDLESS,
        headroom=HALF_GIGABYTE,
    ),
    Specimen(
        Outcome.UNSUPPORTED,
        "a preset that is not for this machine",
        "the preset as it is",
        *("cam-follower", CAM, "mujoco", "hardened", 1000),
    ),
)


@dataclass(frozen=True)
class Exhibit:
    """How a specimen ended.

    Attributes:
        expected, outcome: how it was to end, and how it did.
        reason: details of the outcome.
        title, what: of the specimen.
        quiet: wrong, and nothing in its numbers or from its engine says so.
        warnings: what the engine itself warned of, and how often.
        finite: see `Extremes`; None where nothing was recorded.
        solver: what is to be said of the engine's solver, empty where nothing is.
    """

    expected: str
    outcome: str
    reason: str
    title: str
    what: str
    scene: str
    engine: str
    preset: str
    steps: int
    quiet: bool
    warnings: Mapping[str, int]
    finite: bool | None
    solver: str
    key: str

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Exhibit:
        """The inverse of `as_dict`."""
        return cls(**values)


def gallery_search(specimens: tuple[Specimen, ...] = GALLERY) -> Study[tuple[Exhibit, ...]]:
    """All specimens, run."""
    answers = yield tuple(specimen.cell for specimen in specimens)
    return tuple(exhibit(specimen, answers[specimen.cell.key]) for specimen in specimens)


def exhibit(specimen: Specimen, measurement: Measurement) -> Exhibit:
    """A specimen with what its run showed."""
    watched = Extremes.of(measurement)
    return Exhibit(
        expected=specimen.outcome.slug,
        outcome=measurement.outcome,
        reason=measurement.reason,
        title=specimen.title,
        what=specimen.what,
        scene=specimen.name,
        engine=specimen.engine,
        preset=specimen.preset,
        steps=specimen.steps,
        quiet=grade_of(measurement).quiet,
        warnings={} if watched is None else dict(watched.warnings),
        finite=None if watched is None else watched.finite,
        solver="" if watched is None else solver_note(watched.solver),
        key=specimen.cell.key,
    )
