"""Findings of an inspection of a model, as plain data that need no engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from conrod.mjcf.loop_results import LoopStudy
from conrod.mjcf.request import MAX_START_OPENING, MIN_NAMED_OPENING, Controls
from conrod.models.inspection.actuator_results import ActuatorResult
from conrod.models.inspection.moving_results import FreeEnergy, KeyframeHold, LawResponse, ModelMobility
from conrod.models.inspection.moving_words import actuator_lines, keyframe_lines
from conrod.models.lint.findings import Finding, Severity
from conrod.report.drawing.moving_links import MovingLinks

# Of the range of motion: the tolerance on the position that settings are searched for, as none is given.
SEARCHED_SHARE = 1e-3
UNEXPLAINED = "its loops leave nothing that could be driven"  # where no axis explains why


@dataclass(frozen=True)
class InspectionRequest:
    """A user's request for an inspection.

    Attributes:
        keyframe: keyframe to start from; None for the first, or the reference pose without any.
        drives: law of each driven joint, as text; empty to choose a drive.
        controls: inputs of actuators in place of the keyframe's.
        unit: unit of the model's lengths [m].
    """

    keyframe: str | None = None
    drives: Mapping[str, str] = field(default_factory=dict)
    controls: Controls = ()
    unit: float = 1.0


@dataclass(frozen=True)
class Loading:
    """Content of a model as MuJoCo loads it: numbers of parts, size and mass.

    Attributes:
        bodies, joints, closures, actuators: how many there are; the world is no body.
        across: largest distance between two parts in the reference pose [m].
        mass: mass of all bodies [kg].
        left_out: files and parts that are not there and that no motion needs, in words.
        remarks: what is lost in translation, or looks wrong, in words.
        likely_unit: unit that its lengths seem to have, to be given as `--unit`; empty where they seem right.
    """

    bodies: int
    joints: int
    closures: int
    actuators: int
    across: float
    mass: float
    left_out: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    likely_unit: str = ""


@dataclass(frozen=True)
class PoseOpening:
    """How far the closures are open in a pose.

    Attributes:
        pose: the pose in words, such as 'its own pose' or 'keyframe home'.
        gaps: opening of each closure that acts, by name [m]; an angle times the machine's extent.
        closed: the nearest closed pose as `qpos` of MJCF; empty where all are closed, or no pose near it closes them.
        outside: joints that are outside their ranges there, in words; empty if none is.
        inside: the nearest closed pose with joints in their ranges, as `qpos`; empty where none was found.
        singular: whether the closures allow more motion in this pose than near it: folded, or at a change point.
    """

    pose: str
    gaps: Mapping[str, float]
    closed: str = ""
    outside: str = ""
    inside: str = ""
    singular: bool = False

    @property
    def worst(self) -> str:
        """Name of the closure with the largest opening; empty without closures."""
        return max(self.gaps, key=lambda name: self.gaps[name], default="")

    @property
    def largest(self) -> float:
        """Largest opening [m]."""
        return max(self.gaps.values(), default=0.0)


@dataclass(frozen=True)
class Closing:
    """Whether a model's loops close.

    Attributes:
        extent: size of the machine [m].
        poses: the pose that its own run starts from, then the reference pose and all keyframes.
        remarks: closures that are inactive, are handles, or hold parts that do not meet, in words.
        apart: whether a closure holds parts that do not meet.
    """

    extent: float
    poses: tuple[PoseOpening, ...]
    remarks: tuple[str, ...] = ()
    apart: bool = False

    @property
    def start(self) -> PoseOpening:
        """The pose that the file's own run starts from."""
        return self.poses[0]

    def is_named(self, pose: PoseOpening) -> bool:
        """True if a pose's opening is more than rounding of a file's numbers."""
        return pose.largest > MIN_NAMED_OPENING * self.extent

    @property
    def passed(self) -> bool:
        """True if the run starts closed, within a thousandth of the extent, and all closures' parts meet."""
        return self.start.largest <= MAX_START_OPENING * self.extent and not self.apart


@dataclass(frozen=True)
class Moving:
    """Degrees of freedom of a model, and how its actuators, drives and keyframes behave.

    Attributes:
        mobility: its degrees of freedom, and what drives them; None of a model that has too many to count.
        actuators: results of its actuators, in order; empty where laws are given.
        keyframes: its keyframes, held by their controls.
        energy: energy of its free swing; None of a model that is no open chain.
        followed: responses to the laws that were given.
    """

    mobility: ModelMobility | None
    actuators: tuple[ActuatorResult, ...] = ()
    keyframes: tuple[KeyframeHold, ...] = ()
    energy: FreeEnergy | None = None
    followed: tuple[LawResponse, ...] = ()

    @property
    def alarms(self) -> tuple[str, ...]:
        """Faults of actuators, driven laws, keyframes and energy, each in words with its name."""
        weak = (f"with {one.words}" for one in self.followed if one.is_too_weak or one.broke)
        left = (one.words for one in self.keyframes if not one.stays)
        # Damping of the model takes out in its own runs what the step adds.
        energy = self.energy
        grown = (energy.words,) if energy is not None and energy.grows and not energy.damped else ()
        # Sentences that begin with these words leave names as they are written.
        tried = (f"actuator {one.name} {words}" for one in self.actuators for words in one.alarms)
        return (*tried, *weak, *left, *grown)

    @property
    def passed(self) -> bool:
        """True if something can move, no run broke off, and no servo is too weak or misses its command."""
        broke = [one.broke for one in self.actuators]
        broke += [*(one.broke for one in self.keyframes), *(one.broke for one in self.followed)]
        weak = [
            *(one.is_too_weak or one.misses_command for one in self.actuators),
            *(one.is_too_weak for one in self.followed),
        ]
        return not (self.mobility is not None and self.mobility.is_stuck) and not any(broke) and not any(weak)

    @property
    def is_stuck_closed(self) -> bool:
        """True if nothing can move although the loops are closed where that was counted."""
        return self.mobility is not None and self.mobility.is_stuck and self.mobility.closed

    @property
    def lines(self) -> tuple[str, ...]:
        """The answer to `what moves it?` in lines; one at least."""
        many = "its degrees of freedom are too many to count" if self.mobility is None else self.mobility.words
        said = [many, *(one.words for one in self.followed), *actuator_lines(self.actuators)]
        said += keyframe_lines(self.keyframes)
        return (*said, *((self.energy.words,) if self.energy is not None and self.energy.grows else ()))


@dataclass(frozen=True)
class Inspection:
    """Findings of a model's inspection, in the order for a user to act on.

    Attributes:
        name, engine_version: name of the model in the report, version of MuJoCo.
        moving: degrees of freedom and actuators.
        drives: laws that `motion` was judged with.
        motion: its loops, judged by its exact motion; None where it has no loop or no drive.
        not_judged: why `motion` is None, or why its drives go no further.
        findings: what lint finds, worst first.
        lint_notes: what lint says of its own judging, or why it found nothing.
        drawn: runs of its actuators, or of the file as it is, in motion, where no exact motion is judged.
    """

    file: str
    name: str
    engine_version: str
    question: InspectionRequest
    loading: Loading
    closing: Closing
    moving: Moving
    drives: Mapping[str, str] = field(default_factory=dict)
    motion: LoopStudy | None = None
    not_judged: str = ""
    findings: tuple[Finding, ...] = ()
    lint_notes: tuple[str, ...] = ()
    drawn: MovingLinks | None = None

    @property
    def picture(self) -> MovingLinks | None:
        """The model in motion: its judged runs over its exact motion, else other runs; None if nothing is drawn."""
        judged = None if self.motion is None else self.motion.drawn
        return judged or self.drawn

    @property
    def errors(self) -> tuple[Finding, ...]:
        """Findings of lint that make the motion wrong."""
        return tuple(one for one in self.findings if one.severity is Severity.ERROR)

    @property
    def passed(self) -> bool:
        """True if the model closes, can move, passes its motion check, and lint finds no error."""
        ran = self.motion is None or self.motion.passed
        return self.closing.passed and self.moving.passed and self.loading.joints > 0 and ran and not self.errors
