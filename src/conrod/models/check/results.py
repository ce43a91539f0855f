"""All that is found about a user's model, and the verdict on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from conrod.comparison.compare import Size
from conrod.comparison.other_forces import OtherForce
from conrod.comparison.trajectory import COMPARED_QUANTITIES, Outcome
from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.execution.tolerances import judged_scale, point_scales
from conrod.mjcf.crank_speed import MAX_MEAN_SPEED_ERROR, CrankSpeed
from conrod.mjcf.loop_results import OWN_SETTINGS
from conrod.mjcf.request import ModelFacts, ModelRequest
from conrod.models.check.identity import DEFAULT_TOLERANCE, Identity
from conrod.report.drawing.moving_links import MovingLinks
from conrod.scenes import Scene
from conrod.studies.validation.results import Qualification, RefinementPoint

OWN_RUN = "its own run"  # label of the run from the file's own start, by its own actuators
MAX_DRIVE_RIPPLE = 1e-7  # largest deviation of the rate that conrod's drive leaves, relative to it
# The position's tolerance bounds the opening of the loops, too; over the machine's largest length.
CLOSURE = "closure"


@dataclass(frozen=True)
class JudgedRun:
    """A run of a user's model with its errors.

    Attributes:
        errors: errors by observed point and quantity; None if the run did not complete.
        phase: largest deviation of the crank angle from the nominal one [rad].
        acting: forces that acted besides weight, inertia and the loops.
        opening: largest gap of the loops, over the machine's largest length.
    """

    label: str
    outcome: Outcome
    reason: str
    steps_per_revolution: float
    errors: Mapping[str, Mapping[str, Size]] | None
    phase: float
    acting: tuple[OtherForce, ...] = ()
    opening: float = 0.0

    def worst(self, quantity: str, measure: str = "max") -> float | None:
        """The largest error of a quantity over all points; None if the run did not complete."""
        if self.errors is None:
            return None
        return float(np.max([getattr(sizes[quantity], measure) for sizes in self.errors.values()]))

    def judged_error(self, name: str) -> float:
        """The error that a tolerance of this name is compared with; NaN if the run did not complete."""
        if name == CLOSURE:
            return self.opening
        quantity, _, measure = name.partition("_")
        found = self.phase if quantity == "phase" else self.worst(quantity, measure or "max")
        return math.nan if found is None else found


@dataclass(frozen=True)
class ModelStudy:
    """The study of a user's model against a scene, with its verdict.

    Attributes:
        file: name of the file as the user gave it.
        scene_name, scene: the machine that the model must be.
        model: its joints, closures and settings.
        tolerance: tolerances that the user gave, by quantity; None for the default of kinematic mode alone.
        own_run: run of the file with its own start and actuators; None if the model is too far off the machine.
        crank: speed of the crank in that run; None if it did not complete.
        runs: dynamic mode with conrod's drive, by label; empty there, too.
        refused: presets that were not run, with the reason.
        points: points that the runs are compared at.
        refined: the same runs at coarser and finer steps, by label; empty without refinement.
        distrust: how the exact motion contradicts the joints' equations, in words; empty if it does not.
        weights: for tolerances given in units, the weight of each point's error (`scale_tolerance`).
        qualified: verdicts on planted defects; None if none were planted.
        drawn: the model in motion, driven, over its own exact motion; None if nothing could be drawn.
        blocked: why it cannot turn as the machine does, with what differs from the machine, in words; it has no paths
            to be known by, and nothing else is judged. Empty for a model that turns.
    """

    file: str
    scene_name: str
    scene: Scene
    question: ModelRequest
    model: ModelFacts
    identity: Identity
    tolerance: Mapping[str, float] | None
    revolutions: float
    runs: Mapping[str, JudgedRun]
    refused: Mapping[str, str]
    points: tuple[str, ...]
    own_run: JudgedRun | None = None
    crank: CrankSpeed | None = None
    refined: Mapping[str, tuple[RefinementPoint, ...]] = field(default_factory=dict)
    distrust: str = ""
    weights: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    qualified: Qualification | None = None
    drawn: MovingLinks | None = None
    blocked: str = ""

    @property
    def kinematic_tolerance(self) -> float:
        """Allowed distance of the paths from the exact ones, over each point's length."""
        return (self.tolerance or {}).get("position", DEFAULT_TOLERANCE)

    @property
    def is_machine(self) -> bool:
        """True if the model's points follow the machine's paths within `kinematic_tolerance`."""
        weights = self.weights.get("position", {})
        return not self.blocked and self.identity.is_machine(self.kinematic_tolerance, weights)

    @property
    def has_start(self) -> bool:
        """True if the file itself starts a motion: by a keyframe, a control or a rate that is not 0.

        Without one it is a machine that others drive, such as a program that sets its controls.
        """
        return self.model.from_keyframe or self.model.moves or any(self.model.controls.values())

    @property
    def speed_tolerance(self) -> float:
        """Allowed relative error of the mean crank speed in the file's own run.

        The velocity's tolerance if the user gave it, else the position's if it is less than a per cent: after a
        radian of the crank, a speed off by a share e has a point off by about e of its travel.
        """
        asked = self.tolerance or {}
        return (
            asked["velocity"]
            if "velocity" in asked
            else min(MAX_MEAN_SPEED_ERROR, asked.get("position", MAX_MEAN_SPEED_ERROR))
        )

    @property
    def strays(self) -> bool:
        """True if the file starts a motion, and its crank does not keep the scene's speed."""
        return self.has_start and self.crank is not None and self.crank.strays(self.scene.speed, self.speed_tolerance)

    @property
    def rates_off(self) -> bool:
        """True if the start rates violate the closures by more than the velocity tolerance, or 1 %."""
        size, unit = max(self.scene.lengths.values()) * abs(self.scene.speed), self.identity.frame.unit
        allowed = (self.tolerance or {}).get("velocity", MAX_MEAN_SPEED_ERROR) * size
        return self.model.rates is not None and not unit * self.model.rates.opening <= allowed

    @property
    def own_failed(self) -> bool:
        """True if the file's own run did not complete, strays, starts off its loops, or is out of tolerance."""
        run = self.own_run
        if run is None or run.outcome is not Outcome.COMPLETED or self.strays or self.rates_off:
            return True
        return self.has_start and bool(self.exceeded_limits(run))

    @property
    def begins_open(self) -> bool:
        """True if the file's own run starts with loops open by more than the tolerance, or 0.1 % of its size."""
        asked, begins = (self.tolerance or {}).get("position"), self.model.begins
        allowed = None if asked is None else asked * max(self.scene.lengths.values()) / self.identity.frame.unit
        return begins is not None and begins.exceeds(allowed)

    @property
    def driven_run(self) -> JudgedRun | None:
        """The driven run with the model's own settings; None if the model is too far from the machine."""
        return self.runs.get(OWN_SETTINGS)

    @property
    def limits(self) -> Mapping[str, float]:
        """Allowed errors: the tolerances given, and the clock limits that follow from them and the drive.

        The drive keeps the speed to `MAX_DRIVE_RIPPLE`. The position at the nominal time may be off by the position's
        tolerance and by the distance that the phase moves the point.
        """
        asked, own = self.tolerance or {}, self.driven_run
        closing = {CLOSURE: asked["position"]} if "position" in asked else {}
        if own is None:
            return {**asked, **closing}
        kept = phase_bound(own.steps_per_revolution * self.revolutions, self.revolutions)
        phase = kept + MAX_DRIVE_RIPPLE * 2.0 * np.pi * self.revolutions
        clock = {"phase": phase}
        if "position" in asked:
            clock["total"] = asked["position"] + phase * largest_derivatives(self.scene.kinematics, 1)[1]
        return {**clock, **asked, **closing}

    @property
    def own_limits(self) -> Mapping[str, float]:
        """Allowed errors of the file's own run: its clock is limited only by tolerances that were given."""
        asked = self.tolerance or {}
        derived = {"phase", "total"} - asked.keys()
        return {name: size for name, size in self.limits.items() if name not in derived}

    def judged_points(self, run: JudgedRun, name: str) -> dict[str, float]:
        """Errors of a run, by point, that the named tolerance limits; empty if it concerns no points."""
        quantity, _, measure = name.partition("_")
        if quantity not in COMPARED_QUANTITIES:
            return {}
        weights = self.weights.get(name, {})
        found = {point: getattr(sizes[quantity], measure or "max") for point, sizes in (run.errors or {}).items()}
        return {point: size * weights.get(point, 1.0) for point, size in found.items()}

    def judged_error(self, run: JudgedRun, name: str) -> float:
        """A run's error that a tolerance of this name is compared with; NaN if it did not complete."""
        found = self.judged_points(run, name)
        return float(np.max([*found.values()])) if found else run.judged_error(name)

    def judged_scale(self, run: JudgedRun, name: str) -> float | None:
        """SI size of a share of 1 of a run's judged error; None for a phase."""
        lengths = self.scene.lengths
        if name == CLOSURE:
            return max(lengths.values())
        scales = point_scales(lengths, self.scene.speed).get(name, {})
        return judged_scale(self.judged_points(run, name), scales, weighed=name in self.weights)

    def exceeded_limits(self, *runs: JudgedRun) -> dict[str, tuple[float, float]]:
        """Quantities out of tolerance with found and allowed value, of all judged runs or of some.

        The clock of the model's own run is its drive's, and held to what was asked for alone.
        """
        over = dict[str, tuple[float, float]]()
        for run in runs or self.judged:
            limits = self.limits if run is self.driven_run else self.own_limits
            for name, allowed in limits.items() if run.errors is not None else ():
                if not (found := self.judged_error(run, name)) <= allowed:
                    over[name] = max((found, allowed), over.get(name, (found, allowed)))
        return over

    @property
    def judged(self) -> list[JudgedRun]:
        """Runs with a tolerance: with the model's own settings, and the file's own run if it starts a motion."""
        own_run = self.own_run if self.has_start else None
        return [run for run in (self.driven_run, own_run) if run is not None]

    @property
    def passed(self) -> bool:
        """True if the model is the machine, can turn, and completes its runs within tolerance."""
        own = self.driven_run
        if self.qualified is not None and self.qualified.notices_nothing:
            return False
        if self.distrust or not self.is_machine or self.model.stops or self.own_failed or self.begins_open:
            return False
        return own is not None and own.outcome is Outcome.COMPLETED and not self.exceeded_limits()
