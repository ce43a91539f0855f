"""Kinematic mode: poses that an engine solves from its joints, compared with exact poses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from conrod.comparison.compare import size_of
from conrod.comparison.outcome import joint_gaps
from conrod.comparison.trajectory import COMPARED_QUANTITIES, Outcome
from conrod.engines import Engine
from conrod.engines.capabilities import KinematicMode, KinematicResult, MissingCapability, capability
from conrod.engines.engine import default_steps, judged_preset
from conrod.engines.numerics import NEAR_CHANGE_POINT
from conrod.exact.link_rotations import rotation_scales
from conrod.exact.motion import Array
from conrod.execution.prediction import merged_misfit, reference_misfit, solved_misfit
from conrod.execution.result import Plan
from conrod.scenes import Scene
from conrod.studies.validation.results import Tolerance, ValidationResult, empty_result

# A model is right if its joints, solved by the engine, give the exact poses to rounding; over L and omega L.
KINEMATIC_POSITION_TOLERANCE, KINEMATIC_VELOCITY_TOLERANCE = 1e-12, 1e-9
CANCELLATION_SHARE = 0.1  # of size / travel, by which cancellation widens both
KINEMATIC_ANGLES = 360


def validate_kinematic(name: str, scene: Scene, engine: Engine[Any]) -> ValidationResult:
    """Prove the model: compare poses that the engine solves from its joints with exact poses."""
    mode, empty = capability(engine, KinematicMode), empty_result(name, scene, engine, None, Plan())
    # Kinematic mode solves the model of a judged preset; a machine that it refuses, every preset refuses.
    refusal = engine.refusal(scene, engine.presets[judged_preset(engine)](scene, default_steps(scene)))
    if isinstance(mode, MissingCapability) or refusal:
        refusal = mode.reason if isinstance(mode, MissingCapability) else refusal
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=refusal or "")
    angle = scene.kinematics.angles(KINEMATIC_ANGLES)
    angle = angle[~scene.kinematics.near_change(angle, NEAR_CHANGE_POINT)]
    solved = mode.solve_kinematics(scene, angle)
    exact = scene.motion(angle, scene.speed)
    errors: dict[str, dict[str, Mapping[str, float] | None]] = {}
    for point, (position, velocity) in solved.points.items():
        length, truth = scene.lengths[point], exact.point(point)
        errors[point] = dict.fromkeys(COMPARED_QUANTITIES)
        errors[point]["position"] = vars(size_of(np.linalg.norm(position - truth.position, axis=1) / length))
        if velocity is not None:
            off = np.linalg.norm(velocity - truth.velocity, axis=1)
            errors[point]["velocity"] = vars(size_of(off / (length * abs(scene.speed))))
    gaps = joint_gaps(scene.kinematics.mechanism, [solved.poses]).values()
    gap = max(float(np.abs(g).max()) for g in gaps) / max(scene.lengths.values())
    closure = {"position": gap, "velocity": None, "acceleration": None}
    misfit = merged_misfit(solved_misfit(scene, angle, solved.poses), reference_misfit(scene))
    tolerance = _kinematic_tolerance(scene, solved)
    links = None if solved.shape_error is not None else _rotation_errors(scene, angle, solved.poses)
    result = replace(
        empty, errors=errors, links=links, closure=closure, tolerance=tolerance, misfit=misfit
    ).with_verdict()
    other = scene.kinematics.branch(solved.poses) != scene.kinematics.branch_at(angle)
    if not other.any():
        return result
    reason = f"on the other branch at {math.degrees(angle[other.argmax()]):.1f} deg"
    return replace(result, outcome=Outcome.FLIPPED.slug, reason=reason, passed=False)


def _rotation_errors(scene: Scene, angle: Array, poses: Array) -> dict[str, dict[str, dict[str, float]]]:
    """Errors of the driven links' rotations, by link, quantity and measure, in solved poses (T, 3 n)."""
    kinematics = scene.kinematics
    off, index = np.abs(poses - kinematics.poses(angle)), kinematics.mechanism.body_index
    return {
        name: {"rotation": vars(size_of(off[:, 3 * index[name] + 2] / scale))}
        for name, scale in rotation_scales(kinematics).items()
    }


def _kinematic_tolerance(scene: Scene, solved: KinematicResult) -> Tolerance:
    """Return the tolerance of kinematic mode: rounding, or half a sagitta of a cam's polygon."""
    if solved.shape_error is None:
        reason = "rounding: the engine's own joint equations are solved to the last digit"
        # A machine much larger than its travel L loses digits by cancellation, by the ratio size / L.
        kinematics = scene.kinematics
        cancelled = max(1.0, CANCELLATION_SHARE * kinematics.size / kinematics.travel)
        position, velocity = KINEMATIC_POSITION_TOLERANCE * cancelled, KINEMATIC_VELOCITY_TOLERANCE * cancelled
        return Tolerance(position, velocity, rotation=position, reason=reason)
    length = max(scene.lengths.values())
    return Tolerance(
        solved.shape_error / length, reason="the collision shape's own error: half a sagitta of its polygon"
    )
