"""All that is found of a user's model, and the verdict on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.own.models.frame import GivenFrame
from conrod.own.models.identity import DEFAULT_TOLERANCE, Identity, identify
from conrod.own.models.references import other_branches
from conrod.own.models.request import Drive, DrivenRun, ModelFacts, Order, Question, Scan
from conrod.own.models.runs import JudgedRun, RunReference, difference, judged
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene

if TYPE_CHECKING:
    from conrod.engines.engine import Engine

OWN, EXACT_SOLVER = "as it is", "as it is, solver tolerance 0"
PRESETS = ("tuned", "hardened")
RIPPLE = 1e-7
# A model whose points are further off than this, with all lengths fitted, is another machine: its runs say nothing.
COMPARABLE = 0.05

Runs = Callable[[Drive, tuple[Order, ...]], tuple[DrivenRun, ...]]


@dataclass(frozen=True)
class ModelStudy:
    """A user's model, judged.

    Attributes:
        file: as the user named it.
        scene_name, scene: the machine that it is to be.
        model: its joints, closures and settings.
        tolerance: asked for, by quantity; None for the default of kinematic mode alone.
        runs: dynamic mode by label; empty where the model is too far off the machine.
        refused: presets that were not run, with the reason.
        drive_share: change of the errors by the drive through the solver's tolerance, by quantity; None where unknown.
        points: that the runs are compared at.
    """

    file: str
    scene_name: str
    scene: Scene
    question: Question
    model: ModelFacts
    identity: Identity
    tolerance: Mapping[str, float] | None
    revolutions: float
    runs: Mapping[str, JudgedRun]
    refused: Mapping[str, str]
    drive_share: Mapping[str, float] | None
    points: tuple[str, ...]

    @property
    def kinematic_tolerance(self) -> float:
        """That the paths are held to, over the point's length."""
        return (self.tolerance or {}).get("position", DEFAULT_TOLERANCE)

    @property
    def is_machine(self) -> bool:
        """True if the paths are the machine's."""
        return self.identity.is_machine(self.kinematic_tolerance)

    @property
    def own(self) -> JudgedRun | None:
        """The run that stands for the model's own settings: with what the drive changes taken away, if it completed."""
        exact, own = self.runs.get(EXACT_SOLVER), self.runs.get(OWN)
        return exact if exact is not None and exact.outcome is Outcome.COMPLETED else own

    @property
    def limits(self) -> Mapping[str, float]:
        """What is allowed: the tolerance asked for, and what follows from it and the drive for the clock.

        The drive keeps the speed to `RIPPLE`. The position at the nominal time may be off by the tolerance of the
        position and by what the phase moves the point.
        """
        asked, own = self.tolerance or {}, self.own
        if own is None:
            return asked
        kept = phase_bound(own.steps_per_revolution * self.revolutions, self.revolutions)
        phase = kept + RIPPLE * 2.0 * np.pi * self.revolutions
        clock = {"phase": phase}
        if "position" in asked:
            clock["total"] = asked["position"] + phase * largest_derivatives(self.scene.kinematics, 1)[1]
        return {**clock, **asked}

    def exceeded(self) -> dict[str, tuple[float, float]]:
        """Quantities that are out of tolerance: found and allowed."""
        own = self.own
        if own is None or own.errors is None:
            return {}
        found = {name: (own.judged_error(name), allowed) for name, allowed in self.limits.items()}
        return {name: pair for name, pair in found.items() if not pair[0] <= pair[1]}

    @property
    def passed(self) -> bool:
        """True if it is the machine, may turn, and completes the run with its own settings as asked for."""
        own = self.own
        if not self.is_machine or self.model.stops or own is None:
            return False
        return own.outcome is Outcome.COMPLETED and not self.exceeded()


def study(
    file: str,
    scene: tuple[str, Scene],
    question: Question,
    scan: Scan,
    given: GivenFrame,
    engine: Engine[Any],
    run: Runs,
    revolutions: float,
    most_samples: int,
    tolerance: Mapping[str, float] | None,
) -> ModelStudy:
    """Judge a scanned model.

    Args:
        scene: its name and itself.
        run: drives the model.

    Raises:
        InvalidInput: its plane of motion or its frame cannot be determined, or its runs cannot be made.
    """
    name, machine = scene
    identity, moving = identify(machine, scan, given)
    misplaced = identity.explanations[0].misplaced if identity.explanations else ()
    wrong = {one.point for one in misplaced}
    # Compared are points that are where they should be on their links; all, where none is.
    points = tuple(point for point in scan.points if point not in wrong) or scan.points
    found = ModelStudy(
        file, name, machine, question, scan.facts, identity, tolerance, revolutions, {}, {}, None, points
    )
    if identity.left > COMPARABLE:
        return found
    orders, refused = _orders(machine, scan, engine)
    frame, first = identity.frame, float(scan.coordinate[0])
    start = first + float(np.remainder(frame.zero - first, 2.0 * np.pi))
    near = scan.states[int(np.argmin(np.abs(scan.coordinate - start)))]
    drive = Drive(frame.sense * machine.speed, start, near, revolutions, RIPPLE, most_samples)
    driven = {order.label: one for order, one in zip(orders, run(drive, tuple(orders)), strict=True)}
    others = other_branches(machine) if isinstance(moving, Scene) else (machine,)
    to = RunReference(moving, machine.speed, others, frame, points, scan.facts.touching is not None)
    runs = {label: judged(label, one, to) for label, one in driven.items()}
    both = [runs[label] for label in (OWN, EXACT_SOLVER) if label in runs and runs[label].errors is not None]
    share = difference(driven[OWN], driven[EXACT_SOLVER], to) if len(both) == 2 else None
    return replace(found, runs=runs, refused=refused, drive_share=share)


def _orders(scene: Scene, scan: Scan, engine: Engine[Any]) -> tuple[list[Order], dict[str, str]]:
    """The model as it is, the same with an exact solver, and with the settings of each preset at its own step."""
    own = scan.facts.settings
    steps = max(2, round(scene.period / own.timestep))
    orders, refused = [Order(OWN)], dict[str, str]()
    if own.tolerance != 0.0:
        orders.append(Order(EXACT_SOLVER, tolerance=0.0))
    for preset in PRESETS:
        settings = engine.presets[preset](scene, steps)
        reason = engine.refusal(scene, settings)
        if reason is None:
            orders.append(Order(preset, settings))
        else:
            refused[preset] = reason
    return orders, refused
