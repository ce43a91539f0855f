"""Times in which the loads of a motion change, which a step has to be short against."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from conrod.exact.dynamics.coordinates import coordinate_jet
from conrod.exact.dynamics.forward import FreeMotion
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import Friction, Law, StrokePulse, TimePulse
from conrod.mechanism.mechanism import Mechanism


def shortest_pulse(mechanism: Mechanism, motion: FreeMotion) -> float:
    """Duration of the shortest pulse of a load [s], at the highest speed at which it acts; inf where none does."""
    times = [math.inf]
    for _, law, (value, rate, _) in _along(mechanism, motion):
        if isinstance(law, TimePulse) and law.start < motion.times[-1]:
            times.append(law.stop - law.start)
        if isinstance(law, StrokePulse):
            acts = (law.start < value) & (value < law.stop) & (rate * law.sense > 0.0)
            speed = float(np.abs(rate[acts]).max(initial=0.0))
            times.append((law.stop - law.start) / speed if speed > 0.0 else math.inf)
    return min(times)


def quickest_reversal(mechanism: Mechanism, motion: FreeMotion) -> tuple[str, float]:
    """Name of the friction whose sign changes in the shortest time, and that time [s]; inf where none changes.

    Friction comes up below its creep, which a rate passes in the creep over its acceleration.
    """
    found = [("", math.inf)]
    for name, law, (_, rate, acceleration) in _along(mechanism, motion):
        if isinstance(law, Friction):
            turns = np.flatnonzero(rate[:-1] * rate[1:] < 0.0)
            steepest = float(np.abs(acceleration[np.concatenate([turns, turns + 1])]).max(initial=0.0))
            found.append((name, law.creep / steepest if steepest > 0.0 else math.inf))
    return min(found, key=lambda one: one[1])


def _along(mechanism: Mechanism, motion: FreeMotion) -> Iterator[tuple[str, Law, tuple[Array, Array, Array]]]:
    """Name and law of each load, and its coordinate with its first and second derivative by time, each (T,)."""
    bodies = pose_jets(mechanism, [motion.poses, motion.rates, 0.5 * motion.accelerations])
    for load in mechanism.loads:
        value, rate, half = (np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients)
        yield load.name, load.law, (value, rate, 2.0 * half)
