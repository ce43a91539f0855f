"""Edits of a built space beside what its motion needs, one for each name."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np
import pymunk

from conrod.engines.pymunk.built import Build
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.mechanism.mechanism import Body, Mechanism, Point, pins_of

THICKNESS = 0.05  # of a link's shape, against the mechanism's size
FEW_VERTICES, MANY_VERTICES = 4, 200  # Chipmunk's cached vertex numbers have eight bits
SLEEP_AFTER = 0.5  # [s], what the pymunk manual's examples use
KEPT_SPEED = 0.9  # share of a velocity that is left after a second
GROUP = 1

# What a constraint is made of, beside its two bodies.
MADE_OF: Mapping[type[Any], tuple[str, ...]] = {
    pymunk.PivotJoint: ("anchor_a", "anchor_b"),
    pymunk.PinJoint: ("anchor_a", "anchor_b"),
    pymunk.GrooveJoint: ("groove_a", "groove_b", "anchor_b"),
    pymunk.GearJoint: ("phase", "ratio"),
}
Edit: TypeAlias = Callable[[Build], object]


def dress(made: Build, settings: PymunkSettings) -> None:
    """Do what the settings' dressing says to a built space, in place; sub-steps are taken by who steps it."""
    for name in settings.dressing:
        if name in EDITS:
            EDITS[name](made)


def _open_loop(made: Build) -> None:
    """Without what closes the loop: the rod as a distance joint, else the last pin; of a cam its contact."""
    last_first = sorted(made.names, key=lambda c: isinstance(c, pymunk.PinJoint))[::-1]
    pins = [c for c in last_first if isinstance(c, (pymunk.PinJoint, pymunk.PivotJoint))]
    if pins:
        made.space.remove(pins[0])
        del made.names[pins[0]]
    else:
        made.space.remove(*made.space.shapes)


def _redundant_joints(made: Build) -> None:
    """Every joint a second time."""
    for constraint, name in list(made.names.items()):
        kind: type[Any] = type(constraint)
        again = kind(constraint.a, constraint.b, *(getattr(constraint, part) for part in MADE_OF[kind]))
        if isinstance(again, pymunk.PinJoint):
            again.distance = constraint.distance
        again.error_bias, again.collide_bodies = constraint.error_bias, constraint.collide_bodies
        made.hold(f"{name} again", again)


# -- shapes on the links ---------------------------------------------------------------------------------------------


def _colliding(made: Build) -> None:
    """Pymunk's default: shapes of links that a joint holds together collide."""
    _add_shapes(made)
    for constraint in made.names:
        constraint.collide_bodies = True


def _shapes(vertices: int = FEW_VERTICES, sensor: bool = False, **filtered: int) -> Edit:
    """Shapes that find overlaps alone, or that a filter keeps from colliding."""

    def edit(made: Build) -> None:
        for shape in _add_shapes(made, vertices):
            shape.sensor, shape.filter = sensor, pymunk.ShapeFilter(**filtered)

    return edit


def _add_shapes(made: Build, vertices: int = FEW_VERTICES) -> list[pymunk.Shape]:
    """A polygon on every link."""
    width = THICKNESS * max(max(abs(x), abs(y)) for x, y, _ in made.mechanism.poses.values())
    shapes = []
    for link in made.mechanism.bodies:
        corners = [made.local(link.name, point) for point in outline(made.mechanism, link, width, vertices)]
        shapes.append(pymunk.Poly(made.link(link.name), corners))
    made.space.add(*shapes)
    return list[pymunk.Shape](shapes)


def outline(mechanism: Mechanism, link: Body, width: float, vertices: int) -> list[Point]:
    """An oval around the pins of a link, or around its only one, in its own frame; of so many vertices."""
    pins = pins_of(mechanism, link.name) or [link.centre_of_gravity]
    first, last = min(pins), max(pins)
    middle = 0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1])
    half, turn = 0.5 * math.dist(first, last) + width, math.atan2(last[1] - first[1], last[0] - first[0])
    corners = []
    for direction in 2.0 * math.pi * (np.arange(vertices) + 0.5) / vertices:
        along, across = half * math.cos(direction), width * math.sin(direction)
        x = middle[0] + along * math.cos(turn) - across * math.sin(turn)
        corners.append((x, middle[1] + along * math.sin(turn) + across * math.cos(turn)))
    return corners


EDITS: Mapping[str, Edit] = {
    "open-loop": _open_loop,
    "redundant-joints": _redundant_joints,
    "shapes-colliding": _colliding,
    "shapes-unfiltered": _shapes(),
    "shapes-sensor": _shapes(sensor=True),
    "shapes-masked": _shapes(mask=0),
    "shapes-polygons": _shapes(MANY_VERTICES, group=GROUP),
    "shapes-grouped": _shapes(group=GROUP),
    "sleeping": lambda made: setattr(made.space, "sleep_time_threshold", SLEEP_AFTER),
    "damping": lambda made: setattr(made.space, "damping", KEPT_SPEED),
}
