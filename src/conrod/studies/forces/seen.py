"""What of a wrong mass the forces of a machine see, and what none of them can."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conrod.dynamics.inverse import State
from conrod.dynamics.sensitivity import SEEN, Blind, blind_changes, sensitivities
from conrod.motion import Array
from conrod.scenes import Scene
from conrod.studies.forces.names import GROUPS, quantities_of

SAMPLES = 361
NEAR = 0.02  # [rad], of a change point


@dataclass(frozen=True)
class Effect:
    """What a change of one property of one body makes of the quantities looked at.

    Attributes:
        change: that is to be seen, 1 % of a mass, 1 % of a length, 5 % of an inertia [kg], [m] or [kg m^2].
        quantity: the one that shows it most, and how much of its peak.
        by_group: the largest share of a peak in each group; of contact the rms.
    """

    body: str
    quality: str
    change: float
    quantity: str
    effect: float
    by_group: dict[str, float]

    @property
    def unseen(self) -> bool:
        """Whether none of the quantities depends on the property."""
        return self.effect < SEEN


@dataclass(frozen=True)
class Seen:
    """Of a scene at its constant speed.

    Attributes:
        effects: of each property of each body.
        blind: changes of several properties together that none of the quantities sees.
    """

    effects: tuple[Effect, ...]
    blind: tuple[Blind, ...]


def seen_of(scene: Scene, asked: Sequence[str] = GROUPS) -> Seen:
    """What the quantities of some groups see."""
    kinematics = scene.kinematics
    groups = {g: names for g in asked if (names := quantities_of(kinematics.mechanism, g))}
    names = [name for some in groups.values() for name in some]
    if not names:
        return Seen((), ())
    found = sensitivities(kinematics, even_state(scene))
    effects = []
    for one in found:
        shares = {name: one.effects[name] for name in names}
        most = max(names, key=lambda name: shares[name])
        by_group = {
            group: max(_share(one.derivatives[n], shares[n], group) for n in some) for group, some in groups.items()
        }
        effects.append(Effect(one.body, one.quality, one.change, most, shares[most], by_group))
    together = [blind for blind in blind_changes(found, names) if len(blind.shares) > 1]
    return Seen(tuple(effects), tuple(together))


def even_state(scene: Scene) -> State:
    """A turn, or the one pass, at constant speed; change points are left out."""
    angle = np.linspace(*scene.kinematics.span, SAMPLES)
    angle = angle[~scene.kinematics.near_change(angle, NEAR)]
    still = np.zeros_like(angle)
    return State(angle, still + scene.speed, still, angle / scene.speed)


def _share(derivative: Array, effect: float, group: str) -> float:
    largest = float(np.abs(derivative).max())
    if group != "contact" or largest == 0.0:
        return effect
    return effect * float(np.sqrt(np.mean(derivative**2))) / largest
