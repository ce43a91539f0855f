"""Which length moves a machine's points by how much: sensitivities of the exact motion, and what they add up to."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from conrod.exact.motion import Array
from conrod.own.models.references import ALL_LENGTHS, length_names, paths_of, with_lengths
from conrod.scenes import Scene

# Of the longest length, for central differences of the exact motion: they are right to 1e-9.
DIFFERENCE = 1e-5
ANGLES = 180


def sensitivities(scene: Scene) -> dict[str, Array]:
    """Distance that each length moves each point around the shaft by, over a turn: (points, angles) [m/m].

    Raises:
        InvalidInput: one length cannot be changed alone, as at a change point.
    """
    names = [name for name in length_names(scene) if name != ALL_LENGTHS]
    step = DIFFERENCE * max(abs(scene.parameters[name]) for name in names)
    angle, points = scene.kinematics.angles(ANGLES), tuple(scene.lengths)

    def paths(name: str, by: float) -> Array:
        return paths_of(with_lengths(scene, [name], np.array([scene.parameters[name] + by])), points)(angle)

    return {name: np.abs(paths(name, step) - paths(name, -step)) / (2.0 * step) for name in names}


def shares(slopes: Mapping[str, Array], uncertainties: Mapping[str, float]) -> tuple[float, dict[str, float]]:
    """Standard uncertainty of a place [m] where it is largest, and the share of each length in its square.

    Args:
        uncertainties: standard, of the lengths [m]; one that is not given has none.
    """
    parts = {name: (slope * uncertainties.get(name, 0.0)) ** 2 for name, slope in slopes.items()}
    variance = np.sum(list(parts.values()), axis=0)
    worst = np.unravel_index(int(variance.argmax()), variance.shape)
    whole = float(variance[worst])
    return whole**0.5, {name: float(part[worst]) / (whole or 1.0) for name, part in parts.items()}
