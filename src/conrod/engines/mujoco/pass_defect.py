"""Motion of closures: integrated however stiff, and bounded under RK4's local errors where an input makes one pass.

With defects e of position and f of velocity a step and unit of crank angle, a closure of time constant c moves by
y' = z + e, z' = -2 z/c - y/c^2 + f. From a start that is closed, y, z and z' are the defects folded with

    (1 + s/c) E and s E,    -(s/c^2) E and (1 - s/c) E,    (s/c - 1)/c^2 E and (s/c - 2)/c E,    E = exp(-s/c),

and f itself in z'. Folding their sizes bounds the errors: what is short beside c leaves little, where the largest value
of a derivative, lasting for ever, would leave much.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from conrod.engines.engine import Machine
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array


class Balance(NamedTuple):
    """inertia x'' + damping x' + stiffness x = pull, of k coordinates."""

    inertia: Array  # (k, k)
    damping: Array  # (k,)
    stiffness: Array  # (k,)
    pull: Array  # (k,)


def integrated(balance: Callable[[float, Array], Balance], samples: int, size: int, step: float) -> tuple[Array, Array]:
    """Coordinates and rates at samples a step [s] apart, (T, k) each, from rest at zero.

    The singly diagonally implicit Runge-Kutta method of two stages and order 2 that is L-stable (Alexander, 1977). A
    balance may change with the coordinates: it is taken at those that the step's start predicts, which keeps the order.

    Args:
        balance: at a time counted in samples, near given coordinates.
    """
    share = 1.0 - math.sqrt(0.5)
    reach = share * step
    places, rates = np.zeros((samples, size)), np.zeros((samples, size))
    identity = np.eye(size)
    for i in range(samples - 1):
        place, rate = places[i], rates[i]
        base_place, base_rate = place, rate
        for part in (share, 1.0):
            at = balance(i + part, place + part * step * rate)
            stiff = at.damping + reach * at.stiffness
            left = at.pull - stiff * base_rate - at.stiffness * base_place
            gain = np.linalg.solve(at.inertia + reach * (identity * stiff), left)
            its_rate = base_rate + reach * gain
            its_place = base_place + reach * its_rate
            if part < 1.0:
                base_rate = rate + (1.0 - share) * step * gain
                base_place = place + (1.0 - share) * step * its_rate
        places[i + 1], rates[i + 1] = its_place, its_rate
    return places, rates


SAMPLES = 1440


def left_of_defects(machine: Machine, local: float, constant: float) -> tuple[float, float, float]:
    """Largest error of position, velocity and acceleration of observed points over their L, by the crank angle.

    Args:
        machine: one that makes a pass.
        local: local error over the fifth derivative of the motion, for a unit of crank angle.
        constant: time constant of the closures [rad].
    """
    start, stop = machine.kinematics.span
    angles = np.linspace(*((start, stop) if machine.speed > 0.0 else (stop, start)), SAMPLES + 1)
    fifth, sixth = (local * sizes for sizes in _sizes(machine.kinematics, angles))
    return largest_errors(fifth, sixth, abs(stop - start) / SAMPLES, constant)


def largest_errors(steady: Array, growing: Array, spacing: float, constant: float) -> tuple[float, float, float]:
    """Bounds on y, z and z' of a closure that starts closed, under defects of no more than given sizes.

    Args:
        steady, growing: sizes of e and f (T,), at equal distances.
        spacing: of the samples [rad].
        constant: time constant of the closure [rad].
    """
    s = spacing * np.arange(len(steady)) / constant
    decay = np.exp(-s)
    kernels = (
        ((1.0 + s) * decay, constant * s * decay),
        (s / constant * decay, np.abs(1.0 - s) * decay),
        (np.abs(s - 1.0) / constant**2 * decay, np.abs(s - 2.0) / constant * decay),
    )
    errors = [_folded(e, steady, spacing) + _folded(f, growing, spacing) for e, f in kernels]
    errors[2] = errors[2] + growing
    position, velocity, acceleration = (float(error.max()) for error in errors)
    return position, velocity, acceleration


def _sizes(kinematics: Kinematics, angles: Array) -> tuple[Array, Array]:
    """Fifth and sixth derivative by the crank angle (T,) of whatever point has the larger one, over its L."""
    points = kinematics.point_derivatives(kinematics.derivatives(angles, 6))
    fifth, sixth = (
        np.array([np.linalg.norm(values[k], axis=1) / kinematics.lengths[name] for name, values in points.items()])
        for k in (5, 6)
    )
    return fifth.max(axis=0), sixth.max(axis=0)


def _folded(kernel: Array, defect: Array, spacing: float) -> Array:
    """Integral of kernel(s) defect(t - s) over s from 0 to t (T,); each interval with the larger of its ends."""
    larger = np.maximum(defect[:-1], defect[1:])
    highest = np.maximum(kernel[:-1], kernel[1:])
    return np.concatenate([[0.0], spacing * np.convolve(highest, larger)[: len(larger)]])
