"""The exact forces of a scene, and what errors of forces are divided by."""

from __future__ import annotations

import numpy as np

from conrod.dynamics.inverse import InverseDynamics, State
from conrod.dynamics.sensitivity import SEEN, TORQUE, quantities
from conrod.kinematics import Kinematics
from conrod.motion import Array
from conrod.scenes import Scene

CHUNK = 4096  # samples of which the exact forces are worked out together
SAMPLES = 361
NEAR = 0.02  # [rad], of a change point, where joint forces are not determined


def exact_quantities(kinematics: Kinematics, state: State) -> dict[str, Array]:
    """The exact forces in a motion by quantity, (T,) each."""
    inverse, parts = InverseDynamics(kinematics), []
    for start in range(0, len(state.angle), CHUNK):
        some = slice(start, start + CHUNK)
        one = State(state.angle[some], state.rate[some], state.acceleration[some], state.time[some])
        parts.append(quantities(inverse.forces(one)))
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def even_state(scene: Scene) -> State:
    """A turn, or the one pass, at constant speed; change points are left out."""
    angle = np.linspace(*scene.kinematics.span, SAMPLES)
    angle = angle[~scene.kinematics.near_change(angle, NEAR)]
    still = np.zeros_like(angle)
    return State(angle, still + scene.speed, still, angle / scene.speed)


def peaks_of(scene: Scene) -> dict[str, tuple[float, bool]]:
    """By quantity what errors are divided by, and whether that is its own peak at constant speed.

    What is zero but for rounding has the largest peak of its unit instead, and where moments have none the largest
    force times the size of the machine.
    """
    exact = exact_quantities(scene.kinematics, even_state(scene))
    own = {name: float(np.abs(values).max()) for name, values in exact.items()}
    force = max((peak for name, peak in own.items() if not is_moment(name)), default=0.0) or 1.0
    moment = max((peak for name, peak in own.items() if is_moment(name)), default=0.0)
    lever = force * scene.kinematics.size
    if moment <= SEEN * lever:
        moment = lever
    largest = {True: moment, False: force}
    has = {name: peak > SEEN * largest[is_moment(name)] for name, peak in own.items()}
    return {name: (peak if has[name] else largest[is_moment(name)], has[name]) for name, peak in own.items()}


def is_moment(name: str) -> bool:
    """Whether a quantity is in N m."""
    return name == TORQUE or name.endswith(".moment")
