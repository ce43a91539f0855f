"""What an engine's errors would be if a wrong mass had made them.

An error that looks like what a wrong mass makes of the forces, by the exact sensitivities, is told as how much of it:
the projection of all errors on its effect. That sees less than a tolerance has to allow, for what an engine does wrong
by itself looks different.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from conrod.dynamics.inverse import State
from conrod.dynamics.sensitivity import sensitivities
from conrod.scenes import Scene
from conrod.studies.forces.measuring import Measured
from conrod.studies.forces.results import LOOKS_LIKE
from conrod.studies.forces.seen import effects_on

SAMPLES = 131072  # at most: with contact single values scatter, and only many of them tell

PARTS = 64  # of a run
SURE = 3.0  # standard errors of the projection have to lie within what it tells, or within what would be told


def likenesses(scene: Scene, measured: Measured, names: Sequence[str]) -> dict[str, float]:
    """By "body.property", how many times the change that is to be seen the errors look like.

    That is 1 % of a mass, 1 % of a length, 5 % of an inertia. What no quantity depends on is not among them,
    nor that for which the errors scatter too much to tell: with contact, where a run has few steps.

    Args:
        names: of the quantities that are looked at; those that are not told are left out.
    """
    told = [name for name in names if name in measured.told]
    some = measured.clear()
    some = some[np.unique(np.linspace(0, len(some) - 1, SAMPLES).astype(int))]
    at = measured.state
    state = State(*(values[some] for values in (at.angle, at.rate, at.acceleration, at.time)))
    peaks = {name: measured.peaks[name][0] for name in told}
    errors = np.concatenate([(measured.told[n][some] - measured.exact[n][some]) / peaks[n] for n in told])
    # At constant speed, as the machine is meant to run: what ripple of the drive would show is not counted.
    seen = {(effect.body, effect.quality) for effect in effects_on(scene, told, measured.peaks) if not effect.unseen}
    found = {}
    for one in sensitivities(scene.kinematics, state):
        effect = np.concatenate([one.derivatives[n] * one.change / peaks[n] for n in told])
        if (one.body, one.quality) in seen and effect.any():
            times = float(errors @ effect / (effect @ effect))
            # Values after each other, and quantities, scatter together: single parts of the run are independent.
            left = ((errors - times * effect) * effect).reshape(len(told), -1).sum(axis=0)
            parts = [part.sum() for part in np.array_split(left, PARTS)]
            scatter = float(np.linalg.norm(parts) / (effect @ effect))
            if SURE * scatter < max(LOOKS_LIKE, abs(times)):
                found[f"{one.body}.{one.quality}"] = times
    return found
