"""How fast the exact motion changes: what every truncation error is proportional to."""

from __future__ import annotations

import numpy as np

from conrod.kinematics import Kinematics

SAMPLES = 720
# Why there are no bounds for a linkage with a change point: there is no largest motion of links per gap of a joint.
UNDETERMINED = (
    "none at a change point: there any give of the joints, however small, leaves the motion open. A run that completed "
    "went on in the assembly of the exact motion; one that took the other is told as flipped"
)


def largest_derivatives(kinematics: Kinematics, order: int) -> list[float]:
    """Largest k-th derivative by the crank angle of any observed point, over its L; k = 0..order."""
    points = kinematics.point_derivatives(kinematics.derivatives(kinematics.angles(SAMPLES), order))
    sizes = [0.0] * (order + 1)
    for name, derivatives in points.items():
        length = kinematics.lengths[name]
        for k, values in enumerate(derivatives):
            sizes[k] = max(sizes[k], float(np.linalg.norm(values, axis=1).max()) / length)
    return sizes


def rounding(kinematics: Kinematics, steps: int) -> float:
    """Bound on the position error, over L, that rounding alone can sum up to in so many steps."""
    return float(np.finfo(float).eps) * steps * max(1.0, kinematics.size / kinematics.travel)
