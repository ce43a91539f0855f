"""Differences of a model from the machine that it is to be: lengths, axes, anchors and loops."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from conrod.comparison.plain_values import plain_values
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialClosure, SpatialTree, displace
from conrod.exact.space.drive_laws import DriveLaw
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.report.numbers import unequal_quantities

# Numbers of a file with six digits are the same within this share of the machine's extent, or angle [rad].
NUMBER_TOLERANCE = 1e-6
RANDOM_STARTS = 60  # random poses, from which other branches are looked for


@dataclass(frozen=True)
class MachineComparison:
    """Comparison of a model with the machine that it should represent.

    Attributes:
        machine: name of the machine, or its file.
        off: largest distance between the points of both [m]; None if the machine cannot follow the motion.
        point: the point that is off by `off`.
        differences: numbers and loops that the model has otherwise, in words.
        other_kinds: whether a joint or a closure among them is of another kind, wherever the points are.
        closed_form: distance of the model's exact motion from the machine's closed form, over the travel; None where
            it has none.
        other_branch: whether the model is the machine on another assembly branch.
        loads: masses, damping and gravity that the model has otherwise, in words; they do not show in its motion.
    """

    machine: str
    off: float | None
    point: str
    differences: tuple[str, ...]
    other_branch: bool = False
    closed_form: float | None = None
    other_kinds: bool = False
    loads: tuple[str, ...] = ()


def compare_with_machine(
    name: str, model: SpatialTree, machine: SpatialTree, laws: Mapping[str, DriveLaw], held: tuple[str, ...],
    motion: SpatialMotion, inactive: Collection[str] = (), tracked: DrivenTree | None = None,
) -> MachineComparison:  # fmt: skip
    """Compare a model's exact motion with a machine's, at points of the same name, and list differences.

    Args:
        inactive: names of closures that the model has and that do not act.
        tracked: the model with its tracked motion, which is the machine's too where both are the same in every number.

    Raises:
        InvalidInput: model and machine have no point in common, or the machine lacks a driven joint.
    """
    points = [point for point in motion.points if point in machine.points]
    if not points:
        raise InvalidInput(f"it has no site in common with {name}: {', '.join(machine.points)}")
    lacking = [joint for joint in laws if joint not in {j.name for j in machine.joints}]
    if lacking:
        raise InvalidInput(f"{name} has no joint {lacking[0]}: {', '.join(j.name for j in machine.joints)}")
    driven = DrivenTree(machine, laws, held)
    different = (*_other_zeros(model, machine, laws), *list_differences(model, machine, inactive))
    kinds = any(_have_other_kinds(model, machine))
    try:
        start = driven.assemble_start()
        if tracked is not None and _is_tracked(driven, start, float(motion.times[-1]), tracked):
            driven.knots, driven.misfit = tracked.knots, tracked.misfit
        else:
            driven.track_branch(start, float(motion.times[-1]))
    except InvalidInput:
        return MachineComparison(name, None, "", different, other_kinds=kinds)
    exact = driven.motion(motion.times, order=2)
    off = {p: _largest_distance(motion, exact, p) for p in points}
    worst = max(off, key=lambda point: off[point])
    if off[worst] > NUMBER_TOLERANCE * machine.extent and _on_other_branch(driven, motion, exact):
        return MachineComparison(name, off[worst], worst, (), True)
    return MachineComparison(name, off[worst], worst, different, other_kinds=kinds)


def _is_tracked(driven: DrivenTree, start: Array, duration: float, tracked: DrivenTree) -> bool:
    """True if another machine with tracked motion is the same in every number, from its start (nq, 1) on."""
    first, last = tracked.knots[0], tracked.knots[-1]
    return (
        np.array_equal(first.coordinates, start)
        and last.time == duration
        and (tracked.laws, tracked.held) == (driven.laws, driven.held)
        and plain_values(tracked.tree) == plain_values(driven.tree)
    )


def _on_other_branch(driven: DrivenTree, motion: SpatialMotion, exact: SpatialMotion) -> bool:
    """True if a motion is the machine's on another assembly branch, searched from random poses."""
    machine, random = driven.tree, np.random.default_rng(1)
    same = NUMBER_TOLERANCE * machine.extent
    start = {name: found.position[0] for name, found in motion.points.items() if name in machine.points}
    # Where it begins as the machine does it is on the same branch, however it goes on.
    if max(np.abs(exact.points[name].position[0] - place).max() for name, place in start.items()) < same:
        return False
    for _ in range(RANDOM_STARTS):
        way = np.zeros((machine.freedom, 1))
        way[driven.free] = random.uniform(-np.pi, np.pi, (len(driven.free), 1))
        try:
            pose, _ = driven.close_loops(displace(machine, machine.start[:, None], way), 0.0)
            there = forward_kinematics(machine, pose)
            off = [np.abs(there.point(machine.points[name])[0][:, 0] - place).max() for name, place in start.items()]
            if max(off) >= same:
                continue
            driven.track_branch(pose, float(motion.times[-1]))
        except InvalidInput:
            continue
        found = driven.motion(motion.times, order=2)
        return all(_largest_distance(motion, found, name) < same for name in start)
    return False


def _largest_distance(one: SpatialMotion, other: SpatialMotion, point: str) -> float:
    return float(np.linalg.norm(one.points[point].position - other.points[point].position, axis=1).max())


# -- numbers -----------------------------------------------------------------------------------------------------------


def list_differences(model: SpatialTree, machine: SpatialTree, inactive: Collection[str] = ()) -> Iterator[str]:
    """List the differences of a model from a machine, in words.

    Args:
        inactive: names of closures that the model has and that do not act.
    """
    own, theirs = ({body.name: body for body in tree.bodies} for tree in (model, machine))
    yield from (f"{name} is missing" for name in theirs if name not in own)
    yield from (f"{name} is a body more" for name in own if name not in theirs)
    yield from _joint_kinds(model, machine)
    for name, body in own.items():
        if name in theirs:
            yield from _body_changes(body, theirs[name], model.bodies[body.parent].name, machine.extent)
    closures = {closure.name: closure for closure in machine.closures}
    for closure in model.closures:
        if closure.name in closures:
            yield from _closure_changes(model, closure, machine, closures.pop(closure.name))
        else:
            yield f"{closure.name} is a loop more"
    for name in closures:
        yield f"closure {name} is inactive" if name in inactive else f"loop {name} is missing"


def _other_zeros(model: SpatialTree, machine: SpatialTree, laws: Collection[str]) -> Iterator[str]:
    """Driven hinges whose zero angle differs from the machine's."""
    own, theirs = ({joint.name: joint for joint in tree.joints} for tree in (model, machine))
    for name in laws:
        mine, joint = own[name], theirs[name]
        one, two = model.bodies[mine.body], machine.bodies[joint.body]
        if (
            mine.kind == joint.kind == "hinge"
            and _angle(one.turn @ mine.axis, two.turn @ joint.axis) <= NUMBER_TOLERANCE
        ):
            off = _rotation_between(one.turn, two.turn)
            if off > NUMBER_TOLERANCE:
                yield f"{name} is at zero {np.degrees(off):.3g} deg from where the machine has it"


def _have_other_kinds(model: SpatialTree, machine: SpatialTree) -> Iterator[bool]:
    """For each joint and closure that both have: True if their kinds differ."""
    for own, theirs in ((model.joints, machine.joints), (model.closures, machine.closures)):
        kinds = {one.name: one.kind for one in own}
        yield from (kinds.get(one.name, one.kind) != one.kind for one in theirs)


def _joint_kinds(model: SpatialTree, machine: SpatialTree) -> Iterator[str]:
    """Joints that are missing, on another body, of another kind, or too many."""
    own, theirs = ({joint.name: joint for joint in tree.joints} for tree in (model, machine))
    for name, joint in theirs.items():
        body = machine.bodies[joint.body].name
        if (mine := own.get(name)) is None:
            yield f"joint {name} of {body} is missing"
        elif mine.kind != joint.kind:
            yield f"joint {name} is a {mine.kind}, the machine has a {joint.kind}"
        elif (place := model.bodies[mine.body].name) != body:
            yield f"joint {name} moves {place}, in the machine {body}"
    yield from (
        f"{model.bodies[joint.body].name} has a joint more, {name}" for name, joint in own.items() if name not in theirs
    )


COUPLINGS = {"joint": "joint coupling", "tendon": "tendon coupling"}  # closures that tie no points


def _body_changes(body: SpatialBody, theirs: SpatialBody, parent: str, extent: float) -> Iterator[str]:
    if np.abs(body.place - theirs.place).max() > NUMBER_TOLERANCE * extent:
        yield _length_words(parent, body.name, body.place, theirs.place)
    rotates = any(joint.kind != "slide" for joint in (*body.joints, *theirs.joints))
    if not rotates and (turned := _rotation_between(body.turn, theirs.turn)) > NUMBER_TOLERANCE:
        yield f"{body.name} is turned by {np.degrees(turned):.3g} deg on {parent}"
    joints = {joint.name: joint for joint in body.joints}
    for joint in theirs.joints:
        mine = joints.get(joint.name)
        if mine is None or mine.kind != joint.kind:
            continue
        one, two = body.turn @ mine.axis, theirs.turn @ joint.axis
        tilt = _angle(one, two) if joint.kind in ("hinge", "slide") else 0.0
        if tilt > NUMBER_TOLERANCE:
            yield f"the axis of {joint.name} is {np.degrees(tilt):.3g} deg off"
        # A slide moves its body alike wherever its anchor is.
        if (
            joint.kind != "slide"
            and (off := float(np.linalg.norm(mine.anchor - joint.anchor))) > NUMBER_TOLERANCE * extent
        ):
            yield f"{joint.name} is anchored {1e3 * off:.3g} mm off"


def _angle(one: Array, two: Array) -> float:
    """Angle between two vectors (3,) [rad]."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, two)), one @ two))


def _closure_changes(
    model: SpatialTree, closure: SpatialClosure, machine: SpatialTree, theirs: SpatialClosure
) -> Iterator[str]:
    name = closure.name
    if closure.kind != theirs.kind:
        own, right_kind = (COUPLINGS.get(one.kind, one.kind) for one in (closure, theirs))
        yield f"closure {name} is a {own}, the machine has a {right_kind}"
        return
    ends, right = _tied_ends(model, closure), _tied_ends(machine, theirs)
    if ends != right and ends != right[::-1]:
        yield f"{name} ties {' to '.join(ends)}, in the machine {' to '.join(right)}"
        return
    points = closure.points if ends == right else closure.points[::-1]
    for one, two in zip(points, theirs.points, strict=True):
        if np.abs(one.offset - two.offset).max() > NUMBER_TOLERANCE * machine.extent:
            yield _length_words(machine.bodies[two.body].name, name, one.offset, two.offset)
    if closure.turn is not None and theirs.turn is not None:
        turn = closure.turn if ends == right else closure.turn.T
        if (off := _rotation_between(turn, theirs.turn)) > NUMBER_TOLERANCE:
            yield f"{name} holds its bodies turned by {np.degrees(off):.3g} deg from where the machine has them"
    if not closure.points and (closure.polynomial, closure.references) != (theirs.polynomial, theirs.references):
        yield f"{name} has another polynomial"


def _tied_ends(tree: SpatialTree, closure: SpatialClosure) -> tuple[str, ...]:
    """Names of the two bodies, or the two sums of joints, that a closure ties together."""
    if closure.points:
        return tuple(tree.bodies[point.body].name for point in closure.points)
    named = {joint.rate: joint.name for joint in tree.joints}
    sums = [{named[rate]: factor for rate, factor in one.items()} for one in closure.sums]
    words = [" + ".join(n if f == 1.0 else f"{f:g} {n}" for n, f in sorted(one.items())) for one in sums]
    return tuple(one or "a constant" for one in words)


def _rotation_between(one: Array, two: Array) -> float:
    """Angle of the rotation from one rotation matrix (3, 3) to another [rad]."""
    return 2.0 * float(np.arcsin(min(np.linalg.norm(one - two) / 8.0**0.5, 1.0)))


def _length_words(parent: str, name: str, place: Array, theirs: Array) -> str:
    own, right = float(np.linalg.norm(place)), float(np.linalg.norm(theirs))
    aside = np.linalg.norm(np.cross(place, theirs)) > NUMBER_TOLERANCE * max(own * right, 1e-300)
    if aside or right == 0.0:
        return f"{name} is {1e3 * float(np.linalg.norm(place - theirs)):.3g} mm off its place on {parent}"
    share = own / right - 1.0
    way = "longer" if share > 0.0 else "shorter"
    found, expected = unequal_quantities(1e3 * own, 1e3 * right, 6)
    return f"{parent} is {100.0 * abs(share):.3g} % {way} to {name}: {found} mm instead of {expected} mm"
