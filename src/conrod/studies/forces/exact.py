"""Exact forces of a scene by quantity, what errors of them are divided by, and what they are judged by.

No law of an engine gives a bound on them, as one does for its motion: they are judged by what is required of an
engine at 1000 steps a revolution. With fewer the bar is as much higher as the order of the engine's scheme makes the
error; with more it stays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from conrod.engines.engine import Preset
from conrod.exact.dynamics.inverse import InverseDynamics, State, component_names
from conrod.exact.dynamics.sensitivity import SEEN, TORQUE, quantities, sensitivities
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.exact.reference import ExactReference
from conrod.mechanism.mechanism import CamContact, Mechanism
from conrod.scenes import Scene
from conrod.studies.forces.results import Effect

GROUPS = ("torque", "reactions", "contact")
Peaks: TypeAlias = Mapping[str, tuple[float, bool]]  # as `peaks_of` gives them


def quantities_of(mechanism: Mechanism, group: str) -> tuple[str, ...]:
    """The quantities of a group: "drive torque", or "joint.component".

    The push between cam and roller is the contact; reactions are what all other joints carry.
    """
    if group == "torque":
        return (TORQUE,)
    return tuple(
        f"{joint.name}.{name}"
        for joint in mechanism.joints
        if isinstance(joint, CamContact) == (group == "contact")
        for name in component_names(joint)
    )


def groups_of(mechanism: Mechanism, asked: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the groups asked for that the machine has."""
    return tuple(group for group in asked if quantities_of(mechanism, group))


STEPS = 1000


def tolerance_of(
    mechanism: Mechanism, preset: Preset[Any], steps: int, groups: Mapping[str, object]
) -> tuple[dict[str, float], str]:
    """By group what is allowed, and why; nothing of presets of which nothing is required.

    Args:
        groups: those that are looked at.
    """
    if mechanism.cam_contacts:
        # Where the acceleration jumps all forces do: their largest errors are one step of the jump.
        bar = preset.forces.allowed.get("contact")
        if bar is None or "contact" not in groups:
            return {}, ""
        return {"contact": bar}, "required of the contact force: 2 % rms between the cam's arc joints"
    bars, order = preset.forces.allowed, preset.forces.order
    coarser = max(1.0, STEPS / steps) ** order
    allowed = {group: bar * coarser for group, bar in bars.items() if group in groups}
    required = ", ".join(f"{group} {bars[group]:g}" for group in allowed)
    reason = f"required at {STEPS} steps a revolution: {required}, of the exact peak" if allowed else ""
    return allowed, reason + (
        f"; at {steps} times {coarser:.3g}, by order {order}" if coarser > 1.0 and allowed else ""
    )


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


def even_state(scene: ExactReference) -> State:
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
    """True if a quantity is in N m."""
    return name == TORQUE or name.endswith(".moment")


# -- what forces show of a wrong mass --------------------------------------------------------------------------------


def seen_of(scene: Scene, asked: Sequence[str] = GROUPS) -> tuple[Effect, ...]:
    """Effects of each property of each body on the quantities of some groups, at constant speed."""
    names = [name for group in asked for name in quantities_of(scene.kinematics.mechanism, group)]
    return effects_on(scene, names, peaks_of(scene)) if names else ()


def effects_on(scene: ExactReference, names: Sequence[str], peaks: Peaks) -> tuple[Effect, ...]:
    """Effect of each property of each body on some quantities, over their peaks."""
    effects = []
    for one in sensitivities(scene.kinematics, even_state(scene)):
        shares = {n: float(np.abs(one.derivatives[n]).max()) * one.change / peaks[n][0] for n in names}
        most = max(names, key=lambda name: shares[name])
        effects.append(Effect(one.body, one.quality, one.change, most, shares[most]))
    return tuple(effects)
