"""Runs of a study of ingredients: what a variant's motion differs by, and what it costs over another one.

What an executor does with a cell of a study of ingredients; importable, so that any worker process can.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

from conrod.engines import engine_named
from conrod.engines.capabilities import HasIngredients, required
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import Scene
from conrod.studies.ablate.observed import Observed, observe
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.paired_timing import ROUNDS, time_pair
from conrod.studies.frame.run import RunCase, as_run, too_coarse

# Raised when what is kept of the same run comes out otherwise, or means something else, than before.
CHANGE_VERSION, COST_VERSION = 1, 1


def _plain(settings: Settings) -> dict[str, Any]:
    values = settings.as_dict()
    del values["preset"]
    return values


@dataclass(frozen=True)
class ChangeCell(RunCase):
    """A run of which it is kept by how much it differs from another one; see `change`.

    Attributes:
        against: settings of the other one.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)

    def perform(self) -> Measurement:
        return measure_change(self)

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"change": CHANGE_VERSION, "against": _plain(self.against)}


@dataclass(frozen=True)
class CostCell(RunCase):
    """What a revolution costs over one with other settings; see `conrod.studies.frame.paired_timing`.

    Attributes:
        against: the other settings.
        machine: fingerprint of the machine that it is timed on: figures of different machines do not mix.
        rounds: how often both are timed.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)
    machine: str = field(kw_only=True)
    rounds: int = field(kw_only=True, default=ROUNDS)

    def perform(self) -> Measurement:
        return measure_cost(self)

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        paired = {"cost": COST_VERSION, "machine": self.machine, "rounds": self.rounds}
        return super()._identity(parameters) | paired | {"against": _plain(self.against)}


# Crank angles of a turn at which a compiled model's constraints are counted.
COUNTED = 36


def measure_change(cell: ChangeCell) -> Measurement:
    """The motion of a cell, by how much it differs from that of what it is compared with, and its constraints.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine, scene, cell = engine_named(cell.settings.engine), cell.scene, as_run(cell)
    refusal = engine.refusal(scene, cell.settings) or too_coarse(cell)
    if refusal:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    turn = scene.kinematics.angles(COUNTED)
    count = required(engine, HasIngredients).mobility(scene, cell.settings, turn)
    beside: dict[str, Any] = {"mobility": _plain_result(asdict(count))}
    settings: Any = cell.settings  # settings of all engines are hashable, which their protocol cannot say
    against: Any = cell.against
    run = _observed(scene, settings, cell.revolutions, cell.start_angle)
    if not run.completed:
        return Measurement(run.verdict.outcome.slug, run.verdict.reason, beside=beside)
    other = _observed(scene, against, *_stretch(cell, against))
    beside |= {"torque": run.torque_error, **_changes(run, other)}
    return Measurement(run.verdict.outcome.slug, errors=run.errors, beside=beside)


def measure_cost(cell: CostCell) -> Measurement:
    """What a cell costs over what it is compared with."""
    timing = time_pair(engine_named(cell.settings.engine), cell.scene, cell.settings, cell.against, rounds=cell.rounds)
    return Measurement(Outcome.COMPLETED.slug, beside={"paired": timing.as_dict()})


# Of the models that others are compared with there are two, and a process meets many of those others.
@lru_cache(3)
def _observed(scene: Scene, settings: Settings, revolutions: float, start_angle: float) -> Observed:
    return observe(scene, settings, revolutions, start_angle)


def _stretch(cell: ChangeCell, settings: Settings) -> tuple[float, float]:
    """Revolutions and start angle [rad] with other settings: a pass takes whole steps, whose length is theirs."""
    run = as_run(replace(cell, settings=settings))
    return run.revolutions, run.start_angle


def _changes(run: Observed, other: Observed) -> dict[str, Any]:
    """Largest differences of the observed points, and of the drive torque; None where there is nothing to compare."""
    if not other.completed:
        return {"change": None, "torque_change": None}
    torques = None if run.torque is None or other.torque is None else (run.torque, other.torque)
    return {
        "change": {
            quantity: max(run.motion[point][quantity].difference(other.motion[point][quantity]) for point in run.motion)
            for quantity in QUANTITIES
        },
        "torque_change": None if torques is None else torques[0].difference(torques[1]),
    }


def _plain_result(count: Mapping[str, Any]) -> dict[str, Any]:
    """A count with its rows as texts."""
    empty = [f"{row['constraint']} {row['part']}".rstrip() for row in count["empty"]]
    return {**count, "empty": empty, "redundant": dict(count["redundant"])}
