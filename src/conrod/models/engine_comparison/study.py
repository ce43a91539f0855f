"""A user's model with closed loops as the machine in space that engines are given."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.space import SpatialStart, exact_start
from conrod.errors import InvalidInput, OutsideLoopsError, list_names
from conrod.exact.space import SpatialBody
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.exact.space.motion import DrivenTree
from conrod.exact.space.rigid_parts import merge_rigid_parts
from conrod.mjcf.causes import append_causes, describe_closures
from conrod.mjcf.equalities import inactive_words
from conrod.mjcf.loading import OWN_POSE, check_finite, data_at_start, start_words
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.missing_files import load_with_notes
from conrod.mjcf.reading import check_rigid, duration, laws_of, tree_of
from conrod.models.loops.tracking import choose_points, motion_scales, track_motion
from conrod.studies.space.plan import SCALE_SAMPLES, SpatialModel

LEAST_MOTION = 1e-9  # of the extent: a point that moves by less stands still
LEAST_MISFIT = 1e-12  # of the extent: less is rounding


@dataclass(frozen=True, eq=False)
class ReadModel:
    """A user's model, read and ready to be run.

    Attributes:
        model: what engines are given.
        timestep: of the file [s].
        drives: law of each driven joint, as text.
        remarks: what the file has and no engine is given, held joints, and what was found as it was read.
    """

    model: SpatialModel
    timestep: float
    drives: dict[str, str]
    remarks: tuple[str, ...]


def read_model(path: Path, question: LoopRequest, revolutions: int) -> ReadModel:
    """Read a model file as a machine in space, and track its exact motion; call it in a separate process.

    Args:
        revolutions: length of the runs, in periods of the slowest drive.

    Raises:
        InvalidInput: the model cannot be used, its drives are too few or too many, or its loops cannot be closed.
    """
    model, notes = load_with_notes(path, question.unit)
    try:
        check_finite(model)
        check_rigid(model)
        found = _read_compiled(model, question, revolutions)
        return replace(found, remarks=(*found.remarks, *notes))
    except InvalidInput as error:
        words = append_causes(str(error).removeprefix(f"{path}: "), describe_closures(model))
        raise type(error)(f"{path}: {words}") from None


def _read_compiled(model: mujoco.MjModel, question: LoopRequest, revolutions: int) -> ReadModel:
    """Read a compiled model, as `read_model` does."""
    data, key = data_at_start(model, question.keyframe or OWN_POSE)
    tree = tree_of(model, data.qpos)
    if not tree.closures:
        off = inactive_words(model)
        raise (InvalidInput if off else OutsideLoopsError)(f"it has no closed loop{f': {off}' if off else ''}")
    laws, held = laws_of(model, tree, question)
    seconds = revolutions * duration(laws)
    machine = DrivenTree(tree, laws, held)
    moved_start = track_motion(machine, seconds, start_words(model, key), explained=False)
    names = [point.name for point in choose_points(model, machine, question)[1]]
    checked = machine.motion(np.linspace(0.0, seconds, SCALE_SAMPLES), 2)
    scales = motion_scales([checked.points[name] for name in names])
    if scales["position"] <= LEAST_MOTION * tree.extent:
        raise InvalidInput(f"no judged point moves with these drives: {', '.join(names)}")
    start = smaller_start(machine, names, seconds)
    remarks = (
        *([moved_start] if moved_start else []),
        *([f"{list_names(list(held))} held: no loop has them"] if held else []),
        *_contradiction(start),
        *_unused_parts(model),
    )
    own = SpatialModel(start, scales)
    return ReadModel(own, float(model.opt.timestep), {joint: law.text for joint, law in laws.items()}, remarks)


def smaller_start(machine: DrivenTree, names: Sequence[str], seconds: float) -> SpatialStart:
    """Return the exact start of a tracked machine, without bodies that do not move against their parents.

    Args:
        names: of the points that are observed.
        seconds: for which its motion is tracked [s].
    """
    beside = {name for body in machine.tree.bodies for name in _held_beside_others(body, machine.held)}
    points = {name: machine.tree.points[name] for name in names}
    away = [name for name in machine.held if name not in beside]
    tree = merge_rigid_parts(replace(machine.tree, points=points), machine.knots[0].coordinates, away)
    held = [joint for joint in tree.joints if joint.name in beside]
    laws = {j.name: parse_drive_law("hold", j.unit, float(tree.start[j.coordinate]), j.name) for j in held}
    start = exact_start(tree, {**machine.laws, **laws}, names)
    start.machine.track_branch(start.machine.knots[0].coordinates, seconds)
    return start


def _held_beside_others(body: SpatialBody, held: Sequence[str]) -> tuple[str, ...]:
    """Names of a body's held joints, hinges and slides, where another of its joints moves."""
    names = tuple(joint.name for joint in body.joints if joint.name in held)
    return names if len(names) < len(body.joints) else ()


def _contradiction(start: SpatialStart) -> Iterator[str]:
    """Say how far the closures contradict each other, where that is more than rounding."""
    if start.machine.misfit > LEAST_MISFIT * start.tree.extent:
        size = 1e3 * start.machine.misfit
        yield f"its closures contradict each other by {size:.2g} mm: hard constraints cannot keep them all"


def _unused_parts(model: mujoco.MjModel) -> Iterator[str]:
    """Say what a file has that no engine is given, if it has any of it."""
    found = {
        "contacts": bool(np.any(model.geom_contype) and np.any(model.geom_conaffinity)),
        "limits": bool(np.any(model.jnt_limited) or np.any(model.tendon_limited)),
        "springs": bool(np.any(model.jnt_stiffness) or np.any(model.tendon_stiffness)),
        "dry friction": bool(np.any(model.dof_frictionloss) or np.any(model.tendon_frictionloss)),
        "actuators": model.nu > 0,
    }
    if there := [name for name, has in found.items() if has]:
        yield f"no engine is given its {list_names(there)}, which a motion along laws does not need"
