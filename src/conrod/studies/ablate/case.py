"""Cases of a study of ingredients: how much a variant's motion differs from another one's, and its cost over it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

from conrod.engines import engine_named
from conrod.engines.capabilities import HasIngredients, required
from conrod.runs.plain import plain
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import Scene
from conrod.studies.ablate.deviations import Observed, observe
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.paired_timing import ROUNDS, time_pair
from conrod.studies.frame.run import RunCase, as_run, too_coarse

# Raised when what is kept of the same run comes out otherwise, or means something else, than before.
CHANGE_VERSION, COST_VERSION = 1, 1
COUNTED = 36  # crank angles of a turn at which a compiled model's constraints are counted


@dataclass(frozen=True)
class ChangeCase(RunCase):
    """A run, measured by how much it differs from another one.

    Attributes:
        against: settings of the other one.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)

    def perform(self) -> Measurement:
        return measure_change(self)

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"change": CHANGE_VERSION, "against": _identifying(self.against)}


@dataclass(frozen=True)
class CostCase(RunCase):
    """The cost of a revolution over that with other settings; see `conrod.studies.frame.paired_timing`.

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

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        paired = {"cost": COST_VERSION, "machine": self.machine, "rounds": self.rounds}
        return super()._identity(parameters) | paired | {"against": _identifying(self.against)}


def _identifying(settings: Settings) -> dict[str, Any]:
    return {key: value for key, value in settings.as_dict().items() if key != "preset"}


def measure_change(case: ChangeCase) -> Measurement:
    """The motion of a case, by how much it differs from that of what it is compared with, and its constraints.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine, scene, case = engine_named(case.settings.engine), case.scene, as_run(case)
    refusal = engine.refusal(scene, case.settings) or too_coarse(case)
    if refusal:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    turn = scene.kinematics.angles(COUNTED)
    count = required(engine, HasIngredients).mobility(scene, case.settings, turn)
    beside: dict[str, Any] = {"mobility": _named_rows(asdict(count))}
    settings: Any = case.settings  # settings of all engines are hashable, which their protocol cannot say
    against: Any = case.against
    run = _observed(scene, settings, case.revolutions, case.start_angle)
    if not run.completed:
        return Measurement(run.verdict.outcome.slug, run.verdict.reason, beside=beside)
    # A pass takes whole steps, whose length is that of the other settings.
    other_case = as_run(replace(case, settings=against))
    other = _observed(scene, against, other_case.revolutions, other_case.start_angle)
    beside |= {"torque": run.torque_error, **_changes(run, other)}
    return Measurement(run.verdict.outcome.slug, errors=run.errors, beside=beside)


def measure_cost(case: CostCase) -> Measurement:
    """The cost of a case over what it is compared with."""
    timing = time_pair(engine_named(case.settings.engine), case.scene, case.settings, case.against, rounds=case.rounds)
    return Measurement(Outcome.COMPLETED.slug, beside={"paired": plain(timing)})


# Of the models that others are compared with there are two, and a process meets many of those others.
@lru_cache(3)
def _observed(scene: Scene, settings: Settings, revolutions: float, start_angle: float) -> Observed:
    return observe(scene, settings, revolutions, start_angle)


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


def _named_rows(count: Mapping[str, Any]) -> dict[str, Any]:
    """A count with its rows as texts."""
    empty = [f"{row['constraint']} {row['part']}".rstrip() for row in count["empty"]]
    return {**count, "empty": empty, "redundant": dict(count["redundant"])}
