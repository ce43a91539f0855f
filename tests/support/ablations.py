"""Studies of ingredients made by hand, and ingredients made up for a real engine."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from conrod import MuJoCoSettings
from conrod.engines import Engine, engine_named
from conrod.engines.variants import Ingredient, Quantity
from conrod.studies.ablate.findings import (
    JUDGED,
    AblationStudy,
    EngineAblation,
    Evidence,
    IngredientResult,
    Role,
    VariantResult,
    evidence_of,
    levels,
    verdict,
)
from conrod.studies.frame.paired_timing import PairedTiming

SCENE = "saw-500rpm"
MINIMAL_ERROR = 4e-11


def timing(ratio: float, half: float = 0.01) -> PairedTiming:
    """A ratio with an interval of so much on both sides."""
    return PairedTiming(ratio, ratio - half, ratio + half, 0.02 * ratio, 0.02, 200)


def variant(
    role: Role,
    ingredient: str = "",
    error: float | None = MINIMAL_ERROR,
    change: float = 0.0,
    cost: float | None = 1.0,
    **others: Any,
) -> VariantResult:
    """A model whose errors are all of one size; one without an error did not complete."""
    completed = error is not None
    made = VariantResult(
        role=role,
        ingredient=ingredient,
        outcome="completed" if completed else "opened",
        reason="" if completed else "a gap of 0.4 m",
        errors=dict.fromkeys(JUDGED, error) if error is not None else None,
        change=dict.fromkeys(JUDGED[:3], change) if completed else None,
        cost=None if cost is None or not completed else timing(cost),
        cost_in_full=None,
        settings={"timestep": 1e-3},
    )
    return replace(made, **others)


MINIMAL = variant(Role.MINIMAL)


def alone(error: float | None, change: float, cost: float | None) -> Evidence:
    """What an ingredient shows that makes the minimal model like this."""
    added = variant(Role.ADDED, "it", error, change, cost)
    return evidence_of(added, MINIMAL, levels(MINIMAL))


def ingredient(name: str, evidence: tuple[Evidence, ...], *, minimal: bool = False, **others: Any) -> IngredientResult:
    """An ingredient with the verdict that follows."""
    found, because = verdict(evidence)
    made = IngredientResult(
        name=name,
        meaning=f"what {name} is",
        minimal=minimal,
        needed_by=(),
        verdict=found,
        because=because,
        evidence=evidence,
    )
    return replace(made, **others)


def engine_study(engine: str = "mujoco", version: str = "1.2.3") -> EngineAblation:
    """One ingredient of each kind."""
    dressed = variant(Role.FULL, change=3e-11, cost=1.8)
    models = (
        MINIMAL,
        variant(Role.ADDED, "looks"),
        variant(Role.ADDED, "sensors", cost=1.2),
        variant(Role.ADDED, "noslip", 1e-6, 1e-6, 1.1),
        variant(Role.REDUCED, "closure", None),
        dressed,
        variant(Role.TAKEN, "sensors", cost=1.5, cost_in_full=timing(1.3).inverse),
    )
    level = levels(MINIMAL)
    costly = evidence_of(models[6], dressed, level)
    required = evidence_of(models[4], MINIMAL, level)
    found = (
        ingredient("looks", (alone(MINIMAL_ERROR, 0.0, 1.0),), needed_by=("impact",)),
        ingredient("sensors", (alone(MINIMAL_ERROR, 0.0, 1.2), costly)),
        ingredient("noslip", (alone(1e-6, 1e-6, 1.1),), needed_by=("wear",)),
        ingredient("closure", (required,), minimal=True, needed_by=("drive torque", "joint reactions")),
    )
    return EngineAblation(engine, version, 1000, 2.0, "a processor, 2 cores", found, models)


def ablation_study(*engines: EngineAblation, **others: Any) -> AblationStudy:
    """A study of the saw."""
    made = AblationStudy(SCENE, "saw", "A saw", {"crank": 0.1, "rod": 0.4}, engines or (engine_study(),), {})
    return replace(made, **others)


# -- made up for a real engine ---------------------------------------------------------------------------------------


def field_ingredient(
    name: str, values: dict[str, Any], without: dict[str, Any], *, minimal: bool = False
) -> Ingredient[MuJoCoSettings]:
    """An ingredient that is a value of some fields; without it they have another one."""
    ways = [partial(_with_fields, fields) for fields in (values, without)]
    return Ingredient(name, f"what {name} is", ways[0], ways[1], (Quantity.WEAR,), minimal)


def _with_fields(fields: dict[str, Any], settings: MuJoCoSettings) -> MuJoCoSettings:
    return replace(settings, preset="custom", **fields)


@dataclass
class Planted:
    """A real engine with ingredients that were made up."""

    planted: tuple[Ingredient[Any], ...]
    base: Any  # (machine, steps) -> settings
    name: str = "mujoco"

    @property
    def version(self) -> str:
        return self.real.version

    @property
    def real(self) -> Engine[Any]:
        return engine_named(self.name)

    def minimal(self, machine: Any, steps_per_revolution: int) -> Any:
        return self.base(machine, steps_per_revolution)

    def ingredients(self, machine: Any, minimal: Any) -> tuple[Ingredient[Any], ...]:
        return self.planted
