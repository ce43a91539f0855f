"""Why a model is not the planar machine that it is to be, or does not move as it: tilted axes, other links."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint, SpatialTree
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.mechanism.mechanism import GROUND, Prismatic, Revolute
from conrod.mjcf.causes import describe_closures
from conrod.mjcf.differences import COUPLINGS, NUMBER_TOLERANCE
from conrod.mjcf.loading import data_at_start, find_point
from conrod.mjcf.reading import tree_of
from conrod.mjcf.request import ModelRequest, PointPlace
from conrod.models.check.frame import Frame, GivenFrame
from conrod.models.check.identity import COARSE_GRID, Identity
from conrod.models.check.links import LinkDifference, SlideTilt, graph_of, link_differences
from conrod.models.check.model_links import links_of
from conrod.scenes import Scene

PARALLEL = 1e-6  # [rad]: numbers of a file with six digits
MAX_NAMED_DIFFERENCES = 3  # differences that are named
ROUND_ANGLE = float(COARSE_GRID)  # [rad]: a model is turned by so much on purpose


def scene_causes(model: mujoco.MjModel, scene: tuple[str, Scene], question: ModelRequest) -> Iterator[str]:
    """Yield differences of a model from a planar machine in axes and links, whether or not it can move.

    Args:
        scene: name of the machine and itself.
    """
    name, machine = scene
    try:
        tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
    except InvalidInput:  # which is what the study says
        return
    yield from tilted_axes(tree)
    yield from axial_gaps(tree)
    if found := _link_differences(model, machine, question):
        more = (
            [f"{len(found) - MAX_NAMED_DIFFERENCES} more distances differ"]
            if len(found) > MAX_NAMED_DIFFERENCES
            else []
        )
        yield f"against {name}, {'; '.join([*(one.words for one in found[:MAX_NAMED_DIFFERENCES]), *more])}"


def refusal_causes(model: mujoco.MjModel, scene: tuple[str, Scene], question: ModelRequest) -> Iterator[str]:
    """Yield differences in axes, links and joints of a model that cannot be moved as the machine is."""
    yield from scene_causes(model, scene, question)
    try:
        tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
    except InvalidInput:
        return
    if question.crank in {joint.name for joint in tree.joints}:
        yield from _other_joints(model, scene, question, tree)


def causes_besides(
    model: mujoco.MjModel, scene: tuple[str, Scene], question: ModelRequest, identity: Identity, given: GivenFrame,
    *, is_machine: bool,
) -> Iterator[str]:  # fmt: skip
    """Yield further explanations of a model that is not the machine, or any if no length explains it.

    A slider-crank's offset and a tilt of its slide are the same machine seen in frames that are turned: which of both
    it is shows in a frame that is given, or is round.
    """
    tilt = _slide_tilt(model, scene[1], question, identity.frame)
    if is_machine:
        tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
        yield from (*axial_gaps(tree), *_other_joints(model, scene, question, tree))
    elif identity.explanations:
        links = _link_differences(model, scene[1], question)
        ground = {joint.name for joint in scene[1].mechanism().joints if _on_ground(joint)}
        turned = identity.frame.rotation - ROUND_ANGLE * round(identity.frame.rotation / ROUND_ANGLE)
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


def _slide_tilt(model: mujoco.MjModel, machine: Scene, question: ModelRequest, frame: Frame) -> float | None:
    """Angle [rad] of the only slide on the ground from the machine's; None unless both have one."""
    tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
    slides = [joint for joint in tree.loop_joints if joint.kind == "slide" and tree.bodies[joint.body].parent == 0]
    right = [joint for joint in machine.mechanism().joints if isinstance(joint, Prismatic) and _on_ground(joint)]
    if len(slides) != 1 or len(right) != 1:
        return None
    axis = forward_kinematics(tree, tree.start[:, None]).axes(slides[0])[:, 0, 0]
    way = np.angle(frame.view.as_complex(axis[None])[0]) - frame.rotation
    return float(np.angle(np.exp(2j * (way - right[0].direction)))) / 2.0


def _link_differences(
    model: mujoco.MjModel, machine: Scene, question: ModelRequest
) -> tuple[LinkDifference | SlideTilt, ...] | None:
    """Differences of links, pins and slides; None if they do not match, or cannot be known."""
    try:
        tree = tree_of(model, data_at_start(model, question.keyframe)[0].qpos)
        points = {place.point: _point(model, place) for place in question.places}
    except InvalidInput:  # which is what the study says
        return None
    if question.crank not in {joint.name for joint in tree.joints}:
        return None
    own, right = links_of(tree, question.crank, points), graph_of(machine.mechanism())
    return None if own is None or right is None else link_differences(own, right)


def _other_joints(
    model: mujoco.MjModel, scene: tuple[str, Scene], question: ModelRequest, tree: SpatialTree
) -> Iterator[str]:
    """Say which joints a model and a machine have, where their links do not match."""
    name, machine = scene
    if describe_closures(model) or graph_of(machine.mechanism()) is None:  # which say why
        return
    if _link_differences(model, machine, question) is not None:
        return
    closures = (COUPLINGS.get(closure.kind, closure.kind) for closure in tree.closures)
    own = _count_words(Counter([*(joint.kind for joint in tree.joints), *closures]))
    right = Counter("pin" if isinstance(joint, Revolute) else "slide" for joint in machine.mechanism().joints)
    yield f"it has other joints than {name}: {own} in place of {_count_words(right)}"


def _count_words(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for name, count in counts.items())


def _point(model: mujoco.MjModel, place: PointPlace) -> SpatialPoint:
    found = find_point(model, place)
    offsets = {"site": model.site_pos, "geom": model.geom_pos}
    return SpatialPoint(found.body, offsets[found.kind][found.index].copy() if found.kind in offsets else np.zeros(3))


def tilted_axes(tree: SpatialTree) -> Iterator[str]:
    """Yield loop hinges not parallel to most of the hinges, and slides not perpendicular to them."""
    found = forward_kinematics(tree, tree.start[:, None])
    axes = {joint.name: found.axes(joint)[:, 0, 0] for joint in tree.loop_joints if joint.kind in ("hinge", "slide")}
    hinges = {joint.name: axes[joint.name] for joint in tree.loop_joints if joint.kind == "hinge"}
    if not hinges:
        return
    across = [axes[joint.name] for joint in tree.loop_joints if joint.kind == "slide"]
    alike = {
        name: sum(_line_angle(axis, other) <= PARALLEL for other in hinges.values())
        + sum(np.pi / 2.0 - _line_angle(axis, slide) <= PARALLEL for slide in across)
        for name, axis in hinges.items()
    }
    most = max(alike, key=lambda name: alike[name])
    for joint in tree.loop_joints:
        if joint.kind == "hinge" and (tilt := _line_angle(axes[joint.name], axes[most])) > PARALLEL:
            if alike[joint.name] == alike[most]:  # which of both is tilted cannot be told
                yield f"the axes of {most} and {joint.name} are {np.degrees(tilt):.3g} deg apart"
            else:
                yield f"the axis of {joint.name} is {np.degrees(tilt):.3g} deg off that of {most}"
        elif joint.kind == "slide" and (tilt := np.pi / 2.0 - _line_angle(axes[joint.name], axes[most])) > PARALLEL:
            yield f"the axis of {joint.name} is {np.degrees(tilt):.3g} deg off the plane across that of {most}"


def axial_gaps(tree: SpatialTree) -> Iterator[str]:
    """Yield connects whose points are apart along the hinges' axis, which no planar motion can close."""
    found = forward_kinematics(tree, tree.start[:, None])
    hinges = [found.axes(joint)[:, 0, 0] for joint in tree.loop_joints if joint.kind == "hinge"]
    for closure in tree.closures if hinges else ():
        if closure.kind == "connect":
            one, other = (found.point(point)[0][:, 0] for point in closure.points)
            if (gap := abs(float(hinges[0] @ (one - other)))) > NUMBER_TOLERANCE * tree.extent:
                yield f"{closure.name} ties points that are {1e3 * gap:.3g} mm apart along the axes of its hinges"


def _line_angle(one: Array, other: Array) -> float:
    """Angle between two lines [rad], from 0 to a right angle."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), abs(one @ other)))
