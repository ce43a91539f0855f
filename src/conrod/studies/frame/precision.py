"""Tolerances that a run's numbers cannot tell: an engine in single precision rounds its state at every step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from conrod.engines import Engine
from conrod.engines.engine import DOUBLE
from conrod.engines.numerics import largest_derivatives
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES

ROUNDED_UP = 1.05  # by which what is printed in two digits is never less


def error_floor(scene: Scene, spacing: float) -> dict[str, float]:
    """Normalised errors that rounding alone leaves, by quantity: the spacing of numbers times the largest of them."""
    position, *rates = (spacing * size for size in largest_derivatives(scene.kinematics, len(QUANTITIES) - 1))
    return dict(zip((*QUANTITIES, "total"), (position, *rates, position), strict=True))


def check_precision(
    name: str, scene: Scene, engine: Engine[Any], settings: Iterable[Any], asked: Mapping[str, float] | None
) -> None:
    """Refuse tolerances that the engine's numbers cannot tell.

    Nothing is refused of numbers in double precision: there a run shows what can be met.

    Args:
        name: of the scene.
        settings: of which one has to be able to meet them.

    Raises:
        InvalidInput: none is, with the least tolerance that can be told.
    """
    spacing = min(engine.spacing(one) for one in settings)
    if spacing <= DOUBLE or not asked:
        return
    for quantity, least in error_floor(scene, spacing).items():
        if asked.get(quantity, least) < least:
            raise InvalidInput(
                f"{quantity} = {asked[quantity]:g} cannot be told by {engine.name} on {name}, in single precision: "
                f"ask for {ROUNDED_UP * least:.2g} or more, or name an engine or a preset in double precision"
            )
