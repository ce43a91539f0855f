"""Why a model is not, or does not move as, a planar machine that it is to be: tilted axes, and links that differ."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint, SpatialTree
from conrod.exact.space.poses import poses
from conrod.mjcf.loops.reading import tree_of
from conrod.own.models.links import differences, graph_of
from conrod.own.models.loading import data_at_start, find_point
from conrod.own.models.model_links import links_of
from conrod.own.models.request import Place, Question
from conrod.scenes import Scene

PARALLEL = 1e-6  # [rad]: numbers of a file with six digits
TOLD = 3  # differences that are named


def scene_causes(model: mujoco.MjModel, scene: tuple[str, Scene], question: Question) -> Iterator[str]:
    """Name what a model has otherwise than a planar machine, by its axes and links, however it moves.

    Args:
        scene: name of the machine and itself.
    """
    name, machine = scene
    try:
        tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
        points = {place.point: _point(model, place) for place in question.places}
    except InvalidInput:  # which is what the study says
        return
    if question.crank not in {joint.name for joint in tree.joints}:
        return
    yield from tilted_axes(tree)
    own, right = links_of(tree, question.crank, points), graph_of(machine.mechanism())
    if own is None or right is None:
        return
    if found := differences(own, right):
        more = [f"{len(found) - TOLD} more distances differ"] if len(found) > TOLD else []
        yield f"against {name}, {'; '.join([*(one.words for one in found[:TOLD]), *more])}"


def _point(model: mujoco.MjModel, place: Place) -> SpatialPoint:
    found = find_point(model, place)
    offsets = {"site": model.site_pos, "geom": model.geom_pos}
    return SpatialPoint(found.body, offsets[found.kind][found.index].copy() if found.kind in offsets else np.zeros(3))


def tilted_axes(tree: SpatialTree) -> Iterator[str]:
    """Name hinges of loops that are not along the axis that most are along, and slides that are not across it."""
    found = poses(tree, tree.start[:, None])
    axes = {joint.name: found.axes[joint.rate][:, 0, 0] for joint in tree.looped if joint.kind in ("hinge", "slide")}
    hinges = {joint.name: axes[joint.name] for joint in tree.looped if joint.kind == "hinge"}
    if not hinges:
        return
    most = max(hinges, key=lambda name: sum(_between(hinges[name], other) <= PARALLEL for other in hinges.values()))
    for joint in tree.looped:
        if joint.kind == "hinge" and (tilt := _between(axes[joint.name], axes[most])) > PARALLEL:
            yield f"the axis of {joint.name} is {np.degrees(tilt):.3g} deg off that of {most}"
        elif joint.kind == "slide" and (tilt := np.pi / 2.0 - _between(axes[joint.name], axes[most])) > PARALLEL:
            yield f"the axis of {joint.name} is {np.degrees(tilt):.3g} deg off the plane across that of {most}"


def _between(one: Array, other: Array) -> float:
    """Angle between two lines [rad], from 0 to a quarter turn."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), abs(one @ other)))
