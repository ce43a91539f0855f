"""Results for a model's closed loops, as plain data that need no engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from conrod.comparison.other_forces import OtherForce
from conrod.comparison.trajectory import Outcome
from conrod.exact.space.mobility import Mobility
from conrod.execution.tolerances import exceeded_limits
from conrod.mjcf.crank_speed import MAX_MEAN_SPEED_ERROR, CrankSpeed
from conrod.mjcf.differences import NUMBER_TOLERANCE, MachineComparison
from conrod.mjcf.request import Controls, OpenStart
from conrod.report.drawing.moving_links import MovingLinks

OWN_SETTINGS = "as it is"  # label of the driven run with the model's own settings
LABELS = (OWN_SETTINGS, "tuned", "hardened")  # settings that a model is run with
LOOP_UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s^2"}
# The tolerance of the position bounds how far the loops open, too: a machine whose loops are open is another one.
LOOPS = "loops"
# MuJoCo's own constraints place a model as its exact motion does, within this share of the travel.
KINEMATIC_TOLERANCE = 1e-9
FEWEST_STEPS = 8  # of a motion, with which settings are tried at least


@dataclass(frozen=True)
class LoopRequest:
    """A user's request for a model with closed loops.

    Attributes:
        drives: law of each driven joint, as text (`conrod.exact.space.drive_laws`).
        keyframe: keyframe to assemble the model from; None for its reference pose.
        controls: control inputs of the file's own run.
        seconds: length of the runs [s]; None for the duration of the slowest law.
        points: sites that are judged; all where none is given.
        tolerance: allowed errors by quantity [SI]; empty if the user gave none.
        machine: machine that the model must be, a name or a model file; None if it is its own reference.
        unit: unit of the file's lengths [m].
        shares: allowed errors that were given as shares of `LoopStudy.scales`, by quantity.
        searched_share: share of the range of motion that settings are searched for where no tolerance is given; 0 for
            no search.
        largest_step: step [s] that actuators bear, above which no settings are searched; None without a limit.
        cpu_time: CPU time [s] after which no further run at other steps or for settings is made; None without a limit.
    """

    drives: Mapping[str, str]
    keyframe: str | None = None
    controls: Controls = ()
    seconds: float | None = None
    points: tuple[str, ...] = ()
    tolerance: Mapping[str, float] = field(default_factory=dict)
    machine: str | None = None
    unit: float = 1.0
    shares: Mapping[str, float] = field(default_factory=dict)
    searched_share: float = 0.0
    largest_step: float | None = None
    cpu_time: float | None = None

    def in_si(self, scales: Mapping[str, float]) -> LoopRequest:
        """The same request with its shares of scales [SI] among the tolerances."""
        sizes = {name: share * scales[name] for name, share in self.shares.items()}
        return replace(self, tolerance={**self.tolerance, **sizes})


@dataclass(frozen=True)
class LoopRun:
    """A driven run with its largest errors over all judged points.

    Attributes:
        label: name of the settings: the model's own, or a preset.
        errors: position [m], velocity [m/s] and acceleration [m/s^2]; empty where it did not complete.
        worst: the point with the largest error of position.
        gap: largest gap of the loops [m]; angles are multiplied by the machine's extent.
        drives, reactions: largest deviation of each drive's torque and each connect's force, over the largest exact
            one; empty where forces are not computed.
        order: observed order of the position in the time step; None if no order can be claimed, or none was measured.
        cost: time that a simulated second takes, over that with the model's own settings and step; None if not timed.
        acting: forces that acted besides weight, inertia and the loops.
    """

    label: str
    timestep: float
    outcome: Outcome
    reason: str = ""
    errors: Mapping[str, float] = field(default_factory=dict)
    worst: str = ""
    gap: float | None = None
    drives: Mapping[str, float] = field(default_factory=dict)
    reactions: Mapping[str, float] = field(default_factory=dict)
    order: float | None = None
    cost: float | None = None
    acting: tuple[OtherForce, ...] = ()

    def judged_error(self, name: str) -> float:
        """The error that a limit of this name is compared with; NaN if the run has none."""
        found = self.gap if name == LOOPS else self.errors.get(name)
        return math.nan if found is None else found

    def exceeded_limits(self, tolerance: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Quantities out of tolerance, with found and allowed value."""
        return exceeded_limits(loop_limits(tolerance), self.judged_error)

    def is_within(self, tolerance: Mapping[str, float]) -> bool:
        """True if the run completed with all errors and the loops' opening within tolerance."""
        return self.outcome is Outcome.COMPLETED and not self.exceeded_limits(tolerance)


def loop_limits(tolerance: Mapping[str, float]) -> dict[str, float]:
    """Allowed errors by quantity [SI], with the limit on the loops' opening that follows from the position's."""
    return {**tolerance, **({LOOPS: tolerance["position"]} if "position" in tolerance else {})}


@dataclass(frozen=True)
class JointSpeed:
    """Speeds [rad/s] of a driven hinge: in the file's own run, and by its law.

    Attributes:
        allowed: share of the law's speed that the mean may be off by.
    """

    joint: str
    own: CrankSpeed
    law: float
    allowed: float = MAX_MEAN_SPEED_ERROR

    @property
    def strays(self) -> bool:
        """True if the hinge does not keep the speed of its law."""
        return self.own.strays(self.law, self.allowed)


@dataclass(frozen=True)
class LawComparison:
    """The file's own run against the laws of the drives.

    Attributes:
        speeds: speeds of the hinges whose law is a constant speed; empty if there are none.
        other_branch: whether it begins or ends on another assembly branch than the laws' motion.
    """

    speeds: tuple[JointSpeed, ...] = ()
    other_branch: bool = False

    @property
    def strayed(self) -> tuple[JointSpeed, ...]:
        """Speeds of the hinges that do not keep to their law."""
        return tuple(one for one in self.speeds if one.strays)

    @property
    def differs(self) -> bool:
        """True if the own run has another speed, or is on another branch."""
        return self.other_branch or bool(self.strayed)


@dataclass(frozen=True)
class ShippedRun:
    """A run of the file as it is, with its actuators, from its start.

    Attributes:
        start: the start pose, in words.
        gap: as in `LoopRun`.
        chatter: joint whose rate swings back and forth from step to step, and by how much over its range; None
            where none does.
        driven: whether it starts with a control or a rate that is not 0: without, nothing but weight moves it.
        acting: as in `LoopRun`.
        laws: differences from the laws of the drives; unknown for a run that nothing drives.
        path: longest path [m] of a body, through the samples of the run.
    """

    start: str
    seconds: float
    outcome: Outcome
    reason: str
    gap: float
    chatter: tuple[str, float] | None = None
    driven: bool = True
    acting: tuple[OtherForce, ...] = ()
    laws: LawComparison = LawComparison()
    path: float = 0.0

    @property
    def failed(self) -> bool:
        """True if the run did not complete, or chatters."""
        return self.outcome is not Outcome.COMPLETED or self.chatter is not None

    def exceeds(self, tolerance: Mapping[str, float]) -> bool:
        """True if something drives the run and its loops open by more than is allowed."""
        return self.driven and not self.gap <= loop_limits(tolerance).get(LOOPS, math.inf)


@dataclass(frozen=True)
class SettingsSearch:
    """Search for the cheapest settings that hold a tolerance, in steps of powers of two.

    Attributes:
        allowed: tolerance by quantity [SI].
        names: settings that were tried.
        steps: smallest and largest step that was tried [s].
        best: cheapest run that holds the tolerance; None if none does.
        shipped: the file's own run with the settings of `best`.
        coarser, coarser_shipped: the same with twice its step, which do not hold; None where no larger step was tried.
        nearest: where none holds, the run with the least errors over their limits.
        speed, own_speed: simulated seconds in a second of CPU time on this machine, with the best and the own settings.
        python: lines of Python that make the best settings of a compiled model.
        after_compiling: those of them that MJCF cannot express.
        borne: whether the largest step that was tried is the largest that actuators bear.
        ended: CPU time [s] of all runs, where the search was ended by it; None where it came to its end.
    """

    allowed: Mapping[str, float]
    names: tuple[str, ...]
    steps: tuple[float, float]
    best: LoopRun | None = None
    shipped: ShippedRun | None = None
    coarser: LoopRun | None = None
    coarser_shipped: ShippedRun | None = None
    nearest: LoopRun | None = None
    speed: float = 0.0
    own_speed: float = 0.0
    python: str = ""
    after_compiling: str = ""
    borne: bool = False
    ended: float | None = None


@dataclass(frozen=True)
class LoopStudy:
    """The study of a model's closed loops, with its verdict.

    Attributes:
        name, engine_version: name of the model, version of MuJoCo.
        seconds, travel: duration of the motion [s], and the largest distance of a judged point from its start [m].
        held: joints that are held: a floating base.
        misfit: gap [m] that stays open in loops that contradict each other.
        kinematic: deviation of MuJoCo's own kinematics from the exact motion, by quantity, over the largest of each.
        ambiguous: connects whose reaction redundant closures leave open.
        unmodelled: forces that act and that the exact forces lack, so that forces are not compared.
        remarks: limits of joints and tendons that the motion leaves, contacts on the way, and the like.
        runs: runs at the model's own step; `steps`: runs at other steps.
        cheapest: cheapest run within tolerance; None if no run is, or without a tolerance.
        paste: sections of MJCF for the settings of `cheapest`; empty without one, or for a file that is no MJCF.
        presets: runs of the file with its actuators and its step, with each preset's settings.
        begins: open start of the file's own run; None if its loops start closed.
        points: points that are judged.
        moved: points that closures move, where no judged point is one.
        search: search that `cheapest` and `paste` are of; None without a tolerance.
        scales: largest range of motion [m], speed and acceleration [SI] of the judged points; what shares are of.
        compared: comparison with the machine that the model must be; None if the model is its own reference.
        drawn: the model in motion, its runs at its own step over the exact motion; None if no such run was made.
    """

    file: str
    name: str
    engine_version: str
    question: LoopRequest
    seconds: float
    travel: float
    held: tuple[str, ...]
    mobility: Mobility
    misfit: float
    kinematic: Mapping[str, float]
    ambiguous: tuple[str, ...]
    unmodelled: tuple[str, ...]
    remarks: tuple[str, ...]
    shipped: ShippedRun
    runs: tuple[LoopRun, ...]
    steps: tuple[LoopRun, ...]
    cheapest: LoopRun | None = None
    paste: str = ""
    compared: MachineComparison | None = None
    presets: Mapping[str, ShippedRun] = field(default_factory=dict)
    begins: OpenStart | None = None
    moved_start: str = ""
    about: str = ""
    points: tuple[str, ...] = ()
    search: SettingsSearch | None = None
    moved: tuple[str, ...] = ()
    scales: Mapping[str, float] = field(default_factory=dict)
    drawn: MovingLinks | None = None

    @property
    def begins_open(self) -> bool:
        """True if the file's run starts with loops open by more than the tolerance, or 0.1 % of its extent."""
        return self.begins is not None and self.begins.exceeds(self.question.tolerance.get("position"))

    @property
    def driven_run(self) -> LoopRun:
        """The run with conrod's drives and the model's own settings."""
        return self.runs[0]

    @property
    def agrees(self) -> bool:
        """True if MuJoCo's kinematics agree with the exact motion."""
        return all(off <= KINEMATIC_TOLERANCE for off in self.kinematic.values())

    @property
    def is_machine(self) -> bool:
        """True if points are where the machine's are, within tolerance, and all joints are of the same kinds."""
        if self.compared is None:
            return True
        allowed = self.question.tolerance.get("position", NUMBER_TOLERANCE * self.travel)
        off = self.compared.off
        return off is not None and off <= allowed and not self.compared.other_kinds

    @property
    def judges_loops_alone(self) -> bool:
        """True if closures move no judged point, so that points do not show how far loops open."""
        return all(name in self.mobility.rigid for name in self.points) and bool(self.points)

    @property
    def shipped_failed(self) -> bool:
        """True if the file's own run failed, is out of tolerance, or does not follow the drives' laws."""
        shipped = self.shipped
        return shipped.failed or shipped.exceeds(self.question.tolerance) or shipped.laws.differs

    @property
    def passed(self) -> bool:
        """True if it is the machine asked for, starts closed, and its shipped and driven runs are in tolerance."""
        held = self.driven_run.is_within(self.question.tolerance) and not self.begins_open
        return self.is_machine and self.agrees and not self.shipped_failed and held
