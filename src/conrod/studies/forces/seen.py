"""Effects of a wrong mass that the forces of a machine detect, and those that none of them can."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from conrod.exact.dynamics.sensitivity import SEEN, Blind, Sensitivity, blind_changes, sensitivities
from conrod.scenes import Scene
from conrod.studies.forces.exact import GROUPS, even_state, peaks_of, quantities_of

Peaks: TypeAlias = Mapping[str, tuple[float, bool]]  # as `peaks_of` gives them


@dataclass(frozen=True)
class Effect:
    """Effect of a change of one property of one body on the measured quantities.

    Attributes:
        change: that is to be seen, 1 % of a mass, 1 % of a length, 5 % of an inertia [kg], [m] or [kg m^2].
        quantity: the one that shows it most, and how much of its peak.
    """

    body: str
    quality: str
    change: float
    quantity: str
    effect: float

    @property
    def unseen(self) -> bool:
        """True if none of the quantities depends on the property."""
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
    """Effects that the quantities of some groups detect."""
    names = [name for group in asked for name in quantities_of(scene.kinematics.mechanism, group)]
    if not names:
        return Seen((), ())
    found = sensitivities(scene.kinematics, even_state(scene))
    together = [blind for blind in blind_changes(found, names) if len(blind.shares) > 1]
    return Seen(_effects(found, names, peaks_of(scene)), tuple(together))


def effects_on(scene: Scene, names: Sequence[str], peaks: Peaks) -> tuple[Effect, ...]:
    """Effect of each property of each body on some quantities, over their peaks."""
    return _effects(sensitivities(scene.kinematics, even_state(scene)), names, peaks)


def _effects(found: Sequence[Sensitivity], names: Sequence[str], peaks: Peaks) -> tuple[Effect, ...]:
    effects = []
    for one in found:
        shares = {n: float(np.abs(one.derivatives[n]).max()) * one.change / peaks[n][0] for n in names}
        most = max(names, key=lambda name: shares[name])
        effects.append(Effect(one.body, one.quality, one.change, most, shares[most]))
    return tuple(effects)
