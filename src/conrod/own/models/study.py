"""All that is found of a user's model, and the verdict on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from conrod.exact.reference import ExactReference, GenericReference
from conrod.own.models.frame import GivenFrame
from conrod.own.models.identity import DEFAULT_TOLERANCE, Identity, identify
from conrod.own.models.references import other_branches
from conrod.own.models.request import Drive, DrivenRun, Order, Question, Scan
from conrod.own.models.runs import JudgedRun, Reference, difference, judged
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
        tolerance: asked for, by quantity; None for the default of kinematic mode alone.
        runs: dynamic mode by label; empty where the model is too far off the machine.
        refused: presets that were not run, with the reason.
        drive_share: what the drive changes by the solver's tolerance, by quantity; None where it was not told.
        points: that the runs are compared at.
    """

    file: str
    scene_name: str
    scene: Scene
    question: Question
    scan: Scan
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
        """Whether the paths are the machine's."""
        return self.identity.is_machine(self.kinematic_tolerance)

    @property
    def own(self) -> JudgedRun | None:
        """The run that stands for the model's own settings: with what the drive changes taken away, if it completed."""
        exact, own = self.runs.get(EXACT_SOLVER), self.runs.get(OWN)
        return exact if exact is not None and exact.outcome is Outcome.COMPLETED else own

    def exceeded(self) -> dict[str, tuple[float, float]]:
        """Quantities that are out of the tolerance asked for: found and allowed."""
        own, over = self.own, dict[str, tuple[float, float]]()
        if own is None or own.errors is None:
            return over
        for name, allowed in (self.tolerance or {}).items():
            quantity, _, measure = name.partition("_")
            found = own.worst(quantity, measure or "max")
            if found is not None and found > allowed:
                over[name] = (found, allowed)
        return over

    @property
    def passed(self) -> bool:
        """Whether it is the machine, may turn, and its own settings carry it through the run as asked for."""
        own = self.own
        if not self.is_machine or self.scan.stops or own is None:
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
        InvalidInput: its plane of motion or its frame cannot be told, or its runs cannot be made.
    """
    name, machine = scene
    identity = identify(machine, scan, given)
    points = _points(identity)
    found = ModelStudy(file, name, machine, question, scan, identity, tolerance, revolutions, {}, {}, None, points)
    if identity.left > COMPARABLE:
        return found
    orders, refused = _orders(machine, scan, engine)
    driven = dict(
        zip(
            orders, run(_drive(identity, machine, scan, revolutions, most_samples), tuple(orders.values())), strict=True
        )
    )
    to = _reference(identity, machine)
    runs = {label: judged(label, one, identity.frame, points, scan, to) for label, one in driven.items()}
    share = None
    if EXACT_SOLVER in runs and all(runs[label].errors is not None for label in (OWN, EXACT_SOLVER)):
        share = difference(driven[OWN], driven[EXACT_SOLVER], identity.frame, points, to)
    return replace(found, runs=runs, refused=refused, drive_share=share)


def _points(identity: Identity) -> tuple[str, ...]:
    """Points that are where they should be on their links; all, where none is."""
    every = tuple(identity.off_by)
    wrong = {m.point for m in identity.closest.misplaced} if identity.explanations and identity.closest else set()
    return tuple(p for p in every if p not in wrong) or every


def _orders(scene: Scene, scan: Scan, engine: Engine[Any]) -> tuple[dict[str, Order], dict[str, str]]:
    """The model as it is, the same with an exact solver, and with the settings of each preset at its own step."""
    steps = max(2, round(scene.period / scan.settings.timestep))
    orders, refused = {OWN: Order(OWN)}, dict[str, str]()
    if scan.settings.tolerance != 0.0:
        orders[EXACT_SOLVER] = Order(EXACT_SOLVER, tolerance=0.0)
    for preset in PRESETS:
        settings = engine.presets[preset](scene, steps)
        reason = engine.refusal(scene, settings)
        if reason is None:
            orders[preset] = Order(preset, settings)
        else:
            refused[preset] = reason
    return orders, refused


def _drive(identity: Identity, scene: Scene, scan: Scan, revolutions: float, most_samples: int) -> Drive:
    """From crank angle 0, at the scene's speed."""
    frame, first = identity.frame, float(scan.coordinate[0])
    start = first + float(np.remainder(frame.zero - first, 2.0 * np.pi))
    near = int(np.argmin(np.abs(scan.coordinate - start)))
    rate = frame.sense * scene.speed
    return Drive(rate, start, scan.states[near], revolutions, RIPPLE, most_samples)


def _reference(identity: Identity, scene: Scene) -> Reference:
    """The machine that the model is, with the lengths that were found, on its branch."""
    contacts = scene.kinematics.mechanism.cam_contacts
    ruler: ExactReference = identity.scene
    others = other_branches(scene)
    if identity.reference is not None:
        ruler, others = GenericReference(identity.reference.mechanism, scene.speed), (scene.kinematics,)
    return Reference(ruler, scene.speed, scene.kinematics.size, contacts[0].roller_radius if contacts else None, others)
