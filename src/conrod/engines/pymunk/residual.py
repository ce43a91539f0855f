"""Residual of Chipmunk's iteration: what it left of the joints' gap rates that it was to solve for.

In cpSpaceStep positions move first; then every joint's preStep asks for the gap rate -(1 - bias^h) C / h that mends a
share of its error C there (bias_coef in Chipmunk's constraint headers), and the iteration makes the velocities fit all
of them. Where it is converged, J(x_n) v_n + (1 - bias^h) C(x_n) / h is nothing but rounding.
"""

from __future__ import annotations

import math

import numpy as np

from conrod.engines.massless_rod import DistanceJoint, ModelForm
from conrod.engines.pymunk.points import body_states
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.exact.jet import Jet, square_root
from conrod.exact.joint_equations import PoseJet, joint_residual, pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Joint, Prismatic


def gap_rate_left(form: ModelForm, settings: PymunkSettings, centres: Array, rates: Array) -> float | None:
    """Largest deviation of a joint's gap rate [m/s] from the one asked for, after a step.

    Args:
        centres: centres of gravity with turns (1, 3 n) of the engine's bodies.
        rates: theirs.

    Returns:
        None for contact, whose errors are mended by velocities of their own; and where the state is rounded after
        every step, which leaves more than a converged iteration does, and is none of its doing.
    """
    mechanism = form.mechanism
    if mechanism.cam_contacts or settings.rounded_state:
        return None
    h = settings.substep
    mending = (1.0 - settings.error_bias**h) / h
    bodies = pose_jets(mechanism, list(body_states(mechanism, centres, rates)))
    held = [joint for joint in mechanism.joints if joint.name != mechanism.driver.joint]
    gaps = [_gap(joint, bodies) for joint in held] + [[_lengthening(rod, bodies)] for rod in form.distances]
    return max((math.hypot(*(_rate(gap) + mending * _size(gap) for gap in parts)) for parts in gaps), default=0.0)


def _gap(joint: Joint, bodies: dict[str, PoseJet]) -> list[Jet]:
    """Of a slide its offset alone, as everywhere; it is in metres."""
    parts = joint_residual(joint, bodies)
    return parts[:1] if isinstance(joint, Prismatic) else parts


def _lengthening(rod: DistanceJoint, bodies: dict[str, PoseJet]) -> Jet:
    (ax, ay), (bx, by) = bodies[rod.a].point(rod.point_a), bodies[rod.b].point(rod.point_b)
    dx, dy = bx - ax, by - ay
    return square_root(dx * dx + dy * dy) - rod.length


def _size(gap: Jet) -> float:
    return float(np.asarray(gap.coefficients[0]).item())


def _rate(gap: Jet) -> float:
    return float(np.asarray(gap.coefficients[1]).item())
