"""Motion of a few coordinates by a method that no stiffness upsets."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from conrod.motion import Array


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
