"""Parts of a space that the motion does not need, or that it cannot do without: edits by name, see `MODEL_EDITS`.

The two edits of rods are not here, but in `distance_rods`: the space is built with them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

from conrod.engines.engine import DeferredLibrary
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.space import PymunkSpace
from conrod.mechanism.mechanism import Body, Mechanism, Point, pin_points

if TYPE_CHECKING:
    import pymunk
else:
    pymunk = DeferredLibrary("pymunk")

SHAPE_WIDTH = 0.05  # half of a link's shape, over the largest coordinate of a body in the start pose


@cache
def constraint_fields() -> Mapping[type[Any], tuple[str, ...]]:
    """Map each type of constraint to the names of its fields, except its two bodies."""
    return {
        pymunk.PivotJoint: ("anchor_a", "anchor_b"),
        pymunk.PinJoint: ("anchor_a", "anchor_b"),
        pymunk.GrooveJoint: ("groove_a", "groove_b", "anchor_b"),
        pymunk.GearJoint: ("phase", "ratio"),
    }


def open_loop(made: PymunkSpace) -> None:
    """Remove the joints that close loops: distance joints of rods, else the last pin."""
    rods = [one for one in made.names if isinstance(one, pymunk.PinJoint)]
    pins = [one for one in made.names if isinstance(one, pymunk.PivotJoint)]
    for constraint in rods or pins[-1:]:
        made.space.remove(constraint)
        del made.names[constraint]


def remove_contact(made: PymunkSpace) -> None:
    """Remove the shapes of cam and roller, so that they pass through each other."""
    made.space.remove(*made.space.shapes)


def duplicate_joints(made: PymunkSpace) -> None:
    """Add a copy of every joint."""
    for constraint, name in list(made.names.items()):
        kind: type[Any] = type(constraint)
        parts = (getattr(constraint, part) for part in constraint_fields()[kind])
        again = kind(constraint.a, constraint.b, *parts)
        if isinstance(constraint, pymunk.PinJoint):
            again.distance = constraint.distance
        again.error_bias, again.collide_bodies = constraint.error_bias, constraint.collide_bodies
        made.add_constraint(f"{name} again", again)


def add_filtered_shapes(made: PymunkSpace) -> None:
    """Add a shape to every link that a filter keeps from colliding with anything."""
    for shape in _add_link_shapes(made):
        shape.filter = pymunk.ShapeFilter(mask=0)


def add_touching_shapes(made: PymunkSpace) -> None:
    """Add a shape to every link; shapes of jointed links collide, too, which is pymunk's default."""
    _add_link_shapes(made)
    for constraint in made.names:
        constraint.collide_bodies = True


def _add_link_shapes(made: PymunkSpace) -> list[pymunk.Shape]:
    """Add a rectangle around the pins of every link."""
    size = max(max(abs(x), abs(y)) for x, y, _ in made.whole.poses.values()) or 1.0
    shapes: list[pymunk.Shape] = []
    for link in made.mechanism.bodies:
        corners = [made.to_body_frame(link.name, corner) for corner in outline(made.whole, link, SHAPE_WIDTH * size)]
        shapes.append(pymunk.Poly(made.body_of(link.name), corners))
    made.space.add(*shapes)
    return shapes


def outline(mechanism: Mechanism, link: Body, width: float) -> list[Point]:
    """Corners [m] of a rectangle around the outermost pins of a link, `width` [m] beyond them, in the link's frame."""
    pins = pin_points(mechanism, link.name) or [link.centre_of_gravity]
    first, last = min(pins), max(pins)
    turn = math.atan2(last[1] - first[1], last[0] - first[0])
    along, across = ((width * math.cos(a), width * math.sin(a)) for a in (turn, turn + 0.5 * math.pi))
    sides = ((first, -1.0, -1.0), (last, 1.0, -1.0), (last, 1.0, 1.0), (first, -1.0, 1.0))
    return [(pin[0] + u * along[0] + v * across[0], pin[1] + u * along[1] + v * across[1]) for pin, u, v in sides]


Edit: TypeAlias = Callable[[PymunkSpace], None]
# Applied in this order: what is gone is not doubled, and links' shapes stay where the cam's go.
EDITS: Mapping[str, Edit] = {
    "open-loop": open_loop,
    "no-contact": remove_contact,
    "redundant-joints": duplicate_joints,
    "filtered-shapes": add_filtered_shapes,
    "touching-shapes": add_touching_shapes,
}


def apply_edits(made: PymunkSpace, settings: PymunkSettings) -> None:
    """Apply the edits that the settings name to a complete space."""
    for name, edit in EDITS.items():
        if name in settings.dressing:
            edit(made)
