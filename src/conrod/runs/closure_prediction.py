"""Errors predicted from the joints alone: what an engine's state must be off by, because its joints do not close.

A state that violates the joint equations by a residual r is off, at the crank angle actually reached, by J^-1 r to
first order; the same holds for rates and accelerations with the equations differentiated. No reference motion enters.
If these errors are the ones measured against the exact motion, the difference is the engine's and not the reference's
(docs/design.md, guard 6).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.runs.trajectory import BodyStates, BodyTracks, PointTracks


@dataclass(frozen=True)
class PredictedErrors:
    """Signed errors of one observed point, (T, 2) each [m, m/s, m/s^2], at the instants of the three quantities."""

    position: Array
    velocity: Array
    acceleration: Array


def predicted_errors(
    kinematics: Kinematics, points: Mapping[str, PointTracks], bodies: BodyTracks
) -> Mapping[str, PredictedErrors]:
    """Errors of all observed points from the residuals of the joints: their values minus those of the mended state."""
    position = _mended_points(kinematics, bodies.position, 0)
    velocity = _mended_points(kinematics, bodies.velocity, 1)
    acceleration = _mended_points(kinematics, bodies.acceleration, 2)
    return {
        name: PredictedErrors(
            tracks.position.values - position[name],
            tracks.velocity.values - velocity[name],
            tracks.acceleration.values - acceleration[name],
        )
        for name, tracks in points.items()
    }


def _mended_points(kinematics: Kinematics, states: BodyStates, order: int) -> dict[str, Array]:
    """The derivative of an order of every observed point, after one Newton step on the joints at the measured state."""
    measured = [states.poses, states.rates, states.accelerations][: order + 1]
    at = states.instants
    crank, mended = (at.angle, at.rate, at.acceleration), list[Array]()
    for k, values in enumerate(measured):
        residual = kinematics.residual([*mended, values], crank[k])
        # One Newton step: poses are mended by the Jacobian of the measured ones, rates by that of the mended.
        mended.append(values - kinematics.solve(mended[0] if k else values, residual))
    return {name: values[-1] for name, values in kinematics.point_derivatives(mended).items()}
