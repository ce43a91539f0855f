"""Kinematic mode: the engine's own joints against the exact poses, which proves the model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import KinematicMode, KinematicResult, Lacking, capability
from conrod.engines.engine import default_steps, judged_preset
from conrod.engines.numerics import MEETING
from conrod.runs.comparison import QUANTITIES as COMPARED
from conrod.runs.comparison import size_of
from conrod.runs.outcome import joint_gaps
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.validation.plan import Plan, started
from conrod.studies.validation.results import Tolerance, ValidationResult

# The model is right when its joints, solved by the engine itself, give the exact pose to rounding (guard 4).
KINEMATIC_POSITION, KINEMATIC_VELOCITY, KINEMATIC_DIGITS = 1e-12, 1e-9, 0.1
KINEMATIC_ANGLES = 360


def validate_kinematic(name: str, scene: Scene, engine: Engine[Any]) -> ValidationResult:
    """Prove the model: the engine's own joints against the exact poses, over one turn, or the driver's span."""
    mode, empty = capability(engine, KinematicMode), started(name, scene, engine, None, Plan())
    # Kinematic mode solves the model of a judged preset; what that cannot have, no other can.
    refusal = engine.refusal(scene, engine.presets[judged_preset(engine)](scene, default_steps(scene)))
    if isinstance(mode, Lacking) or refusal:
        refusal = mode.reason if isinstance(mode, Lacking) else refusal
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=refusal or "")
    angle = scene.kinematics.angles(KINEMATIC_ANGLES)
    angle = angle[~scene.kinematics.near_change(angle, MEETING)]
    solved = mode.solve_kinematics(scene, angle)
    exact = scene.motion(angle, scene.speed)
    errors: dict[str, dict[str, Mapping[str, float] | None]] = {}
    for point, (position, velocity) in solved.points.items():
        length, truth = scene.lengths[point], exact.point(point)
        errors[point] = dict.fromkeys(COMPARED)
        errors[point]["position"] = vars(size_of(np.linalg.norm(position - truth.position, axis=1) / length))
        if velocity is not None:
            off = np.linalg.norm(velocity - truth.velocity, axis=1)
            errors[point]["velocity"] = vars(size_of(off / (length * abs(scene.speed))))
    gaps = joint_gaps(scene.kinematics.mechanism, [solved.poses]).values()
    gap = max(float(np.abs(g).max()) for g in gaps) / max(scene.lengths.values())
    closure = {"position": gap, "velocity": None, "acceleration": None}
    result = replace(empty, errors=errors, closure=closure, tolerance=_kinematic_tolerance(scene, solved)).judged()
    other = scene.kinematics.branch(solved.poses) != scene.kinematics.branch_at(angle)
    if not other.any():
        return result
    reason = f"on the other branch at {math.degrees(angle[other.argmax()]):.1f} deg"
    return replace(result, outcome=Outcome.FLIPPED.slug, reason=reason, passed=False)


def _kinematic_tolerance(scene: Scene, solved: KinematicResult) -> Tolerance:
    if solved.shape_error is None:
        reason = "rounding: the engine's own joint equations are solved to the last digit"
        # A machine many times larger than its travel loses digits of the travel, by the ratio of the two.
        kinematics = scene.kinematics
        cancelled = max(1.0, KINEMATIC_DIGITS * kinematics.size / kinematics.travel)
        return Tolerance(KINEMATIC_POSITION * cancelled, KINEMATIC_VELOCITY * cancelled, reason=reason)
    length = max(scene.lengths.values())
    return Tolerance(
        solved.shape_error / length, reason="the collision shape's own error: half a sagitta of its polygon"
    )
