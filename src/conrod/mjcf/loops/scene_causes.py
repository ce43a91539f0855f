"""Why a model is not, or does not move as, a planar machine that it is to be: tilted axes, and links that differ."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint, SpatialTree
from conrod.exact.space.poses import poses
from conrod.mechanism.mechanism import GROUND, Prismatic
from conrod.mjcf.loops.reading import tree_of
from conrod.own.models.frame import Frame, GivenFrame
from conrod.own.models.identity import COARSE_GRID, Identity
from conrod.own.models.links import LinkDifference, SlideTilt, differences, graph_of
from conrod.own.models.loading import data_at_start, find_point
from conrod.own.models.model_links import links_of
from conrod.own.models.request import Place, Question
from conrod.scenes import Scene

PARALLEL = 1e-6  # [rad]: numbers of a file with six digits
TOLD = 3  # differences that are named
ROUND = float(COARSE_GRID)  # [rad]: a model is turned by so much on purpose


def scene_causes(model: mujoco.MjModel, scene: tuple[str, Scene], question: Question) -> Iterator[str]:
    """Name what a model has otherwise than a planar machine, by its axes and links, however it moves.

    Args:
        scene: name of the machine and itself.
    """
    name, machine = scene
    try:
        yield from tilted_axes(tree_of(model, data_at_start(model, question.keyframe)[0].qpos))
    except InvalidInput:  # which is what the study says
        return
    if found := _link_differences(model, machine, question):
        more = [f"{len(found) - TOLD} more distances differ"] if len(found) > TOLD else []
        yield f"against {name}, {'; '.join([*(one.words for one in found[:TOLD]), *more])}"


def causes_besides(
    model: mujoco.MjModel, scene: tuple[str, Scene], question: Question, identity: Identity, given: GivenFrame
) -> Iterator[str]:
    """Name what else would explain a model that is not the machine, or what does where no lengths do.

    A slider-crank's offset and a tilt of its slide are the same machine seen in frames that are turned: which of both
    it is shows in a frame that is given, or is round.
    """
    tilt = _slide_tilt(model, scene[1], question, identity.frame)
    if identity.explanations:
        links = _link_differences(model, scene[1], question)
        ground = {joint.name for joint in scene[1].mechanism().joints if _on_ground(joint)}
        turned = identity.frame.rotation - ROUND * round(identity.frame.rotation / ROUND)
        of_slide = links and all(isinstance(one, LinkDifference) and one.link in ground for one in links)
        if links and of_slide and given.rotation is None and abs(turned) > PARALLEL:
            said = f"the slide is tilted by {np.degrees(abs(turned)):.3g} deg"
            yield f"it may be as well that {said}: --rotation tells both apart"
    elif not identity.other_branch:
        yield from scene_causes(model, scene, question)
        if given.rotation is not None and tilt is not None and abs(tilt) > PARALLEL:
            yield f"the slide is tilted by {np.degrees(abs(tilt)):.3g} deg from where --rotation has it"


def _on_ground(joint: object) -> bool:
    return isinstance(joint, Prismatic) and GROUND in (joint.a, joint.b)


def _slide_tilt(model: mujoco.MjModel, machine: Scene, question: Question, frame: Frame) -> float | None:
    """Angle [rad] of the one slide on the ground from the machine's, in a frame; None where there are others."""
    tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
    slides = [joint for joint in tree.looped if joint.kind == "slide" and tree.bodies[joint.body].parent == 0]
    right = [joint for joint in machine.mechanism().joints if isinstance(joint, Prismatic) and _on_ground(joint)]
    if len(slides) != 1 or len(right) != 1:
        return None
    axis = poses(tree, tree.start[:, None]).axes[slides[0].rate][:, 0, 0]
    way = np.angle(frame.view.flat(axis[None])[0]) - frame.rotation
    return float(np.angle(np.exp(2j * (way - right[0].direction)))) / 2.0


def _link_differences(
    model: mujoco.MjModel, machine: Scene, question: Question
) -> tuple[LinkDifference | SlideTilt, ...] | None:
    """Differences of links, pins and slides; None where they are other ones, or cannot be known."""
    try:
        tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
        points = {place.point: _point(model, place) for place in question.places}
    except InvalidInput:  # which is what the study says
        return None
    if question.crank not in {joint.name for joint in tree.joints}:
        return None
    own, right = links_of(tree, question.crank, points), graph_of(machine.mechanism())
    return None if own is None or right is None else differences(own, right)


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
