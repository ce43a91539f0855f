"""Names of what a pymunk model may carry beside what it needs, or lack of what it needs. Imports no engine."""

from __future__ import annotations

from collections.abc import Iterable

from conrod.errors import unknown_choice

OPEN_LOOP = "open-loop"
REDUNDANT_JOINTS = "redundant-joints"
SLEEPING = "sleeping"
DAMPING = "damping"
# Shapes on the links, of which a model has one kind.
SHAPES_COLLIDING = "shapes-colliding"
SHAPES_UNFILTERED = "shapes-unfiltered"
SHAPES_SENSOR = "shapes-sensor"
SHAPES_MASKED = "shapes-masked"
SHAPES_POLYGONS = "shapes-polygons"
SHAPES_GROUPED = "shapes-grouped"
SHAPES = (SHAPES_COLLIDING, SHAPES_UNFILTERED, SHAPES_SENSOR, SHAPES_MASKED, SHAPES_POLYGONS, SHAPES_GROUPED)
# Steps of the space for each one that is recorded.
SUBSTEPS = {"substeps-2": 2, "substeps-10": 10}

# Each is done in this order, after the model is built; settings hold them in it, so that equal models are equal.
NAMES = (OPEN_LOOP, REDUNDANT_JOINTS, *SHAPES, SLEEPING, DAMPING, *SUBSTEPS)


def in_order(names: Iterable[str]) -> tuple[str, ...]:
    """The names, each once, in the order of `NAMES`.

    Raises:
        InvalidInput: a name is none of them.
    """
    given = set(names)
    for name in sorted(given):
        if name not in NAMES:
            raise unknown_choice("dressing", name, NAMES)
    return tuple(name for name in NAMES if name in given)
